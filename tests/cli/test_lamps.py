#!/usr/bin/env python3
"""The generators of lamps/ and scenes/: each writes the same files on every run; a lamp's scene loads and has the parts that
it promises and closed glass; the rooms load. usage: test_lamps.py SCONCE (the generators are in BUILD_DIR)"""
import collections
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

SCONCE = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else "build/release/sconce")
BUILD = pathlib.Path(os.environ.get("BUILD_DIR", pathlib.Path(SCONCE).parent))
GLASS = {"dielectric", "roughdielectric"}

# emitters: shapes that emit; parts: separate bodies of a mesh; triangles: at least
LAMPS = {
    "demo_lamp": {"emitters": 8, "parts": {"crystals.obj": 153}, "triangles": 25_000},
    "crystal_lamp": {"emitters": 8, "parts": {"crystals.obj": 238}, "triangles": 40_000},
    "statler_lamp": {"emitters": 51, "parts": {"tubes.ply": 51}, "triangles": 60_000},
    "star_lamp": {"emitters": 1, "parts": {"glass.obj": 2, "star_proxy.obj": 1}, "triangles": 192},
    "blossom_lamp": {"emitters": 1, "parts": {"petals.obj": 60}, "triangles": 100_000},
    "feather_lamp": {"emitters": 2, "parts": {"shell.obj": 2}, "triangles": 1_000_000},
    "vintage_lamp": {"emitters": 1, "parts": {"crystals.ply": 144, "bulbs.obj": 24, "flames.obj": 12}, "triangles": 200_000},
}


def triangles_of(path):
    """The triangles of an OBJ or of our binary PLY, by their corners' positions: vertices at one place count as one."""
    if path.suffix == ".ply":
        header, body = path.read_bytes().split(b"end_header\n", 1)
        vertices, faces = (int(line.split()[2]) for line in header.splitlines() if line.startswith(b"element"))
        stride = 4 * header.count(b"property float")
        positions = [body[stride * i:stride * i + 12] for i in range(vertices)]
        indices = (struct.unpack_from("<3i", body, stride * vertices + 13 * i + 1) for i in range(faces))
        return [[positions[corner] for corner in face] for face in indices]
    with open(path) as file:
        lines = [line.split() for line in file]
    positions = [tuple(line[1:]) for line in lines if line[0] == "v"]
    return [[positions[int(corner.split("/")[0]) - 1] for corner in line[1:]] for line in lines if line[0] == "f"]


def count_parts(triangles):
    parent = {}

    def root(v):
        while parent.setdefault(v, v) != v:
            parent[v] = v = parent[parent[v]]
        return v

    for a, b, c in triangles:
        parent[root(a)] = parent[root(b)] = root(c)
    return len({root(v) for v in parent})


def count_open_edges(triangles):
    """Directed edges without their opposite: 0 for a closed mesh of one orientation."""
    edges = collections.Counter((t[i], t[i - 2]) for t in triangles for i in range(3))
    return sum(abs(n - edges.get((b, a), 0)) for (a, b), n in edges.items())


class Lamps(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()

    def tearDown(self):
        self.folder.cleanup()

    def generate(self, name, folder):
        target = pathlib.Path(self.folder.name) / folder
        subprocess.run([BUILD / f"make_{name}", target], check=True)
        return target

    def generate_twice(self, name):
        first, second = self.generate(name, name), self.generate(name, f"{name}_again")
        files = sorted(path.name for path in first.iterdir())
        self.assertEqual(files, sorted(path.name for path in second.iterdir()))
        for file in files:
            self.assertEqual((first / file).read_bytes(), (second / file).read_bytes(), file)
        return first

    def info(self, *arguments):
        result = subprocess.run([SCONCE, "info", *arguments, "--json"], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def test_lamps(self):
        for name, wanted in LAMPS.items():
            with self.subTest(name):
                first = self.generate_twice(name)
                info = self.info(first / f"{name}.xml")
                self.assertEqual(len(info["emitters"]), wanted["emitters"])
                self.assertGreaterEqual(info["triangles"], wanted["triangles"])
                for file, parts in wanted["parts"].items():
                    self.assertEqual(count_parts(triangles_of(first / file)), parts, file)
                self.check_glass(first, name)

    def check_glass(self, folder, name):
        root = ElementTree.parse(folder / f"{name}.xml").getroot()
        types = {bsdf.get("id"): bsdf.get("type") for bsdf in root.iter("bsdf")}
        for shape in root.iter("shape"):
            reference, file = shape.find("ref"), shape.find("string[@name='filename']")
            if file is not None and reference is not None and types[reference.get("id")] in GLASS:
                self.assertEqual(count_open_edges(triangles_of(folder / file.get("value"))), 0, file.get("value"))

    def test_rooms(self):
        places = [f"-D{name}={self.generate_twice(name)}" for name in ("furniture", "textures")]
        lamp = self.generate("demo_lamp", "lamp") / "demo_lamp.xml"
        rooms = sorted((pathlib.Path(__file__).resolve().parents[2] / "scenes").glob("*.xml"))
        self.assertGreaterEqual(len(rooms), 8)
        for room in rooms:
            with self.subTest(room.stem):
                info = self.info(room, f"-Dlamp={lamp}", *places)
                self.assertEqual(sum(shape["id"] == "crystals" for shape in info["shapes"]), 1)

    def test_messages(self):
        result = subprocess.run([BUILD / "make_demo_lamp"], capture_output=True, text=True)
        self.assertEqual((result.returncode, result.stderr), (2, "usage: make_demo_lamp FOLDER\n"))
        result = subprocess.run([BUILD / "make_demo_lamp", "/proc/none/lamp"], capture_output=True, text=True)
        self.assertEqual(result.returncode, 1)
        self.assertIn("cannot create the folder /proc/none/lamp", result.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
