#!/usr/bin/env python3
"""sconce figures with a room and a lamp of our own: pictures, numbers, page, resuming, Ctrl-C. usage: test_figures.py SCONCE"""
import base64
import html.parser
import json
import os
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

SCONCE = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else "build/release/sconce")

LAMP = """<scene version="3.0.0">
    <shape type="sphere"><float name="radius" value="0.1"/><emitter type="area"><rgb name="radiance" value="30, 20, 10"/></emitter></shape>
    <shape type="sphere"><float name="radius" value="0.3"/><bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf></shape>
    <shape type="sphere"><float name="radius" value="0.27"/><boolean name="flip_normals" value="true"/>
        <bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf></shape>
</scene>"""
ROOM = """<scene version="3.0.0">
    <default name="lamp" value="none"/><default name="keep" value="none"/><default name="appearance" value="neural"/>
    <default name="size" value="1"/><default name="furniture" value=""/><default name="textures" value=""/>
    <integrator type="path"><integer name="max_depth" value="8"/></integrator>
    <sensor type="perspective"><float name="fov" value="60"/>
        <transform name="to_world"><lookat origin="0, 0.2, 2.4" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>
    <shape type="cube"><transform name="to_world"><scale value="2.5"/></transform>
        <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.4, 0.3"/></bsdf></bsdf></shape>
    <shape type="luminaire"><string name="filename" value="$lamp"/><string name="keep" value="$keep"/>
        <string name="appearance" value="$appearance"/><transform name="to_world"><scale value="$size"/></transform></shape>
</scene>"""
LAMPS = {"demo_lamp": "demo_room", "blossom_lamp": "diffuse_box", "vintage_lamp": "living_room"}


class References(html.parser.HTMLParser):
    """Everything that a page would fetch, and its pictures."""

    def __init__(self):
        super().__init__()
        self.outside, self.pictures = [], []

    def handle_starttag(self, tag, attributes):
        if tag in ("script", "link", "iframe"):
            self.outside.append(tag)
        for name, value in attributes:
            if name in ("src", "href", "srcset", "data", "poster", "background"):
                if value.startswith("data:image/png;base64,"):
                    self.pictures.append(base64.b64decode(value.split(",")[1], validate=True))
                else:
                    self.outside.append(value)


class Figures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        (cls.path / "data/scenes").mkdir(parents=True)
        (cls.path / "data/lamps/baked").mkdir(parents=True)
        for lamp, room in LAMPS.items():
            (cls.path / "data/lamps" / lamp).mkdir()
            (cls.path / "data/lamps" / lamp / f"{lamp}.xml").write_text(LAMP)
            (cls.path / "data/scenes" / f"{room}.xml").write_text(ROOM)
        cls.bake("demo_lamp", 0)
        baked = (cls.path / "data/lamps/baked/demo_lamp.safetensors").read_bytes()
        for lamp in LAMPS:
            (cls.path / f"data/lamps/baked/{lamp}.safetensors").write_bytes(baked)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def bake(cls, lamp, seed):
        subprocess.run([SCONCE, "bake", f"data/lamps/{lamp}/{lamp}.xml", "-o", f"data/lamps/baked/{lamp}.safetensors", "--seconds", "3",
                        "--seed", str(seed), "-q"], cwd=cls.path, check=True, timeout=300, capture_output=True)

    def figures(self, *arguments, code=0):
        result = subprocess.run([SCONCE, "figures", "--data", "data", "--scale", "0.003", "--quiet", *arguments], cwd=self.path,
                                capture_output=True, text=True, timeout=600)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return json.loads(result.stdout) if code == 0 and "--json" in arguments else result

    def test_figures(self):
        names = ["4", "6", "8", "13", "15", "16", "ablation_sampling"]
        result = self.figures("-o", "out/figures", "--only", ",".join(names), "--json")
        figures = {figure["figure"]: figure for figure in result["figures"]}
        self.assertEqual(sorted(figures), sorted(names))
        pictures = []
        for figure in figures.values():
            self.assertTrue(figure["title"] and figure["caption"])
            tables = [piece for piece in figure["content"] if "rows" in piece]
            self.assertTrue(tables)
            for table in tables:
                self.assertTrue(table["rows"])
                for row in table["rows"]:
                    self.assertEqual(set(row), {"name"} | {column["key"] for column in table["columns"]})
            pictures += [picture["file"] for piece in figure["content"] for picture in piece.get("pictures", [])]
            with open(self.path / f"out/figures/figure_{figure['figure']}.json") as kept:
                self.assertEqual(json.load(kept), figure)
        for name in pictures:
            self.assertEqual((self.path / "out/figures" / name).read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        page = References()
        page.feed((self.path / result["page"]).read_text())
        self.assertEqual(page.outside, [])
        self.assertEqual(len(page.pictures), len(pictures))
        for png in page.pictures:
            width, height = struct.unpack(">II", png[16:24])
            self.assertGreaterEqual(max(width, height), 16)
        self.assertNotRegex((self.path / result["page"]).read_text(), r"https?://|url\(")

        # In equal time the path tracer, which meets the emitter behind its glass by chance only, is the worst.
        equal = [piece for piece in figures["16"]["content"] if "rows" in piece][0]["rows"]
        self.assertEqual([row["name"] for row in equal], ["baked lamp, path", "geometry, bdpt", "geometry, path", "reference"])
        self.assertTrue(all(row["samples"] >= 1 for row in equal))
        self.assertLess(equal[0]["rel_mse"], equal[2]["rel_mse"])
        # The bake measured the same variances by random samples at points of its own.
        info = json.loads(subprocess.run([SCONCE, "info", "data/lamps/baked/demo_lamp.safetensors"], cwd=self.path, capture_output=True,
                                         check=True).stdout)
        measured = info["metadata"]["bake.evaluation"]
        for row in figures["6"]["content"][-1]["rows"]:
            self.assertLess(row["exact_image"], row["uniform"])
            for ours, theirs in (("ours", "sample_variance"), ("uniform", "sample_variance_uniform")):
                self.assertTrue(0.4 < row[ours] / measured[theirs] < 2.5, (ours, row[ours], measured[theirs]))

        # Smaller pixels sample better and leave less bias.
        rows = figures["ablation_sampling"]["content"][0]["rows"][:3]
        self.assertEqual([row["name"][-2:] for row in rows], ["x8", "16", "32"])
        for coarse, fine in zip(rows, rows[1:]):
            self.assertGreater(coarse["variance"], fine["variance"])
            self.assertGreater(coarse["glossy_bias"], fine["glossy_bias"])

        # Nothing is made twice.
        before = {path: path.stat().st_mtime_ns for path in (self.path / "out/figures").rglob("*") if path.suffix != ".html"}
        again = self.figures("-o", "out/figures", "--only", ",".join(names), "--json")
        self.assertEqual(again, result)
        after = {path: path.stat().st_mtime_ns for path in (self.path / "out/figures").rglob("*") if path.suffix != ".html"}
        self.assertEqual(after, before)

        # Another baked lamp: figures are made anew, and of the renderings those that show it.
        self.bake("demo_lamp", 1)
        self.figures("-o", "out/figures", "--only", "13,16", "--json")
        anew = {path.name for path in (self.path / "out/figures/kept").iterdir() if before.get(path) != path.stat().st_mtime_ns}
        self.assertIn("demo_room_ours.exr", anew)
        self.assertNotIn("demo_room_reference.exr", anew)
        self.assertFalse([name for name in anew if name.startswith("diffuse_box")])

    def test_ctrl_c_leaves_a_page(self):
        process = subprocess.Popen([SCONCE, "figures", "--data", "data", "--scale", "0.02", "--only", "13,16", "-o", "out/stopped"],
                                   cwd=self.path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        kept = self.path / "out/stopped/kept/diffuse_box_reference.json"
        for _ in range(1200):
            if kept.exists() or process.poll() is not None:
                break
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        _, messages = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 1, messages)
        self.assertRegex(messages, r"stopped with [01] of 2 figures")
        self.assertIn("</html>", (self.path / "out/stopped/figures.html").read_text())
        self.assertEqual([path.name for path in (self.path / "out/stopped").rglob("*unfinished*")], [])
        stamp = kept.stat().st_mtime_ns
        result = self.figures("-o", "out/stopped", "--scale", "0.02", "--only", "13", "--json")
        self.assertEqual(kept.stat().st_mtime_ns, stamp)
        self.assertEqual(len(result["figures"]), 1)

    def test_wrong_names(self):
        self.assertRegex(self.figures("--only", "4,99", code=1).stderr, r"no figure '99'; there are .*\b13\b")
        self.assertEqual(self.figures("--scale", "0", code=2).stdout, "")
        message = self.figures("--only", "18", code=1).stderr
        self.assertRegex(message, r"crystal_lamp.* is missing; lamps/bake_all.sh")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
