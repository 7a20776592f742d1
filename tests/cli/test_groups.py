#!/usr/bin/env python3
"""Groups of emitters from outside: a lamp baked by groups, dimmed and tinted in a room. usage: test_groups.py SCONCE"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCONCE = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else "build/release/sconce")

LAMP = """<scene version="3.0.0">
<shape type="sphere" id="bulb.001"><point name="center" x="0.15" y="0" z="0"/><float name="radius" value="0.1"/>
    <emitter type="area"><rgb name="radiance" value="30, 20, 10"/></emitter></shape>
<shape type="sphere" id="spot"><point name="center" x="-0.2" y="0.1" z="0"/><float name="radius" value="0.06"/>
    <emitter type="area"><rgb name="radiance" value="10, 40, 90"/></emitter></shape>
<shape type="sphere"><float name="radius" value="0.4"/>
    <bsdf type="thindielectric"/></shape>
</scene>
"""
ROOM = """<scene version="3.0.0">
    <default name="lamp" value="lamp.safetensors"/>
    <default name="groups" value=""/>
    <default name="keep" value="none"/>
    <default name="appearance" value="neural"/>
    <default name="size" value="1"/>
    <sensor type="perspective">
        <float name="fov" value="60"/>
        <transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 3" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="48"/></film>
        <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
    </sensor>
    <shape type="cube"><transform name="to_world"><scale value="3"/></transform>
        <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.4"/></bsdf></bsdf></shape>
    <shape type="luminaire">
        <string name="filename" value="$lamp"/>
        <string name="groups" value="$groups"/>
        <string name="keep" value="$keep"/><string name="appearance" value="$appearance"/>
        <transform name="to_world"><scale value="$size"/></transform>
    </shape>
</scene>
"""


def luminance(rgb):
    return 0.212671 * rgb[0] + 0.715160 * rgb[1] + 0.072169 * rgb[2]


class Groups(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        (cls.path / "lamp.xml").write_text(LAMP)
        (cls.path / "room.xml").write_text(ROOM)
        for groups in "named", "none":
            cls.sconce("bake", "lamp.xml", "-o", "lamp.safetensors" if groups == "named" else "whole.safetensors", "--groups", groups,
                       "--quality", "draft", "--view", "none", "-q")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def sconce(cls, *arguments, code=0):
        result = subprocess.run([SCONCE, *map(str, arguments)], capture_output=True, text=True, timeout=900, cwd=cls.path)
        assert result.returncode == code, f"{arguments}: exit {result.returncode}\n{result.stdout}{result.stderr}"
        return result

    def mean(self, groups, *options):
        """Of the picture, which shows a wall that the lamp lights."""
        out = self.sconce("render", "room.xml", f"-Dgroups={groups}", "-i", "path", "-o", "out.exr", "--json", "-q", *options).stdout
        return json.loads(out)["mean"]

    def assert_close(self, values, expected, tolerance, message=None):
        for value, wanted in zip(values, expected):
            self.assertLess(abs(value - wanted), tolerance * max(expected), message)

    def test_info(self):
        info = json.loads(self.sconce("info", "lamp.safetensors").stdout)
        self.assertEqual([group["name"] for group in info["groups"]], ["bulb", "spot"])
        for group in info["groups"]:
            self.assertAlmostEqual(group["lumens"] / (683 * luminance(group["flux"])), 1, 3)
        self.assertAlmostEqual(info["lumens"] / sum(group["lumens"] for group in info["groups"]), 1, 3)
        self.assertEqual([group["name"] for group in info["metadata"]["bake.groups"]], ["bulb", "spot"])
        for group in info["metadata"]["bake.groups"]:
            for error in group["flux_error"]:
                self.assertLess(abs(error), 0.03)
        self.assertNotIn("groups", json.loads(self.sconce("info", "whole.safetensors").stdout))

    def test_the_room_is_lit_as_by_the_geometry(self):
        for groups in "", "bulb=0", "spot=0", "bulb=0.3:0.5:2; spot=3":
            baked, traced = self.mean(groups), self.mean(groups, "-Dlamp=lamp.xml", "-i", "bdpt")
            self.assert_close(baked, traced, 0.06, groups)
        self.assertEqual(max(self.mean("bulb=0,spot=0")), 0)

    def test_the_sum_is_exact(self):
        both, bulb, spot = self.mean(""), self.mean("spot=0"), self.mean("bulb=0")
        self.assert_close([a + b for a, b in zip(bulb, spot)], both, 0.02)
        self.assert_close(self.mean("all=0.25"), [v / 4 for v in both], 0.005)
        self.assert_close(self.mean("all=0.25", "-Dlamp=whole.safetensors"), [v / 4 for v in both], 0.02)

    def test_lumens_and_kelvin(self):
        lumens = json.loads(self.sconce("info", "lamp.safetensors").stdout)["lumens"]
        both = self.mean("")
        self.assert_close(self.mean("all=500lm"), [v * 500 / lumens for v in both], 0.01)
        # Twice as large it sends four times the flux, unless the lumens are said.
        plain, large = self.mean("all=500lm"), self.mean("all=500lm", "-Dsize=0.5")
        self.assertLess(abs(luminance(large) / luminance(plain) - 1), 0.05)
        warm, cold = self.mean("all=2700K"), self.mean("all=9000K")
        self.assertGreater(warm[0] / warm[2], 3)
        self.assertLess(cold[0] / cold[2], 1)
        for mean in warm, cold:
            self.assertLess(abs(luminance(mean) / luminance(both) - 1), 0.02)
        traced = self.mean("all=2700K", "-Dlamp=lamp.xml", "-i", "bdpt")
        self.assert_close(traced, warm, 0.06)

    def test_what_is_kept_is_dimmed_alike(self):
        groups = "bulb=0.2:1:2; spot=4"
        baked = self.mean(groups)
        self.assert_close(self.mean(groups, "-Dappearance=geometry", "-Dkeep=all"), baked, 0.06)
        self.assert_close(self.mean(groups, "--unbiased"), baked, 0.08)
        self.assert_close(self.mean("all=0.5", "-Dlamp=whole.safetensors", "--unbiased"), [v / 2 for v in self.mean("")], 0.08)

    def test_errors(self):
        cases = [("lamp.safetensors", "bulp=1", "this lamp has bulb, spot"), ("lamp.xml", "bulp=1", "this lamp has bulb, spot"),
                 ("whole.safetensors", "bulb=1", "--groups"), ("lamp.safetensors", "bulb=bright", "no setting"),
                 ("lamp.safetensors", "bulb", "NAME=SETTING"), ("lamp.xml", "spot=1;spot=2", "twice")]
        for lamp, groups, expected in cases:
            message = self.sconce("render", "room.xml", f"-Dlamp={lamp}", f"-Dgroups={groups}", "-o", "bad.exr", code=1).stderr
            self.assertIn("room.xml:17:9:", message)
            self.assertIn(expected, message)
            self.assertFalse((self.path / "bad.exr").exists())
        self.mean("bulb.001=0", "-Dlamp=lamp.xml")  # geometry knows the full ids too
        (self.path / "comma.xml").write_text(LAMP.replace("bulb.001", "a,b"))
        self.assertIn("cannot name a group", self.sconce("bake", "comma.xml", "--groups", "named", "-q", code=1).stderr)
        self.assertIn("--groups takes", self.sconce("bake", "lamp.xml", "--groups", "some", code=2).stderr)
        self.sconce("bake", "lamp.xml", "--groups", "each", "--preset", "paper", code=2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
