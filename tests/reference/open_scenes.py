#!/usr/bin/env python3
"""Every lamp and every room opens in Mitsuba 3: the rooms with their lamp's own shapes in place of the luminaire, which
Mitsuba does not know.

    open_scenes.py PROGRAM      (what the generators wrote is looked for beside the program)"""
import pathlib
import re
import sys
import unittest
import xml.etree.ElementTree as ElementTree

import mitsuba as mi

mi.set_variant("scalar_rgb")
ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/sconce").resolve().parent


def read(path, definitions, prefix=""):
    """The scene's root with variables replaced, file names absolute and `prefix` before every id."""
    root = ElementTree.parse(path).getroot()
    values = {item.get("name"): item.get("value") for item in root.findall("default")} | definitions
    for item in root.findall("default"):
        root.remove(item)
    for item in root.iter():
        for key, value in item.attrib.items():
            value = re.sub(r"\$(\w+)", lambda match: values[match.group(1)], value)
            item.set(key, prefix + value if key == "id" else value)
        if item.get("name") == "filename":
            item.set("value", str((path.parent / item.get("value")).resolve()))
    return root


def expand(room):
    """Replaces the luminaires by the shapes of their lamps."""
    for luminaire in room.findall("shape[@type='luminaire']"):
        room.remove(luminaire)
        lamp = read(pathlib.Path(luminaire.find("string[@name='filename']").get("value")), {}, "lamp_")
        for item in lamp:
            if item.tag not in ("shape", "bsdf"):
                continue
            if item.tag == "shape" and item.find("transform") is None:
                item.extend(luminaire.findall("transform"))
            room.append(item)
    return room


class Scenes(unittest.TestCase):
    def opens(self, root):
        for name in ("width", "height"):
            root.find(f".//film/integer[@name='{name}']").set("value", "8")
        scene = mi.load_string(ElementTree.tostring(root, encoding="unicode"))
        self.assertEqual(len(scene.emitters()), len(root.findall("shape/emitter")))
        mi.render(scene, spp=1)

    def test_lamps(self):
        lamps = sorted((BUILD / "lamps").glob("*/*.xml"))
        self.assertGreaterEqual(len(lamps), 7)
        for path in lamps:
            with self.subTest(path.stem):
                self.opens(read(path, {}))

    def test_rooms(self):
        places = {name: str(BUILD / "scenes" / name) for name in ("furniture", "textures")}
        for path in sorted((ROOT / "scenes").glob("*.xml")):
            with self.subTest(path.stem):
                lamp = BUILD / "lamps/demo_lamp/demo_lamp.xml"
                self.opens(expand(read(path, places | {"lamp": str(lamp)})))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
