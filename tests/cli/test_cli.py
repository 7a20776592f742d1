#!/usr/bin/env python3
"""The program from outside: exit codes, messages with their place, determinism, Ctrl-C, full disks. usage: test_cli.py SCONCE"""
import json
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SCONCE = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else "build/release/sconce")

ROOM = """<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="50"/>
        <transform name="to_world"><lookat origin="0, 1, 4" target="0, 0.5, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="32"/></film>
        <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.5, 0.4"/></bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="0" y="1.2" z="0"/><float name="radius" value="0.2"/>
        <emitter type="area"><rgb name="radiance" value="10, 9, 8"/></emitter>
    </shape>
</scene>
"""


class Program(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, text):
        (self.path / name).write_text(text)
        return str(self.path / name)

    def run_sconce(self, *arguments, code=0, **options):
        result = subprocess.run([SCONCE, *map(str, arguments)], capture_output=True, text=True, timeout=300, cwd=self.path, **options)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def render(self, scene, output, *arguments, **options):
        return self.run_sconce("render", scene, "-o", self.path / output, "-q", *arguments, **options)

    def test_usage_errors_have_exit_code_2(self):
        for arguments in ([], ["nonsense"], ["render"], ["render", "a.xml", "--spp", "x"], ["render", "a.xml", "--spp", "0"],
                          ["render", "a.xml", "--size", "12"], ["render", "a.xml", "-D", "lamp"], ["compare", "a.exr"],
                          ["bake", "a.xml", "--quality", "best"], ["render", "a.xml", "--unknown-option"],
                          ["render", "a.xml", "--spp", "3", "--seconds", "4"]):
            result = self.run_sconce(*arguments, code=2)
            self.assertTrue(result.stderr, arguments)
            self.assertEqual(result.stdout, "", arguments)

    def test_help_comes_from_the_tables(self):
        text = self.run_sconce("help").stdout
        for kind in ("bsdf", "shape", "emitter", "texture", "sensor"):
            self.assertIn(kind, text)
        text = self.run_sconce("help", "bsdf", "roughdielectric").stdout
        for parameter in ("alpha", "int_ior", "specular_transmittance"):
            self.assertIn(parameter, text)
        self.assertIn("roughdielectric", self.run_sconce("help", "bsdf", "roughdielectrc", code=1).stderr)
        self.assertIn("--spp", self.run_sconce("render", "--help").stdout)

    def test_render_writes_a_picture_and_json(self):
        scene = self.write("room.xml", ROOM)
        result = json.loads(self.render(scene, "a.exr", "--json", "--png", self.path / "a.png").stdout)
        self.assertEqual((result["width"], result["height"], result["samples"]), (48, 32, 4))
        self.assertGreater(min(result["mean"]), 0)
        info = json.loads(self.run_sconce("info", self.path / "a.exr").stdout)
        self.assertIn("variance.R", [channel["name"] for channel in info["channels"]])
        for channel, mean in zip(info["channels"], result["mean"]):
            self.assertAlmostEqual(channel["mean"], mean, delta=1e-4 * abs(mean))
        self.assertEqual((self.path / "a.png").read_bytes()[:4], b"\x89PNG")
        info = json.loads(self.run_sconce("info", scene).stdout)
        self.assertEqual([shape["type"] for shape in info["shapes"]], ["rectangle", "sphere"])

    def test_same_picture_for_any_number_of_threads(self):
        scene = self.write("room.xml", ROOM)
        for integrator in ("path", "bdpt", "particle"):
            pictures = []
            for threads in (1, 2, 3):
                self.render(scene, "a.exr", "-i", integrator, "-t", threads, "--seed", 7)
                pictures.append((self.path / "a.exr").read_bytes())
            self.assertEqual(len(set(pictures)), 1, integrator)
            self.render(scene, "a.exr", "-i", integrator, "--seed", 8)
            self.assertNotEqual((self.path / "a.exr").read_bytes(), pictures[0], integrator)

    def test_exact_shares_no_light(self):
        walls = '<shape type="cube"><transform name="to_world"><scale value="5"/></transform><boolean name="flip_normals" value="true"/></shape>'
        scene = self.write("room.xml", ROOM.replace('name="max_depth" value="6"', 'name="max_depth" value="-1"').replace("</scene>", walls + "</scene>"))
        shared, exact = (json.loads(self.render(scene, name, "--json", "--spp", 64, "--seed", 3, *more).stdout)["mean"]
                         for name, more in (("a.exr", ()), ("b.exr", ("--exact",))))
        self.assertNotEqual(shared, exact)
        for a, b in zip(shared, exact):
            self.assertAlmostEqual(a, b, delta=0.03 * b)

    def test_size_override_keeps_the_picture(self):
        scene = self.write("room.xml", ROOM)
        means = [json.loads(self.render(scene, "a.exr", "--json", "--size", size, "--spp", 64).stdout)["mean"] for size in ("48x32", "24x16")]
        for a, b in zip(*means):
            self.assertAlmostEqual(a, b, delta=0.05 * a)

    def test_errors_have_their_place(self):
        cases = {
            "misspelt parameter": (ROOM.replace('name="radius"', 'name="raduis"'), ["room.xml:14:", "raduis", "radius"]),
            "misspelt type": (ROOM.replace('type="diffuse"', 'type="difuse"'), ["room.xml:11:", "difuse", "diffuse"]),
            "undefined reference": (ROOM.replace("<bsdf type", '<ref id="nobody"/><bsdf type'), ["room.xml:11:", "nobody"]),
            "undefined variable": (ROOM.replace('value="0.2"', 'value="$size"'), ["room.xml:14:", "size"]),
            "not a number": (ROOM.replace('value="0.2"', 'value="nan"'), ["room.xml:14:", "nan"]),
            "out of range": (ROOM.replace('value="0.2"', 'value="-1"'), ["room.xml:14:", "radius"]),
            "broken markup": (ROOM.replace("</shape>\n</scene>", "</scene>"), ["room.xml:"]),
            "missing mesh": (ROOM.replace('<shape type="sphere">', '<shape type="obj"><string name="filename" value="gone.obj"/></shape><shape type="sphere">'),
                             ["room.xml:13:", "gone.obj"]),
            "cyclic include": (ROOM.replace("<shape type=\"rect", '<include filename="room.xml"/><shape type="rect'), ["room.xml:", "include"]),
        }
        for name, (text, expected) in cases.items():
            scene = self.write("room.xml", text)
            message = self.render(scene, "a.exr", code=1).stderr
            for part in expected:
                self.assertIn(part, message, name)
            self.assertFalse((self.path / "a.exr").exists(), name)

    def test_definitions_both_ways_and_skip_missing(self):
        text = ROOM.replace("<shape type=\"rect", '<default name="size" value="0.2"/><shape type="rect').replace('value="0.2"/>\n        <emitter', 'value="$size"/>\n        <emitter')
        text = text.replace('<shape type="sphere">', '<shape type="obj"><string name="filename" value="gone.obj"/></shape><shape type="sphere">')
        scene = self.write("room.xml", text)
        self.render(scene, "a.exr", "--skip-missing", "-Dsize=0.4")
        self.render(scene, "b.exr", "--skip-missing", "-D", "size=0.4")
        self.render(scene, "c.exr", "--skip-missing")
        read = lambda name: (self.path / name).read_bytes()
        self.assertEqual(read("a.exr"), read("b.exr"))
        self.assertNotEqual(read("a.exr"), read("c.exr"))

    def test_compare(self):
        scene = self.write("room.xml", ROOM)
        self.render(scene, "a.exr", "--spp", 16)
        self.render(scene, "b.exr", "--spp", 16, "--seed", 5)
        same = json.loads(self.run_sconce("compare", "a.exr", "a.exr", "--json").stdout)
        self.assertEqual((same["mse"], same["rel_mse"], same["flip"]), (0, 0, 0))
        other = json.loads(self.run_sconce("compare", "a.exr", "b.exr", "--json").stdout)
        self.assertGreater(other["rel_mse"], 0)
        self.assertLess(abs(other["rel_mse_corrected"]), other["rel_mse"])
        self.assertIn("48x32", self.run_sconce("render", scene, "-o", "c.exr", "--size", "48x32", "--spp", 1).stdout)
        self.render(scene, "d.exr", "--size", "24x16", "--spp", 1)
        self.assertTrue(self.run_sconce("compare", "a.exr", "d.exr", code=1).stderr)
        self.assertIn("gone.exr", self.run_sconce("compare", "a.exr", "gone.exr", code=1).stderr)

    def test_a_full_disk_leaves_nothing(self):
        scene = self.write("room.xml", ROOM)

        def no_room():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

        for output in ("a.exr", "a.png"):
            before = set(self.path.iterdir())
            message = self.render(scene, output, code=1, preexec_fn=no_room).stderr
            self.assertIn(output, message)
            self.assertEqual(set(self.path.iterdir()), before)
        self.assertTrue(self.render(scene, "no/such/folder/a.exr", code=1).stderr)

    def test_interrupt_leaves_a_usable_picture(self):
        scene = self.write("room.xml", ROOM)
        process = subprocess.Popen([SCONCE, "render", scene, "-o", str(self.path / "a.exr"), "--spp", "100000000"], stderr=subprocess.PIPE, text=True)
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        message = process.communicate(timeout=60)[1]
        self.assertEqual(process.returncode, 1)
        self.assertIn("samples per pixel", message)
        info = json.loads(self.run_sconce("info", self.path / "a.exr").stdout)
        self.assertGreater(info["channels"][0]["mean"], 0)

    def test_unknown_integrator_of_an_old_file_is_a_warning(self):
        scene = self.write("room.xml", ROOM.replace('type="path"><integer name="max_depth" value="6"/>', 'type="photonmapper"><integer name="directSamples" value="6"/>'))
        self.assertIn("photonmapper", self.render(scene, "a.exr").stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
