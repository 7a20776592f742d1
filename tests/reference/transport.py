#!/usr/bin/env python3
"""Compares whole pictures with Mitsuba 3: the scenes of tests/scenes, rendered by both programs from the same file, and
the published flower in its box where it is present (its 0.5.0 file is rebuilt for Mitsuba 3 here).

    transport.py PROGRAM [SCENE ...] [--quick] [--flower FOLDER]

The mean of every quadrant must agree within 1.5 %, widened by four standard errors of both sides. Mitsuba's own path
tracer is the reference, or its `ptracer` (light tracing) where the table says so. Needs the Python packages of
requirements.txt; fails where a comparison is too noisy to say anything."""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
ROOT = pathlib.Path(__file__).resolve().parents[2]
TOLERANCE = 0.015

# scene: (reference integrator, samples of the reference, our integrators with their samples)
TABLE = {
    "box_area": ("path", 4096, {"path": 4096, "bdpt": 2048, "particle": 4096}),
    "rough_lamp": ("path", 4096, {"path": 4096, "bdpt": 1024, "particle": 2048}),
    "glass_shell": ("ptracer", 4096, {"bdpt": 1024, "particle": 4096}),
    "textured_lamp": ("path", 4096, {"path": 4096, "bdpt": 2048, "particle": 4096}),
    "spot": ("path", 4096, {"path": 4096, "bdpt": 2048, "particle": 4096}),
    "point": ("path", 4096, {"path": 4096, "bdpt": 2048, "particle": 4096}),
    "envmap": ("path", 2048, {"path": 2048, "bdpt": 1024, "particle": 4096}),
    "constant": ("path", 2048, {"path": 2048, "bdpt": 1024, "particle": 4096}),
    "thinlens": ("path", 4096, {"path": 4096, "bdpt": 2048, "particle": 4096}),
    "orthographic": ("path", 4096, {"path": 4096, "bdpt": 2048, "particle": 4096}),
    "mask": ("ptracer", 4096, {"path": 4096, "bdpt": 2048, "particle": 4096}),
}
BATCHES = 8  # independent seeds on both sides: their spread is the standard error


def quadrants(image):
    """Means of the four quadrants, 4 x 3."""
    h, w = image.shape[0] // 2, image.shape[1] // 2
    return np.array([image[y:y + h, x:x + w, :3].mean((0, 1)) for y in (0, h) for x in (0, w)], float)


def rgb_pixels(path):
    """The colour channels of an EXR file that holds variances too."""
    bitmap = mi.Bitmap(str(path))
    names = [field.name for field in bitmap.struct_()]
    return np.array(bitmap)[:, :, [names.index(c) for c in "RGB"]]


def ours(program, scene, integrator, samples, extra=()):
    means = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(BATCHES):
            out = pathlib.Path(folder) / "out.exr"
            command = [program, "render", str(scene), "-o", str(out), "--integrator", integrator, "--spp",
                       str(max(samples // BATCHES, 1)), "--seed", str(seed + 1), "--quiet", *extra]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                sys.exit(f"{' '.join(command)} failed:\n{done.stderr}")
            means.append(quadrants(rgb_pixels(out)))
    return np.mean(means, 0), np.std(means, 0, ddof=1) / np.sqrt(BATCHES)


def theirs(scene, integrator, samples, depth, rr_depth):
    tracer = mi.load_dict({"type": integrator, "max_depth": depth, "rr_depth": rr_depth})
    means = [quadrants(np.array(mi.render(scene, integrator=tracer, spp=max(samples // BATCHES, 1), seed=seed + 1)))
             for seed in range(BATCHES)]
    return np.mean(means, 0), np.std(means, 0, ddof=1) / np.sqrt(BATCHES)


def judge(name, result, reference):
    """Prints one line; True where all quadrants agree."""
    (a, a_error), (b, b_error) = result, reference
    difference = np.abs(a / b - 1)
    error = np.sqrt(a_error ** 2 + b_error ** 2) / b
    too_noisy = not (error <= 0.015).all()
    wrong = not (difference <= TOLERANCE + 4 * error).all()  # so that NaN is wrong
    verdict = "WRONG" if wrong else "TOO NOISY" if too_noisy else "ok"
    print(f"{name:28s} mean ratio {(a.mean() / b.mean()):.4f}  largest difference {100 * difference.max():5.2f} % "
          f"(standard error {100 * error.max():.2f} %)  {verdict}", flush=True)
    return not (wrong or too_noisy)


def compare_scene(program, name, quick):
    integrator, samples, table = TABLE[name]
    path = ROOT / "tests" / "scenes" / f"{name}.xml"
    text = path.read_text()
    depth, rr_depth = (int(re.search(rf'name="{key}" value="(-?\d+)"', text)[1]) for key in ("max_depth", "rr_depth"))
    share = 4 if quick else 1
    reference = theirs(mi.load_file(str(path)), integrator, samples // share, depth, rr_depth)
    return all([judge(f"{name} {ours_name}", ours(program, path, ours_name, n // share), reference)
                for ours_name, n in table.items()])


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


def compare_flower(program, folder, quick):
    path = folder / "cbox_flower_lum.xml"
    text = modern(path.read_text(), folder)
    scene = mi.load_string(text)
    share = 4 if quick else 1
    reference = theirs(scene, "ptracer", 6144 // share, 32, 5)
    extra = ["--size", "64x48", "--max-depth", "32"]
    with tempfile.TemporaryDirectory() as temporary:  # the same text for both: the filter of the original is a Gaussian
        rebuilt = pathlib.Path(temporary) / "flower.xml"
        rebuilt.write_text(text)
        good = [judge(f"flower {name}", ours(program, source, name, n // share, extra), reference)
                for name, n, source in (("bdpt", 1024, rebuilt), ("particle", 2048, rebuilt), ("bdpt", 1024, path))]
    return all(good)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"{', '.join(TABLE)}, flower; none: all")
    parser.add_argument("--quick", action="store_true", help="a quarter of the samples")
    parser.add_argument("--flower", type=pathlib.Path, default=ROOT / ".." / "shared" / "scenes" / "zhu2021" / "flower")
    options = parser.parse_args()
    names = options.scenes or [*TABLE, "flower"]
    good = True
    for name in names:
        if name != "flower":
            good &= compare_scene(options.program, name, options.quick)
        elif (options.flower / "cbox_flower_lum.xml").exists():
            good &= compare_flower(options.program, options.flower.resolve(), options.quick)
        else:
            print("flower: skipped, its files are not here")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
