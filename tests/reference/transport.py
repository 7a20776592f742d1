#!/usr/bin/env python3
"""Compares whole pictures with Mitsuba 3: the scenes of tests/scenes, rendered by both programs from the same file, and
the published flower in its box where it is present (its 0.5.0 file is rebuilt for Mitsuba 3 here).

    transport.py PROGRAM [--scene SCENE ...] [--flower FOLDER]

The mean of every quadrant and of every colour must agree within 1.5 %, and the standard error of their difference must
be below 0.5 %, else the comparison says nothing and fails. Mitsuba's light tracing (`ptracer`) is the reference where it
can see the scene, else its path tracer. Needs the Python packages of requirements.txt."""
import argparse
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
mi.logger().clear_appenders()  # no progress bars
ROOT = pathlib.Path(__file__).resolve().parents[2]
TOLERANCE, NOISE = 0.015, 0.005
BATCHES = 16  # independent seeds on both sides: their spread is the standard error

# Scenes with masks are not among them: Mitsuba's shadow rays stop there, so its light tracing loses 2 % of tests/scenes/mask.xml
# (its path tracer, slow without shadow rays, agrees with us); tests/stat/trace/test_agree.c compares our integrators there.
# scene: (reference integrator, samples of the reference, our integrators with their samples)
TABLE = {
    "box_area": ("ptracer", 768, {"path": 256, "bdpt": 256, "particle": 512}),
    "rough_lamp": ("ptracer", 1536, {"bdpt": 1024, "particle": 2048}),
    "glass_shell": ("ptracer", 2048, {"bdpt": 2048, "particle": 2048}),
    "textured_lamp": ("ptracer", 1024, {"path": 512, "bdpt": 512, "particle": 1024}),
    "spot": ("ptracer", 1024, {"path": 1024, "bdpt": 512, "particle": 1024}),
    "point": ("ptracer", 2048, {"path": 256, "bdpt": 256, "particle": 1024}),
    "envmap": ("path", 512, {"path": 512, "bdpt": 512}),
    "constant": ("path", 512, {"path": 512, "bdpt": 256}),
    "thinlens": ("ptracer", 512, {"particle": 512}),
    "orthographic": ("path", 512, {"path": 512, "bdpt": 256, "particle": 1024}),
    "mirror": ("path", 5120, {"bdpt": 1024, "particle": 1024}),
}
# Circles of pixels (x, y, radius) that see the lamp itself or its glint are left out where they hold most of the noise.
LAMPS = {"rough_lamp": [(20.5, 19.9, 6.5), (14.2, 22.4, 2.5)], "flower": [(32, 24, 32 * 0.16)]}


def means_of(image, mask):
    """The mean of each quadrant and of each colour over the pixels of the mask: 4 + 3 numbers."""
    h, w = image.shape[0] // 2, image.shape[1] // 2
    parts = [image[y:y + h, x:x + w][mask[y:y + h, x:x + w]] for y in (0, h) for x in (0, w)]
    return np.array([*(part.mean() for part in parts), *np.concatenate(parts).mean(0)], float)


def room_mask(name, shape):
    y, x = np.mgrid[0.5:shape[0], 0.5:shape[1]]
    return np.all([np.hypot(x - cx, y - cy) >= radius for cx, cy, radius in LAMPS.get(name, [(0, 0, 0)])], 0)


def rgb_pixels(path):
    """The colour channels of an EXR file that holds variances too."""
    bitmap = mi.Bitmap(str(path))
    names = [field.name for field in bitmap.struct_()]
    return np.array(bitmap)[:, :, [names.index(c) for c in "RGB"]]


def ours(program, scene, integrator, samples, extra=()):
    """Images of BATCHES seeds."""
    images = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(BATCHES):
            out = pathlib.Path(folder) / "out.exr"
            command = [program, "render", str(scene), "-o", str(out), "--integrator", integrator, "--spp",
                       str(max(samples // BATCHES, 1)), "--seed", str(seed + 1), "--quiet", *extra]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                sys.exit(f"{' '.join(command)} failed:\n{done.stderr}")
            images.append(rgb_pixels(out))
    return np.array(images)


def theirs(scene, integrator, samples, depth, rr_depth):
    tracer = mi.load_dict({"type": integrator, "max_depth": depth, "rr_depth": rr_depth,
                           **({} if integrator == "ptracer" else {"block_size": 4})})
    return np.array([np.array(mi.render(scene, integrator=tracer, spp=max(samples // BATCHES, 1), seed=seed + 1))
                     for seed in range(BATCHES)])


def judge(name, result, reference, means, noise=NOISE):
    """Prints one line; True where all means agree."""
    a_all, b_all = (np.array([means(image) for image in images]) for images in (result, reference))
    a, b = a_all.mean(0), b_all.mean(0)
    a_error, b_error = (x.std(0, ddof=1) / np.sqrt(BATCHES) / b for x in (a_all, b_all))
    difference, error = np.abs(a / b - 1), np.hypot(a_error, b_error)
    wrong, noisy = not (difference <= TOLERANCE).all(), not (error <= noise).all()  # so that NaN is wrong
    verdict = "TOO NOISY" if noisy else "WRONG" if wrong else "ok"
    print(f"{name:34s} mean ratio {(a.mean() / b.mean()):.4f}  largest difference {100 * difference.max():5.2f} % "
          f"(standard error ours {100 * a_error.max():.2f} %, theirs {100 * b_error.max():.2f} %)  {verdict}", flush=True)
    return not (wrong or noisy)


def compare_scene(program, name):
    integrator, samples, table = TABLE[name]
    path = ROOT / "tests" / "scenes" / f"{name}.xml"
    text = path.read_text()
    depth, rr_depth = (int(re.search(rf'name="{key}" value="(-?\d+)"', text)[1]) for key in ("max_depth", "rr_depth"))
    reference = theirs(mi.load_file(str(path)), integrator, samples, depth, rr_depth)
    mask = room_mask(name, reference.shape[1:3])
    return all([judge(f"{name} {ours_name}", ours(program, path, ours_name, n), reference,
                      lambda image: means_of(image, mask)) for ours_name, n in table.items()])


def modern(text, folder):
    """The 0.5.0 file as one that Mitsuba 3 reads: names in its spelling, spectra as the colours it makes of them."""
    def spectrum(match):
        pairs = [tuple(map(float, p.split(":"))) for p in match[2].split(",")]
        color = mi.spectrum_list_to_srgb([p[0] for p in pairs], [p[1] for p in pairs], bounded=True, d65=True)
        return f'<rgb name="{match[1]}" value="{color[0]:.7f}, {color[1]:.7f}, {color[2]:.7f}"/>'

    text = re.sub(r"<!--.*?-->", "", text, flags=re.S)
    text = re.sub(r'<spectrum name="(\w+)" value="([^"]*:[^"]*)"/>', spectrum, text)
    text = re.sub(r"<integrator.*?</integrator>", "", text, flags=re.S)
    text = re.sub(r"<sampler.*?</sampler>", '<sampler type="independent"/>', text, flags=re.S)
    text = re.sub(r"<film.*?</film>", '<film type="hdrfilm"><integer name="width" value="64"/>'
                  '<integer name="height" value="48"/><rfilter type="box"/></film>', text, flags=re.S)
    text = re.sub(r'name\s*=\s*"(\w+)"', lambda m: 'name="' + re.sub(r"([A-Z])", lambda c: "_" + c[1].lower(), m[1]) + '"', text)
    text = text.replace('version="0.5.0"', 'version="3.0.0"')
    text = re.sub(r'(name="filename" value=")([^"]*)"', lambda m: f'{m[1]}{folder / m[2]}"', text)
    return text.replace("<?xml version='1.0' encoding='utf-8'?>", "")


def compare_flower(program, folder):
    """The room per quadrant without the pixels of the lamp, which hold most of the light and most of the noise; then the
    middle of the lamp, as large as 4 x 4 pixels, all together, against camera paths."""
    text = modern((folder / "cbox_flower_lum.xml").read_text(), folder)
    crop = "".join(f'<integer name="crop_{name}" value="{value}"/>' for name, value in
                   (("offset_x", 480), ("offset_y", 352), ("width", 64), ("height", 64)))
    middle = text.replace('name="width" value="64"', 'name="width" value="1024"').replace(
        'name="height" value="48"', 'name="height" value="768"').replace('<rfilter type="box"/>', crop + '<rfilter type="box"/>')
    mask = room_mask("flower", (48, 64))
    good = True
    with tempfile.TemporaryDirectory() as temporary:
        rebuilt = pathlib.Path(temporary) / "flower.xml"
        rebuilt.write_text(text)
        reference = theirs(mi.load_string(text), "ptracer", 512, 32, 5)
        for name, samples in (("bdpt", 256), ("particle", 512)):
            good &= judge(f"flower {name}, outside the lamp", ours(program, rebuilt, name, samples, ["--max-depth", "32"]),
                          reference, lambda image: means_of(image, mask))
        rebuilt.write_text(middle)
        reference = theirs(mi.load_string(middle), "path", 352, 5, 5)
        good &= judge("flower bdpt, the lamp", ours(program, rebuilt, "bdpt", 352, ["--max-depth", "5"]), reference,
                      lambda image: image.mean((0, 1)), 0.006)
    return good


def cpu_seconds():
    return sum(u.ru_utime for u in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--scene", action="append", help=f"one of {', '.join(TABLE)}, flower; none: all")
    parser.add_argument("--flower", type=pathlib.Path, default=ROOT / ".." / "shared" / "scenes" / "zhu2021" / "flower")
    options = parser.parse_args()
    good = True
    for name in options.scene or [*TABLE, "flower"]:
        begin, cpu = time.time(), cpu_seconds()
        if name != "flower":
            good &= compare_scene(options.program, name)
        elif (options.flower / "cbox_flower_lum.xml").exists():
            good &= compare_flower(options.program, options.flower.resolve())
        else:
            print("skipped: flower, its files are not here")
            continue
        print(f"{'':34s} {time.time() - begin:.1f} s, {cpu_seconds() - cpu:.1f} CPU s", flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
