#!/usr/bin/env python3
"""sconce table1 from outside, on a folder of the real rooms with a small lamp of the test's own in place of the real ones: every
column is there, a second run does nothing twice, Ctrl-C leaves a table, an installation finds its rooms. usage: test_table1.py SCONCE"""
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
BUILD = pathlib.Path(os.environ.get("BUILD_DIR", pathlib.Path(SCONCE).parent)).resolve()
SOURCES = pathlib.Path(__file__).resolve().parents[2]
LAMP = """<scene version="3.0.0">
<shape type="sphere"><float name="radius" value="0.05"/><emitter type="area"><rgb name="radiance" value="30, 20, 10"/></emitter></shape>
<shape type="sphere"><float name="radius" value="0.2"/><bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf></shape>
<shape type="sphere"><float name="radius" value="0.18"/><boolean name="flip_normals" value="true"/>
    <bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf></shape>
</scene>
"""
NUMBERS = ("speedup target paper_speedup bdpt_spp bdpt_cpu_s bdpt_relmse bdpt_relmse_fireflies bdpt_relmse_whole bdpt_flip ours_spp ours_cpu_s ours_relmse "
           "ours_relmse_whole ours_flip common_bdpt_spp common_bdpt_cpu_s common_speedup fixed_spp fixed_cpu_s fixed_relmse fixed_flip "
           "fixed_speedup bias_spp bias_cpu_s bias bias_error bias_share bdpt_worst_share ours_worst_share unbiased_speedup noise_ratio sample_cost_ratio reference_spp reference_cpu_s "
           "reference_noise geometry_bytes apl_bytes file_bytes width height").split()


class Table1(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        cls.data = cls.path / "data"
        (cls.data / "lamps/baked").mkdir(parents=True)
        (cls.data / "scenes").mkdir()
        for room in (SOURCES / "scenes").glob("*.xml"):
            (cls.data / "scenes" / room.name).symlink_to(room)
        for things in ("furniture", "textures"):
            (cls.data / "scenes" / things).symlink_to(BUILD / "scenes" / things)
        (cls.path / "lamp.xml").write_text(LAMP)
        cls.sconce("bake", "lamp.xml", "-o", "lamp.safetensors", "--seconds", 4, "-q")
        for lamp in ("blossom_lamp", "star_lamp"):
            (cls.data / "lamps" / lamp).mkdir()
            (cls.data / "lamps" / lamp / f"{lamp}.xml").write_text(LAMP)
            (cls.data / "lamps/baked" / f"{lamp}.safetensors").write_bytes((cls.path / "lamp.safetensors").read_bytes())

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def sconce(cls, *arguments, code=0, program=SCONCE):
        result = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=600, cwd=cls.path)
        assert result.returncode == code, f"{arguments}: exit {result.returncode}\n{result.stdout}{result.stderr}"
        return result

    def table1(self, out, *arguments, **options):
        return self.sconce("table1", "--data", self.data, "-o", out, "-q", *arguments, **options)

    def files(self, out):
        return {str(path): path.stat().st_mtime_ns for path in (self.path / out).glob("*/*")}

    def test_columns_and_resuming(self):
        arguments = ("--scale", 0.05, "--only", "star,blossom")
        table = json.loads(self.table1("out/one", *arguments, "--json").stdout)
        self.assertEqual([row["luminaire"] for row in table["rows"]], ["Moravian star", "Cherry blossom"])
        self.assertEqual(table["settings"]["scale"], 0.05)
        for row in table["rows"]:
            for key in NUMBERS:
                self.assertIn(key, row)
                if key != "speedup":  # null where bdpt's error is not reached
                    self.assertIsInstance(row[key], (int, float), key)
            self.assertEqual(len(row["flux_error"]), 3)
            self.assertEqual(len(row["mean_error"]), 3)
            self.assertEqual(row["bdpt_spp"], 51)
            self.assertEqual(row["reference_spp"], 102)
            self.assertEqual(row["height"], 20)
            self.assertEqual(row["geometry_bytes"], len(LAMP))
            self.assertEqual(row["file_bytes"], os.path.getsize(self.path / "lamp.safetensors"))
            self.assertIn("Bias is", row["limits"])
            if row["speedup"] is not None:
                self.assertLessEqual(row["ours_relmse"], row["bdpt_relmse"])
                self.assertAlmostEqual(row["speedup"], row["bdpt_cpu_s"] / row["ours_cpu_s"], delta=1e-3 * row["speedup"])
        self.assertEqual(json.loads((self.path / "out/one/table1.json").read_text()), table)
        self.assertEqual((self.path / "out/one/table1.md").read_text().count("|\n"), 38 + 2)
        page = (self.path / "out/one/table1.html").read_text()
        self.assertEqual(page.count("data:image/png;base64,"), 2 * (3 + 2 + 6))
        self.assertNotIn("http", page)

        before = self.files("out/one")
        again = json.loads(self.table1("out/one", *arguments, "--json").stdout)
        self.assertEqual(again["rows"], table["rows"])
        self.assertEqual(self.files("out/one"), before)
        # Longer references go on from the shorter ones; nothing else is longer.
        longer = json.loads(self.table1("out/one", *arguments, "--reference", 2, "--json").stdout)
        self.assertEqual(longer["settings"]["reference"], 2)
        for row, short in zip(longer["rows"], table["rows"]):
            self.assertEqual((row["reference_spp"], row["bdpt_spp"]), (204, 51))
            self.assertGreater(row["reference_cpu_s"], short["reference_cpu_s"])
            self.assertEqual(row["bdpt_cpu_s"], short["bdpt_cpu_s"])
            self.assertLess(row["reference_noise"], 0.8 * short["reference_noise"])
        self.table1("out/one", *arguments)
        before = self.files("out/one")
        # A change of the lamp's geometry makes anew what it is in, and nothing else.
        star = self.data / "lamps/star_lamp/star_lamp.xml"
        star.write_text(LAMP.replace("30, 20, 10", "31, 20, 10"))
        self.table1("out/one", *arguments)
        star.write_text(LAMP)
        changed = {path for path, when in self.files("out/one").items() if before.get(path) != when}
        self.assertTrue(changed)
        for path in changed:
            self.assertRegex(path, r"star/(bdpt|reference_1|reference_2|ours_\d+_spp).(exr|json)")

    def test_interrupted(self):
        arguments = ["--data", self.data, "--scale", "0.07", "--only", "blossom,star", "-o", "out/two", "-t", "1"]
        process = subprocess.Popen([SCONCE, "table1", *map(str, arguments), "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, cwd=self.path)
        while not (self.path / "out/two/blossom/ours_1.json").exists() and process.poll() is None:  # the star's row comes first
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        out, messages = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, messages)
        self.assertIn("goes on from here", messages)
        first = json.loads(out)["rows"]
        self.assertEqual(first[0]["luminaire"], "Moravian star")
        self.assertEqual(json.loads((self.path / "out/two/table1.json").read_text())["rows"], first)
        self.assertFalse([name for name in self.files("out/two") if ".part" in name])
        before = self.files("out/two")
        rows = json.loads(self.sconce("table1", *arguments, "--json", "-q").stdout)["rows"]
        self.assertEqual(rows[0], first[0])
        self.assertEqual(len(rows), 2)
        star = {name: when for name, when in self.files("out/two").items() if "/star/" in name}
        self.assertEqual(star, {name: when for name, when in before.items() if "/star/" in name})

    def test_a_rendering_goes_on_where_it_stopped(self):
        arguments = ["table1", "--data", self.data, "--scale", "0.1", "--only", "blossom", "-t", "1", "-q", "-o"]
        for attempt in range(3):  # in the middle of bdpt or of a reference
            process = subprocess.Popen([SCONCE, *map(str, arguments), "out/stopped"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=self.path)
            time.sleep(1.5)
            process.send_signal(signal.SIGINT)
            process.wait(timeout=60)
        self.sconce(*arguments, "out/stopped")
        self.sconce(*arguments, "out/straight")
        for name in ("bdpt", "reference_1", "reference_2"):
            figures = json.loads(self.sconce("compare", f"out/stopped/blossom/{name}.exr", f"out/straight/blossom/{name}.exr", "--json").stdout)
            self.assertLess(figures["rel_mse"], 1e-10, name)

    def test_an_installation_finds_its_rooms_and_lamps(self):
        prefix = self.path / "installed"
        subprocess.run(["cmake", "--install", BUILD, "--prefix", prefix], check=True, stdout=subprocess.DEVNULL)
        baked = prefix / "share/sconce/lamps/baked"
        baked.mkdir(exist_ok=True)
        for file in baked.iterdir():
            file.unlink()
        command = ("table1", "--scale", 0.02, "--only", "blossom", "-o", "out/three", "-q")
        self.assertIn(str(baked / "blossom_lamp.safetensors"), self.sconce(*command, code=1, program=prefix / "bin/sconce").stderr)
        # Not the blossom at all: there is no speed-up to speak of, and the table says so.
        (baked / "blossom_lamp.safetensors").write_bytes((self.path / "lamp.safetensors").read_bytes())
        row = json.loads(self.sconce(*command, "--json", program=prefix / "bin/sconce").stdout)["rows"][0]
        self.assertIsNone(row["speedup"])
        self.assertGreater(row["bias_share"], 1)
        self.assertGreater(row["ours_relmse"], row["bdpt_relmse"])
        self.assertIn("was not reached", row["limits"])
        room = prefix / "share/sconce/scenes/bedroom.xml"
        self.sconce("info", room, f"-Dlamp={prefix / 'share/sconce/lamps/demo_lamp/demo_lamp.xml'}", program=prefix / "bin/sconce")

    def test_messages(self):
        self.assertIn("statler, star, blossom", self.table1("out/four", "--only", "star,crystal", code=1).stderr)
        self.assertIn("no folders scenes and lamps", self.sconce("table1", "--data", "/proc", "-o", "out/four", code=1).stderr)
        self.assertIn("statler_lamp.safetensors is missing", self.table1("out/four", code=1).stderr)
        self.assertIn("cannot be made", self.table1("/proc/none/out", "--only", "star", code=1).stderr)
        self.sconce("table1", "--scale", 5, code=2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=1)
