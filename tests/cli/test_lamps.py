#!/usr/bin/env python3
"""The generators of lamps/: each writes the same files on every run, a scene that loads, with the parts it promises and
closed glass. usage: test_lamps.py SCONCE (the generators are in BUILD_DIR)"""
import collections
import json
import os
import pathlib
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
}


def triangles_of(path):
    with open(path) as file:
        return [[int(corner.split("/")[0]) for corner in line.split()[1:]] for line in file if line.startswith("f ")]


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

    def test_lamps(self):
        for name, wanted in LAMPS.items():
            with self.subTest(name):
                first, second = self.generate(name, name), self.generate(name, f"{name}_again")
                files = sorted(path.name for path in first.iterdir())
                self.assertEqual(files, sorted(path.name for path in second.iterdir()))
                for file in files:
                    self.assertEqual((first / file).read_bytes(), (second / file).read_bytes(), file)

                info = json.loads(subprocess.run([SCONCE, "info", first / f"{name}.xml", "--json"], check=True, capture_output=True).stdout)
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

    def test_messages(self):
        result = subprocess.run([BUILD / "make_demo_lamp"], capture_output=True, text=True)
        self.assertEqual((result.returncode, result.stderr), (2, "usage: make_demo_lamp FOLDER\n"))
        result = subprocess.run([BUILD / "make_demo_lamp", "/proc/none/lamp"], capture_output=True, text=True)
        self.assertEqual(result.returncode, 1)
        self.assertIn("cannot create the folder /proc/none/lamp", result.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
