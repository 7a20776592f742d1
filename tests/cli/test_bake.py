#!/usr/bin/env python3
"""Baking from outside: a small lamp to a file and into a room, repeatability, resuming, bad lamps. usage: test_bake.py SCONCE"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SCONCE = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else "build/release/sconce")

BULB = """<shape type="sphere" id="bulb">
    <point name="center" x="0.1" y="0" z="0"/><float name="radius" value="0.12"/>
    <emitter type="area"><rgb name="radiance" value="30, 20, 10"/></emitter>
</shape>"""
GLASS = """<shape type="sphere" id="glass"><float name="radius" value="0.5"/><bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf></shape>
<shape type="sphere" id="hollow"><float name="radius" value="0.45"/><boolean name="flip_normals" value="true"/><bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf></shape>"""
ROOM = """<scene version="3.0.0">
    <default name="lamp" value="lamp.xml"/>
    <default name="keep" value="none"/>
    <default name="appearance" value="neural"/>
    <default name="placing" value="1"/>
    <integrator type="bdpt"><integer name="max_depth" value="12"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="60"/>
        <transform name="to_world"><lookat origin="0, 0.2, 2.4" target="0, -0.2, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/></film>
        <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
    </sensor>
    <shape type="cube"><transform name="to_world"><scale value="2.5"/></transform>
        <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.4, 0.3"/></bsdf></bsdf></shape>
    <shape type="luminaire">
        <string name="filename" value="$lamp"/><string name="keep" value="$keep"/><string name="appearance" value="$appearance"/>
        <transform name="to_world"><scale value="$placing"/></transform>
    </shape>
</scene>
"""
OPEN_QUAD = "v 0 0 0\nv 0.3 0 0\nv 0.3 0.3 0\nv 0 0.3 0\nf 1 2 3\nf 1 3 4\n"


def lamp(*parts):
    return '<scene version="3.0.0">' + "\n".join(parts) + "</scene>\n"


class Bake(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        (cls.path / "lamp.xml").write_text(lamp(BULB, GLASS))
        (cls.path / "room.xml").write_text(ROOM)
        cls.figures = json.loads(cls.sconce("bake", "lamp.xml", "-o", "lamp.safetensors", "--quality", "draft", "--json").stdout)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def sconce(cls, *arguments, code=0, folder="."):
        result = subprocess.run([SCONCE, *map(str, arguments)], capture_output=True, text=True, timeout=900, cwd=cls.path / folder)
        assert result.returncode == code, f"{arguments}: exit {result.returncode}\n{result.stdout}{result.stderr}"
        return result

    def mean_blocks(self, name, reference):
        return json.loads(self.sconce("compare", name, reference, "--json").stdout)

    def test_figures(self):
        figures = self.figures
        for error in figures["flux_error"]:
            self.assertLess(abs(error), 0.01)
        for at in figures["irradiance"]:
            self.assertLess(at["error"], 0.10 + at["reference_noise"])
        self.assertLess(figures["light_field_error"], 0.2)
        self.assertLess(figures["transparency_error"], figures["transparency_error_black"])
        self.assertLess(figures["bytes"], 8e6)
        self.assertEqual(figures["bytes"], os.path.getsize(self.path / "lamp.safetensors"))
        info = json.loads(self.sconce("info", "lamp.safetensors").stdout)
        self.assertEqual(info["kind"], "luminaire")
        self.assertLess(abs(info["radius"] - 0.5), 0.1)

    def test_evaluate_agrees_with_what_bake_said(self):
        again = json.loads(self.sconce("evaluate", "lamp.safetensors", "lamp.xml", "--quality", "draft", "--json", "--seed", 99).stdout)
        for a, b in zip(again["flux"], self.figures["flux"]):
            self.assertLess(abs(a - b), 0.01 * b)
        for a, b in zip(again["irradiance"], self.figures["irradiance"]):
            self.assertLess(abs(a["error"] - b["error"]), 0.03)

    def test_same_seed_same_file_for_any_number_of_threads(self):
        self.sconce("bake", "lamp.xml", "-o", "again.safetensors", "--quality", "draft", "-q", "-t", 1)
        self.assertEqual((self.path / "lamp.safetensors").read_bytes(), (self.path / "again.safetensors").read_bytes())

    def test_the_room_is_lit_as_by_the_geometry(self):
        self.sconce("render", "room.xml", "-o", "geometry.exr", "-q", "--spp", 256)
        self.sconce("render", "room.xml", "-Dlamp=lamp.safetensors", "-i", "path", "-o", "baked.exr", "--mask", "mask.exr", "-q")
        outside = json.loads(self.sconce("compare", "baked.exr", "geometry.exr", "--mask", "mask.exr", "--json").stdout)
        for ratio in outside["mean_ratio"]:
            self.assertLess(abs(ratio - 1), 0.03)
        self.assertLess(outside["block_error_max"], 0.08)

    def test_appearance_geometry_with_everything_kept_is_the_original(self):
        self.sconce("render", "room.xml", "-o", "geometry.exr", "-q", "--spp", 256)
        self.sconce("render", "room.xml", "-Dlamp=lamp.safetensors", "-Dkeep=all", "-Dappearance=geometry", "-i", "path", "-o", "kept.exr", "-q",
                    "--spp", 256)
        all_pixels = self.mean_blocks("kept.exr", "geometry.exr")
        for ratio in all_pixels["mean_ratio"]:
            self.assertLess(abs(ratio - 1), 0.03)

    def test_appearance_surface_shows_what_the_geometry_shows(self):
        # The lamp's shell is translucent: what the room adds behind it comes through the transparency, as with neural.
        self.assertGreater(json.loads(self.sconce("info", "lamp.safetensors").stdout)["hull"]["triangles"], 100)
        self.sconce("render", "room.xml", "-o", "geometry.exr", "-q", "--spp", 256)
        self.sconce("render", "room.xml", "-Dlamp=lamp.safetensors", "-Dappearance=surface", "-i", "path", "-o", "surface.exr", "-q")
        for ratio in self.mean_blocks("surface.exr", "geometry.exr")["mean_ratio"]:
            self.assertLess(abs(ratio - 1), 0.05)
        message = self.sconce("render", "room.xml", "-Dlamp=lamp.safetensors", "-Dappearance=surface", "-Dkeep=all", "-i", "path", "-o", "x.exr", code=1).stderr
        self.assertIn("keep none", message)

    def test_appearance_auto_is_the_crispest_that_is_possible(self):
        def render(appearance, *rest):
            self.sconce("render", "room.xml", "-Dlamp=lamp.safetensors", f"-Dappearance={appearance}", "-i", "path", "-o", "a.exr", "-q", "--spp", 4, *rest)
            return (self.path / "a.exr").read_bytes()
        self.assertEqual(render("auto"), render("surface"))
        self.assertNotEqual(render("auto"), render("neural"))
        self.assertEqual(render("auto", "-Dkeep=all"), render("neural", "-Dkeep=all"))

    def test_a_bake_without_a_hull(self):
        self.sconce("bake", "lamp.xml", "-o", "black_box.safetensors", "--seconds", 5, "--view", "none", "-q")
        self.assertNotIn("hull", json.loads(self.sconce("info", "black_box.safetensors").stdout))
        message = self.sconce("render", "room.xml", "-Dlamp=black_box.safetensors", "-Dappearance=surface", "-i", "path", "-o", "x.exr", code=1).stderr
        self.assertIn("--view hull", message)
        self.sconce("render", "room.xml", "-Dlamp=black_box.safetensors", "-Dappearance=auto", "-i", "path", "-o", "x.exr", "-q", "--spp", 1)

    def test_unbiased_needs_the_lamp_that_was_baked(self):
        (self.path / "u").mkdir()
        for name in ("lamp.safetensors", "lamp.xml", "room.xml"):
            (self.path / "u" / name).write_bytes((self.path / name).read_bytes())
        render = ("render", "room.xml", "-Dlamp=lamp.safetensors", "-i", "path", "--unbiased", "--spp", 16, "-q", "-o", "u.exr")
        self.sconce(*render, folder="u")
        self.sconce("render", "room.xml", "-o", "geometry.exr", "-q", "--spp", 64)
        for ratio in self.mean_blocks("u/u.exr", "geometry.exr")["mean_ratio"]:
            self.assertLess(abs(ratio - 1), 0.05)
        (self.path / "u/lamp.xml").write_text(lamp(BULB.replace("0.12", "0.11"), GLASS))
        message = self.sconce(*render, code=1, folder="u").stderr
        self.assertIn("room.xml:15:", message)
        self.assertIn("baked from another lamp", message)
        (self.path / "u/lamp.xml").unlink()
        message = self.sconce(*render, code=1, folder="u").stderr
        self.assertIn("lamp.xml", message)
        self.assertIn('name="geometry"', message)

    def test_scaling_the_lamp_scales_its_light(self):
        means = []
        for scale in (0.5, 1):
            self.sconce("render", "room.xml", "-Dlamp=lamp.safetensors", f"-Dplacing={scale}", "-i", "path", "-o", "s.exr", "-q", "--spp", 64)
            self.sconce("render", "room.xml", "-Dlamp=lamp.xml", f"-Dplacing={scale}", "-o", "t.exr", "-q", "--spp", 128)
            means.append(self.mean_blocks("s.exr", "t.exr")["mean_ratio"][1])
        for ratio in means:
            self.assertLess(abs(ratio - 1), 0.04)

    def test_resume_after_an_interrupt(self):
        process = subprocess.Popen([SCONCE, "bake", "lamp.xml", "-o", "resumed.safetensors", "--quality", "draft"], cwd=self.path,
                                   stderr=subprocess.PIPE, text=True)
        time.sleep(6)
        process.send_signal(signal.SIGINT)
        message = process.communicate(timeout=120)[1]
        if process.returncode == 0:
            self.skipTest("the bake was over before the interrupt")
        self.assertEqual(process.returncode, 1)
        self.assertIn("--resume", message)
        self.assertFalse((self.path / "resumed.safetensors").exists())
        figures = json.loads(self.sconce("bake", "lamp.xml", "-o", "resumed.safetensors", "--quality", "draft", "--resume", "--json").stdout)
        for error in figures["flux_error"]:
            self.assertLess(abs(error), 0.01)
        self.assertEqual([p.name for p in self.path.iterdir() if "checkpoint" in p.name], [])

    def test_the_published_networks(self):
        figures = json.loads(self.sconce("bake", "lamp.xml", "-o", "paper.safetensors", "--preset", "paper", "--seconds", 8, "--json").stdout)
        self.assertEqual(figures["bytes"], os.path.getsize(self.path / "paper.safetensors"))
        self.assertLess(abs(figures["bytes"] / 17.06e6 - 1), 0.01)
        self.assertLess(figures["flux"][0] / self.figures["flux"][0] - 1, 0.01)
        for error in figures["flux_error"]:  # it learns something, and does not pretend to be done
            self.assertTrue(-1 < error < 1)
        self.assertEqual(json.loads(self.sconce("info", "paper.safetensors").stdout)["metadata"]["bake.preset"], "paper")
        self.sconce("render", "room.xml", "-Dlamp=paper.safetensors", "-i", "path", "-o", "paper.exr", "-q", "--spp", 2, "--size", "32x32")
        for options, code in ((["--resume"], 2), (["--size", "small"], 2), (["--preset", "cinema"], 2)):
            self.sconce("bake", "lamp.xml", "-o", "none.safetensors", "--preset", "paper", *options, code=code)

    def test_the_installed_library_in_c_and_cpp(self):
        source = pathlib.Path(__file__).resolve().parent.parent / "api" / "irradiance.c"
        build = os.environ.get("BUILD_DIR", os.path.dirname(SCONCE))
        prefix = self.path / "installed"
        subprocess.run(["cmake", "--install", build, "--prefix", prefix], check=True, capture_output=True)
        config = next(prefix.rglob("sconce.pc")).parent
        environment = dict(os.environ, PKG_CONFIG_PATH=str(config), LD_LIBRARY_PATH=str(config.parent))
        flags = subprocess.run(["pkg-config", "--define-prefix", "--cflags", "--libs", "sconce"], check=True, capture_output=True, text=True,
                               env=environment).stdout.split()
        for compiler, language in (("gcc", "c"), ("g++", "c++")):
            program = self.path / f"irradiance-{language}"
            subprocess.run([compiler, "-Wall", "-Werror", "-x", language, source, "-x", "none", *flags, "-lm", "-o", program], check=True, env=environment)
        distance, flux, total = 20, self.figures["flux"][1], 0
        directions = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        for direction in directions:
            point = [str(distance * c / 3 ** 0.5) for c in direction]
            total += float(subprocess.run([program, "lamp.safetensors", *point], check=True, capture_output=True, text=True, env=environment,
                                          cwd=self.path).stdout.split()[1])
        far_field = flux / (4 * 3.14159265 * distance ** 2)
        self.assertLess(abs(total / len(directions) / far_field - 1), 0.05)
        whole, dimmed = (subprocess.run([program, "lamp.safetensors", "20", "3", "1", *groups], check=True, capture_output=True, text=True,
                                        env=environment, cwd=self.path).stdout.split() for groups in ((), ("all=0.5:2:0",)))
        for factor, before, after in zip((0.5, 2, 0), whole, dimmed):
            self.assertLess(abs(float(after) - factor * float(before)), 1e-4 * float(before))
        wrong = subprocess.run([program, "lamp.safetensors", "20", "3", "1", "bulb=1"], capture_output=True, text=True, env=environment, cwd=self.path)
        self.assertEqual(wrong.returncode, 1)
        self.assertIn("without groups", wrong.stderr)

    def test_bad_lamps(self):
        (self.path / "open.obj").write_text(OPEN_QUAD)
        (self.path / "nan.obj").write_text(OPEN_QUAD.replace("v 0.3 0 0", "v nan 0 0"))
        (self.path / "small.obj").write_text("v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
        cases = [("no emitter", lamp(GLASS), [], "emit"),
                 ("zero power", lamp(BULB.replace("30, 20, 10", "0, 0, 0"), GLASS), [], "power"),
                 ("nan vertices", lamp(BULB, '<shape type="obj"><string name="filename" value="nan.obj"/></shape>'), [], "nan.obj"),
                 ("proxy cuts", lamp(BULB, GLASS), ["--proxy", "small.obj"], "proxy"),
                 ("missing proxy", lamp(BULB, GLASS), ["--proxy", "gone.obj"], "gone.obj")]
        for name, text, options, expected in cases:
            (self.path / "bad.xml").write_text(text)
            message = self.sconce("bake", "bad.xml", "-o", "bad.safetensors", "--quality", "draft", "-q", *options, code=1).stderr
            self.assertIn(expected, message.lower(), name)
            self.assertFalse((self.path / "bad.safetensors").exists(), name)
        (self.path / "bad.xml").write_text(lamp(BULB, '<shape type="obj" id="pane"><string name="filename" value="open.obj"/><bsdf type="dielectric"/></shape>'))
        result = self.sconce("bake", "bad.xml", "-o", "open.safetensors", "--seconds", 5)
        self.assertIn("open", result.stderr)
        self.assertIn("pane", result.stderr)

    def test_a_damaged_file_is_an_error(self):
        whole = (self.path / "lamp.safetensors").read_bytes()
        for length in (0, 7, 100, len(whole) // 2, len(whole) - 1):
            (self.path / "cut.safetensors").write_bytes(whole[:length])
            self.assertIn("cut.safetensors", self.sconce("info", "cut.safetensors", code=1).stderr)
            self.sconce("render", "room.xml", "-Dlamp=cut.safetensors", "-i", "path", "-o", "cut.exr", code=1)
            self.assertFalse((self.path / "cut.exr").exists())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
