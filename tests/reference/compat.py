#!/usr/bin/env python3
"""Scene files as others write them: every scene of tests/scenes/compat is rendered by Mitsuba 3 and by sconce from the
same file (Mitsuba upgrades the 0.6 spelling by itself), and the quadrants of the pictures must have the same mean.

    compat.py PROGRAM [SCENE ...] [--keep FOLDER]

SCENE_reference.xml, where it exists, is what Mitsuba 3 renders instead: of 0.6 scenes it cannot read. Images and meshes
are made here. Needs the Python packages of requirements.txt."""
import argparse
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
SCENES = pathlib.Path(__file__).resolve().parents[1] / "scenes" / "compat"
TOLERANCE = 0.015  # of a quadrant's mean, widened by four standard errors
BATCHES = 4
SAMPLES = {"dielectrics_v3": 256, "principled_v3": 512, "dielectrics_v06": 256, "absorption_v3": 256, "wrappers_v3": 1024,
           "delta_lights_v3": 2048, "delta_lights_v06": 512}
# More definitions on the command line, for both programs.
DEFINITIONS = {"defaults_v3": {"albedo": "0.6, 0.2, 0.2", "eye": "2"}, "defaults_v06": {"wall": "0.5, 0.5, 0.1"}}


def images(folder):
    """8-bit, high dynamic range and data images, smooth and with hard edges."""
    y, x = np.mgrid[0:24, 0:32].astype(np.float32) / np.float32([[[24]], [[32]]])
    photo = np.stack([0.2 + 0.6 * x, 0.3 + 0.5 * y, 0.5 + 0.4 * np.sin(6 * x) * np.cos(5 * y)], -1)
    mi.Bitmap((255 * photo).astype(np.uint8)).write(str(folder / "photo.jpg"), quality=95)
    tiles = np.random.default_rng(1).integers(20, 230, (5, 7, 3)).astype(np.uint8)
    mi.Bitmap(tiles).write(str(folder / "tiles.png"))
    leaf = ((x - 0.5) ** 2 + (y - 0.5) ** 2 < 0.15).astype(np.uint8) * 255
    mi.Bitmap(leaf[..., None]).write(str(folder / "leaf.png"))
    height = 0.5 + 0.4 * np.sin(12 * x) * np.sin(9 * y)
    mi.Bitmap((255 * height).astype(np.uint8)[..., None]).write(str(folder / "bump.png"))
    normal = np.stack([0.35 * np.cos(12 * x), 0.35 * np.sin(9 * y), np.ones_like(x)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    mi.Bitmap((255 * (0.5 + 0.5 * normal) + 0.5).astype(np.uint8)).write(str(folder / "normal.png"))
    mi.Bitmap((photo[::-1] * 0.9).astype(np.float32)).write(str(folder / "colors.exr"))
    sky = np.stack([0.3 + 0.5 * x, 0.3 + 0.3 * y, 1 - 0.6 * y], -1) + 6 * ((x - 0.3) ** 2 + (y - 0.25) ** 2 < 0.01)[..., None]
    mi.Bitmap(sky.astype(np.float32)).write(str(folder / "sky.exr"))
    (folder / "lamp.spd").write_text("# nm, W\n380 1\n500 2.5\n600 4\n780 3\n")


def bumpy_sphere(n=24, m=12):
    """Positions, texture coordinates and quads of a closed grid that is no quadric."""
    v, u = np.mgrid[0:m + 1, 0:n + 1] / np.array([m, n])[:, None, None]
    theta, phi = np.pi * (0.02 + 0.96 * v), 2 * np.pi * u
    r = 1 + 0.15 * np.sin(3 * phi) * np.sin(theta) ** 2
    p = np.stack([r * np.sin(theta) * np.cos(phi), r * np.cos(theta), r * np.sin(theta) * np.sin(phi)], -1)
    i = np.arange(m)[:, None] * (n + 1) + np.arange(n)
    quads = np.stack([i, i + 1, i + n + 2, i + n + 1], -1).reshape(-1, 4)
    return p.reshape(-1, 3), np.stack([u, v], -1).reshape(-1, 2), quads


def meshes(folder):
    p, uv, quads = bumpy_sphere()
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    lines = ["mtllib absent.mtl", "o thing", "g group1"] + ["v %.6f %.6f %.6f" % tuple(q) for q in p]
    lines += ["vt %.6f %.6f" % tuple(t) for t in uv] + ["usemtl shiny", "s 1"]
    lines += ["f " + " ".join("%d/%d" % (k + 1, k + 1) for k in q) for q in quads[:100]] + ["usemtl dull"]
    lines += ["f " + " ".join("%d/%d" % (k + 1, k + 1) for k in q) for q in quads[100:]]
    (folder / "mesh.obj").write_bytes("\r\n".join(lines).encode())  # as from Windows, no newline at the end
    normals = p / np.linalg.norm(p, axis=1, keepdims=True)
    head = "ply\nformat %s 1.0\ncomment made for a test\nelement vertex %d\n" % ("%s", len(p))
    head += "".join("property float %s\n" % c for c in ("x", "y", "z"))
    tail = "element face %d\nproperty list uchar int vertex_indices\nend_header\n"
    colors = "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    text = head % "ascii" + colors + tail % len(triangles)
    text += "".join("%.6f %.6f %.6f %.6f %.6f %.6f 10 20 30\n" % (*a, *b) for a, b in zip(p, normals))
    text += "".join("3 %d %d %d\n" % tuple(t) for t in triangles)
    (folder / "mesh_ascii.ply").write_text(text)
    binary = (head % "binary_little_endian" + tail % len(triangles)).encode() + p.astype("<f4").tobytes()
    (folder / "mesh_binary.ply").write_bytes(binary + b"".join(struct.pack("<B3i", 3, *t) for t in triangles))
    shapes = []
    for scale, flags in ((np.array([1, 0.6, 1]), 0x1000), (np.array([0.7, 1, 1]), 0x1000 | 0x0001 | 0x0002)):
        body = struct.pack("<I", flags) + b"shape\0" + struct.pack("<QQ", len(p), len(triangles))
        body += (p * scale).astype("<f4").tobytes()
        if flags & 1:
            body += normals.astype("<f4").tobytes()
        if flags & 2:
            body += uv.astype("<f4").tobytes()
        shapes.append(struct.pack("<HH", 0x041C, 4) + zlib.compress(body + triangles.astype("<u4").tobytes()))
    offsets = struct.pack("<QQ", 0, len(shapes[0])) + struct.pack("<I", 2)
    (folder / "mesh.serialized").write_bytes(b"".join(shapes) + offsets)


def for_mitsuba(path):
    """A copy in which what Mitsuba 3.9 no longer reads is written as it wants it: lookAt, colours in hexadecimals."""
    def linear(match):
        c = np.array([int(match[2][i:i + 2], 16) for i in (0, 2, 4)]) / 255
        c = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
        return f'{match[1]}"{c[0]:.6f}, {c[1]:.6f}, {c[2]:.6f}"'

    text = path.read_text().replace("lookAt", "lookat").replace("<srgb", "<rgb")
    text = re.sub(r'(value=)"#([0-9a-f]{6})"', linear, text)
    copy = path.with_name("mitsuba_" + path.name)
    copy.write_text(text)
    return str(copy)


def quadrants(image):
    h, w = image.shape[0] // 2, image.shape[1] // 2
    return np.array([image[y:y + h, x:x + w, :3].mean((0, 1)) for y in (0, h) for x in (0, w)], float)


def rgb_pixels(path):
    bitmap = mi.Bitmap(str(path))
    names = [field.name for field in bitmap.struct_()]
    return np.array(bitmap)[:, :, [names.index(c) for c in "RGB"]]


def compare(program, folder, name, keep):
    scene, reference = folder / (name + ".xml"), folder / (name + "_reference.xml")
    definitions = DEFINITIONS.get(name, {})
    spp = SAMPLES.get(name, 144) // BATCHES
    theirs, ours, pictures = [], [], ([], [])
    try:
        loaded = mi.load_file(for_mitsuba(reference if reference.exists() else scene), **definitions)
    except RuntimeError as problem:
        return f"Mitsuba: {problem}"
    for seed in range(BATCHES):
        picture = np.array(mi.render(loaded, spp=spp, seed=seed + 1))[..., :3]
        pictures[0].append(picture)
        theirs.append(quadrants(picture))
    for seed in range(BATCHES):
        out = folder / "out.exr"
        # Both ways of writing -D.
        extra = [a for i, (k, v) in enumerate(definitions.items()) for a in ([f"-D{k}={v}"] if i else ["-D", f"{k}={v}"])]
        command = [program, "render", str(scene), "-o", str(out), "--spp", str(spp), "--seed", str(seed + 1), "-q", *extra]
        result = subprocess.run(command, capture_output=True, text=True, timeout=120)
        if result.returncode:
            return f"exit code {result.returncode}: {result.stderr.strip()}"
        if seed == 0 and result.stderr.strip():
            print("   ", result.stderr.strip().replace(str(folder) + "/", "").replace("\n", "\n    "))
        picture = rgb_pixels(out)
        pictures[1].append(picture)
        ours.append(quadrants(picture))
    if pictures[0][0].shape != pictures[1][0].shape:
        return f"sizes differ: {pictures[0][0].shape} and {pictures[1][0].shape}"
    a, b = np.mean(theirs, 0), np.mean(ours, 0)
    error = np.sqrt(np.var(theirs, 0, ddof=1) / BATCHES + np.var(ours, 0, ddof=1) / BATCHES)
    if keep:
        pair = np.concatenate([np.mean(p, 0) for p in pictures], 1).repeat(6, 0).repeat(6, 1).astype(np.float32)
        mi.util.write_bitmap(str(keep / (name + ".png")), pair)
    worst = np.max(np.abs(b - a) / (TOLERANCE * a + 4 * error + 1e-6))
    deviation = np.max(np.abs(b / np.maximum(a, 1e-9) - 1))
    noise = np.max(error / np.maximum(a, 1e-9))
    print(f"{'ok  ' if worst <= 1 else 'FAIL'} {name}: largest deviation {100 * deviation:.2f} %, standard error {100 * noise:.2f} %")
    if noise > 0.02:
        return "too noisy to say anything"
    return None if worst <= 1 else "quadrants, theirs and ours:\n" + str(np.concatenate([a, b], 1).round(4))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--keep", type=pathlib.Path, help="write both pictures of every scene there, side by side")
    arguments = parser.parse_args()
    helpers = ("_reference", "parts_")
    names = arguments.scenes or [p.stem for p in sorted(SCENES.glob("*.xml")) if not any(h in p.stem for h in helpers)]
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for file in SCENES.glob("*.xml"):
            shutil.copy(file, folder)
        images(folder)
        meshes(folder)
        for name in names:
            problem = compare(str(pathlib.Path(arguments.program).resolve()), folder, name, arguments.keep)
            if problem:
                failures += 1
                print(f"FAIL {name}: {problem}")
            sys.stdout.flush()
    print(f"{failures} of {len(names)} scenes differ")
    return failures > 0


if __name__ == "__main__":
    sys.exit(main())
