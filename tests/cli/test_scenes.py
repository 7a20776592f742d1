#!/usr/bin/env python3
"""Scene files by others, and broken ones, from outside: what must work works, what is wrong is told with its place, and
nothing is left behind. usage: test_scenes.py SCONCE"""
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

SCONCE = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else "build/release/sconce")
SENSOR = """<sensor type="perspective"><float name="fov" value="50"/>
<transform name="to_world"><lookat origin="0, 1, 4" target="0, 0.5, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="6"/></film>
<sampler type="independent"><integer name="sample_count" value="1"/></sampler></sensor>
<emitter type="constant"/>"""
BALL = '<shape type="sphere"/>'
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def scene(inside, sensor=SENSOR):
    return f'<scene version="3.0.0">{sensor}\n{inside}</scene>'


def mesh(filename, type="obj"):
    return f'<shape type="{type}"><string name="filename" value="{filename}"/></shape>'


def bitmap(filename):
    return (f'<shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">'
            f'<string name="filename" value="{filename}"/></texture></bsdf></shape>')


def ply_header(kind, vertices, faces):
    return (f"ply\nformat {kind} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {faces}\nproperty list uchar int vertex_indices\nend_header\n").encode()


def serialized(vertices, triangles, body=b"", version=4):
    head = struct.pack("<I", 0x1000) + (b"a\0" if version == 4 else b"") + struct.pack("<QQ", vertices, triangles)
    data = struct.pack("<HH", 0x041C, version) + zlib.compress(head + body)
    return data + (struct.pack("<Q", 0) if version == 4 else struct.pack("<I", 0)) + struct.pack("<I", 1)


class Scenes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, content):
        target = self.path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content if isinstance(content, bytes) else content.encode())
        return name

    def render(self, name, *arguments, code=0, cwd=None):
        result = subprocess.run([SCONCE, "render", name, "-o", str(self.path / "out.exr"), *arguments], capture_output=True,
                                text=True, timeout=60, cwd=cwd or self.path, errors="replace")
        message = result.stdout + result.stderr
        self.assertEqual(result.returncode, code, message)
        self.assertNotIn("Sanitizer", message)
        self.assertNotIn("runtime error", message)
        self.assertEqual((self.path / "out.exr").exists(), code == 0)
        return result.stderr

    def fails(self, text, *wanted, name="s.xml", **options):
        """Rendering this scene fails with a message that holds all of `wanted`, and leaves no file."""
        self.write(name, text)
        before = sorted(self.path.rglob("*"))
        message = self.render(name, code=1, **options)
        for part in wanted:
            self.assertIn(part, message)
        self.assertEqual(sorted(self.path.rglob("*")), before)

    # --- what must work ---

    def test_obj_as_exporters_write_it(self):
        files = {
            "materials.obj": "mtllib absent.mtl\no a\n" + TRIANGLE + "usemtl absent\nf 1 2 3\n",
            "quad.obj": "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
            "ngon.obj": "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5\n",
            "negative.obj": TRIANGLE + "f -3 -2 -1\n",
            "crlf.obj": (TRIANGLE + "f 1 2 3\n").replace("\n", "\r\n"),
            "unended.obj": TRIANGLE + "f 1 2 3",
            "normals.obj": TRIANGLE + "vn 0 0 1\nf 1//1 2//1 3//1\n",
            "huge.obj": "v 0 0 0\nv 1e9 0 0\nv 0 1e9 0\nf 1 2 3\n",
            "comments.obj": "# made by hand\n\n" + TRIANGLE + "g\ns off\nl 1 2\nf 1 2 3\n",
            "colors.obj": "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n",
        }
        for name, text in files.items():
            with self.subTest(name):
                self.write(name, text)
                self.write("s.xml", scene(mesh(name)))
                self.render("s.xml", "-q")
                (self.path / "out.exr").unlink()

    def test_ply_kinds(self):
        points = (0, 0, 0, 1, 0, 0, 0, 1, 0)
        files = {
            "ascii.ply": ply_header("ascii", 3, 1) + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
            "little.ply": ply_header("binary_little_endian", 3, 1) + struct.pack("<9fB3i", *points, 3, 0, 1, 2),
            "big.ply": ply_header("binary_big_endian", 3, 1) + struct.pack(">9fB3i", *points, 3, 0, 1, 2),
            "crlf.ply": (ply_header("ascii", 3, 1) + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2").replace(b"\n", b"\r\n"),
        }
        for name, data in files.items():
            with self.subTest(name):
                self.write(name, data)
                self.write("s.xml", scene(mesh(name, "ply")))
                self.render("s.xml", "-q")
                (self.path / "out.exr").unlink()

    def test_harmless_settings_are_no_errors(self):
        inside = BALL + """<integrator type="aov"><string name="aovs" value="d:depth"/>
            <integrator type="volpath"><integer name="max_depth" value="4"/><integer name="samples_per_pass" value="8"/>
            <boolean name="strict_normals" value="true"/><string name="my_setting" value="x"/></integrator></integrator>
            <medium type="heterogeneous" id="fog"/><texture type="checkerboard" id="unused"/>
            <sensor type="perspective"><float name="shutter_open" value="0"/></sensor>"""
        self.write("s.xml", scene(inside))
        message = self.render("s.xml")
        self.assertIn("parameter 'my_setting' of integrator 'volpath' is ignored", message)
        self.assertIn("medium 'heterogeneous'", message)

    def test_missing_files(self):
        self.write("s.xml", scene(bitmap("absent.png") + mesh("absent.obj")))
        self.render("s.xml", code=1)
        message = self.render("s.xml", "--skip-missing")
        self.assertIn("middle gray", message)
        self.assertIn("the shape is left out", message)

    def test_definitions_reach_the_lamp(self):
        self.write("lamp/lamp.xml", '<scene version="3.0.0"><default name="size" value="1"/><shape type="sphere"><float name="radius" '
                   'value="$size"/><emitter type="area"><rgb name="radiance" value="3"/></emitter></shape></scene>')
        self.write("s.xml", scene('<shape type="luminaire"><string name="filename" value="$lamp"/></shape>'))
        message = self.render("s.xml", "-Dlamp=lamp/lamp.xml", "-D", "size=-1", code=1)
        self.assertIn("radius", message)
        message = self.render("s.xml", "-Dlamp=lamp/lamp.xml", "-Dsize=0.2", "-Dother=1")
        self.assertNotIn("size", message)
        self.assertIn("-D other=1 is used nowhere", message)

    def test_files_beside_the_scene_or_in_the_current_folder(self):
        self.write("here/lamp.obj", TRIANGLE + "f 1 2 3\n")
        self.write("scenes/s.xml", scene(mesh("lamp.obj")))
        self.render("../scenes/s.xml", cwd=self.path / "here")
        (self.path / "out.exr").unlink()
        self.write("scenes/lamp.obj", "nonsense")  # the scene's own folder comes first
        self.render("../scenes/s.xml", code=1, cwd=self.path / "here")

    # --- what is wrong ---

    def test_scene_files_that_are_none(self):
        self.fails("", "s.xml")
        self.fails("\0\1\2", "s.xml:1:")
        self.fails(scene(BALL)[:-20], "s.xml:")
        self.fails("<html/>", "s.xml:1:1", "<scene>")
        self.fails(b'<?xml version="1.0" encoding="utf-8"?><scene version="3.0.0"><shape type="\xff"/></scene>', "s.xml:1:")
        self.fails("<scene>" * 2000, "s.xml:1:")
        self.fails("<scene>" + '<bsdf type="twosided">' * 5000, "s.xml:1:", "deep")
        self.fails('<!DOCTYPE s [<!ENTITY a "' + "x" * 1000 + '">' + "".join(
            f'<!ENTITY {chr(98 + i)} "{("&" + chr(97 + i) + ";") * 40}">' for i in range(6)) + ']><scene version="&g;"/>', "s.xml:")
        self.assertIn("absent.xml", self.render("absent.xml", code=1))
        (self.path / "folder.xml").mkdir()
        self.assertIn("folder.xml", self.render("folder.xml", code=1))

    def test_values_that_are_none(self):
        for inside, wanted in (
                ('<shape type="sphere"><float name="radius" value="nan"/></shape>', "radius is 'nan'"),
                ('<shape type="sphere"><float name="radius" value="1e999"/></shape>', "radius is '1e999'"),
                ('<shape type="sphere"><float name="radius" value=""/></shape>', "radius is ''"),
                ('<shape type="sphere"><float name="radius" value="-1"/></shape>', "must lie between"),
                ('<shape type="sphere"><float name="radus" value="1"/></shape>', "did you mean 'radius'?"),
                ('<shape type="sphere"><point name="center" value="1 2"/></shape>', "2 numbers; write three"),
                ('<shape type="sphere"><transform name="to_world"><scale value="0"/></transform></shape>', "scale by 0"),
                ('<shape type="sphere"><transform name="to_world"><matrix value="1 2 3"/></transform></shape>', "3 numbers"),
                ('<shape type="sphere"><transform name="to_world"><scale value="1e30"/><scale value="1e30"/></transform></shape>',
                 "too large"),
                ('<shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="2"/></bsdf></shape>', "between 0 and 1"),
                ('<shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="#12"/></bsdf></shape>', "#rrggbb"),
                ('<shape type="sphere"><bsdf type="diffuse"><spectrum name="reflectance" value="500:1"/></bsdf></shape>', "pairs"),
                ('<shape type="sphere"><bsdf type="diffuse"><spectrum name="reflectance" type="d56"/></bsdf></shape>',
                 "did you mean 'd65'?"),
                ('<shape type="sphere"><bsdf type="difuse"/></shape>', "did you mean 'diffuse'?"),
                ('<shape type="sphere"><ref id="metal"/></shape>', "nothing has the id 'metal'"),
                ('<shape type="$kind"/>', "$kind has no value"),
                ('<shape type="rectangle"><emitter type="point"/></shape>', "cannot stand inside a shape"),
                ('<shape/>', "needs the attribute type"),
                ('<spere/>', "unknown element"),
                ('<shape type="sphere" radius="2"/>', "no attribute 'radius'"),
                ('text', "text 'text'")):
            with self.subTest(inside):
                self.fails(scene(inside), "s.xml:6:", wanted)

    def test_cycles(self):
        self.fails(scene('<include filename="s.xml"/>'), "s.xml:6:", "includes itself")
        self.write("a.xml", '<scene version="3.0.0"><include filename="s.xml"/></scene>')
        self.fails(scene('<include filename="a.xml"/>'), "a.xml:1:", "includes itself")
        self.fails(scene('<bsdf type="twosided" id="a"><ref id="b"/></bsdf><bsdf type="twosided" id="b"><ref id="a"/></bsdf>'),
                   "s.xml:6:", "stands inside that object itself")
        self.fails(scene('<alias id="a" as="b"/><alias id="b" as="a"/><shape type="sphere"><ref id="a"/></shape>'), "s.xml:6:", "alias")
        self.fails(scene('<shape type="luminaire"><string name="filename" value="s.xml"/></shape>'), "s.xml:6:", "does 's.xml' hold itself?")
        self.fails(scene('<default name="a" value="$a$a"/><shape type="$a"/>'), "s.xml:6:")
        self.fails(scene('<include filename="absent.xml"/>'), "s.xml:6:", "absent.xml")
        self.fails(scene('<include filename="."/>'), "s.xml:6:", "cannot be read")

    def test_broken_obj(self):
        for text in ("", "\n", "f 1 2 3\n", TRIANGLE, TRIANGLE + "f 1 2 9\n", TRIANGLE + "f 1 2 -9\n", TRIANGLE + "f 0 0 0\n",
                     TRIANGLE + "f 1 2 99999999999999999999\n", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
                     "v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "v 1e999 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "\0" * 100,
                     "v 0\nv\nf 1 2 3\n", "\xff\xfe" * 50):
            with self.subTest(text[:40]):
                self.write("m.obj", text)
                self.fails(scene(mesh("m.obj")), "s.xml:6:", "m.obj")

    def test_broken_ply(self):
        whole = ply_header("binary_little_endian", 3, 1) + struct.pack("<9fB3i", 0, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 1, 2)
        broken = [whole[:n] for n in (0, 3, 40, 150, len(whole) - 30, len(whole) - 1)]
        broken += [whole.replace(b"vertex 3", b"vertex 99999999999999999999"), whole.replace(b"vertex 3", b"vertex 4000000000000"),
                   whole.replace(b"vertex 3", b"vertex -3"), whole.replace(b"face 1", b"face 2147483647"),
                   whole.replace(b"float x", b"wrong x"), whole.replace(b"property float z\n", b""),
                   whole[:-4] + struct.pack("<i", 7), whole[:-4] + struct.pack("<i", -1),
                   ply_header("binary_little_endian", 3, 1) + struct.pack("<9fB3i", float("nan"), *[0] * 8, 3, 0, 1, 2),
                   ply_header("ascii", 3, 1) + b"0 0 0\n1 0 0\n", ply_header("ascii", 3, 1) + b"a b c\n" * 4]
        for number, data in enumerate(broken):
            with self.subTest(number):
                self.write("m.ply", data)
                self.fails(scene(mesh("m.ply", "ply")), "s.xml:6:", "m.ply")

    def test_broken_serialized(self):
        body = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0) + struct.pack("<3I", 0, 1, 2)
        good = serialized(3, 1, body)
        self.write("m.serialized", good)
        self.write("s.xml", scene(mesh("m.serialized", "serialized")))
        self.render("s.xml", "-q")
        (self.path / "out.exr").unlink()
        broken = [good[:n] for n in (0, 1, 4, 10, len(good) - 4, len(good) - 1)]
        broken += [serialized(1 << 62, 1, body), serialized(3, 1 << 61, body), serialized(30, 1, body), serialized(3, 0, body),
                   serialized(3, 1, body[:-12] + struct.pack("<3I", 0, 1, 3)), good[:-4] + struct.pack("<I", 0xFFFFFFFF),
                   good[:-12] + struct.pack("<QI", 1 << 63, 1), b"\x1c\x04\x07\0" + good[4:]]
        for number, data in enumerate(broken):
            with self.subTest(number):
                self.write("m.serialized", data)
                self.fails(scene(mesh("m.serialized", "serialized")), "s.xml:6:", "m.serialized")

    def test_broken_images(self):
        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

        def png(width, height, data):
            return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                    chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b""))

        good = png(2, 2, b"\0" + bytes(6) + b"\0" + bytes(6))
        self.write("i.png", good)
        self.write("s.xml", scene(bitmap("i.png")))
        self.render("s.xml", "-q")
        exr = (self.path / "out.exr").read_bytes()
        (self.path / "out.exr").unlink()
        hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 20 +X 4\n" + b"\x80\x40\x20\x80" * 80
        self.write("i.hdr", hdr)
        self.write("s.xml", scene(bitmap("i.hdr")))
        self.render("s.xml", "-q")
        (self.path / "out.exr").unlink()
        for name, data in [("i.hdr", hdr[:-40]), ("i.hdr", hdr[:30])] + [("i.png", good[:n]) for n in (0, 8, 20, 45)] + [
                ("i.png", png(1 << 30, 1 << 30, b"")), ("i.png", png(0, 0, b"")), ("i.jpg", b"\xff\xd8\xff\xe0" + bytes(20)),
                ("i.exr", exr[:100]), ("i.exr", exr[:-200]), ("i.exr", b"v/1\x01"), ("i.hdr", b"?"), ("i.png", exr)]:
            with self.subTest(name=name, size=len(data)):
                self.write(name, data)
                if (name, data) == ("i.png", exr):
                    continue  # told by its content or refused: both are fine
                self.fails(scene(bitmap(name)), "s.xml:6:", name)
        self.write("i.exr", exr[:-200])
        self.fails(scene('<shape type="sphere"/>', SENSOR.replace('<emitter type="constant"/>',
                         '<emitter type="envmap"><string name="filename" value="i.exr"/></emitter>')), "s.xml:5:", "i.exr")

    def test_folders_and_unreadable_files(self):
        (self.path / "d.obj").mkdir()
        (self.path / "d.png").mkdir()
        (self.path / "d.safetensors").mkdir()
        self.fails(scene(mesh("d.obj")), "s.xml:6:", "d.obj")
        self.fails(scene(bitmap("d.png")), "s.xml:6:", "d.png")
        self.fails(scene('<shape type="luminaire"><string name="filename" value="d.safetensors"/></shape>'), "d.safetensors")
        self.fails(scene(mesh("x" * 6000 + ".obj")), "s.xml:6:")
        if os.getuid():
            self.write("secret.obj", TRIANGLE + "f 1 2 3\n")
            (self.path / "secret.obj").chmod(0)
            self.fails(scene(mesh("secret.obj")), "s.xml:6:", "secret.obj")

    def test_broken_lamps(self):
        self.fails(scene('<shape type="luminaire"><string name="filename" value="absent.safetensors"/></shape>'), "s.xml:6:",
                   "absent.safetensors", "sconce bake")
        for data in (b"", b"\0" * 8, b"\xff" * 8, struct.pack("<Q", 1 << 40) + b"{}", struct.pack("<Q", 2) + b"{}",
                     struct.pack("<Q", 10) + b'{"a":[1,2]'):
            with self.subTest(data):
                self.write("l.safetensors", data)
                self.fails(scene('<shape type="luminaire"><string name="filename" value="l.safetensors"/></shape>'), "l.safetensors")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=1)
