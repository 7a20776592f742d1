#!/usr/bin/env python3
"""How a baked lamp looks: rendered before a black background from 8 directions as neural, surface and geometry, each against a
long rendering of the lamp itself. PSNR of log(1 + x) over that of a black picture, FLIP, and the ratio of means.

usage: bench/direct_view.py LAMP.xml LAMP.safetensors [--size N] [--spp N] [--reference S] [--out DIR] [--json]
The pictures are left in DIR. Noise of both sides is in the figures: those of geometry,
which would be perfect, say how much."""
import argparse
import json
import math
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCONCE = ROOT / "build/release/sconce"
APPEARANCES = ("neural", "surface", "geometry")
SCENE = """<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="100"/></integrator>
<sensor type="perspective"><float name="fov" value="39.5"/><transform name="to_world"><lookat origin="{o[0]}, {o[1]}, {o[2]}"
target="{c[0]}, {c[1]}, {c[2]}" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="{size}"/><integer name="height" value="{size}"/><rfilter type="box"/></film></sensor>
{lamp}</scene>"""
LAMP = '<shape type="luminaire"><string name="filename" value="{}"/>{}</shape>'


def sconce(*arguments):
    result = subprocess.run([SCONCE, *map(str, arguments), "--json", "--quiet"], stdout=subprocess.PIPE, text=True)
    if result.returncode:
        sys.exit(result.returncode)
    return json.loads(result.stdout)


def views(center, radius):
    for i in range(8):
        azimuth, height = math.radians(45 * i + 20), math.radians(-35 if i % 2 else 20)
        d = (math.cos(height) * math.sin(azimuth), math.sin(height), math.cos(height) * math.cos(azimuth))
        yield [c + 3 * radius * x for c, x in zip(center, d)]


def measure(options):
    options.out.mkdir(parents=True, exist_ok=True)
    info = sconce("info", options.baked)
    sums = {a: {"gain_db": 0.0, "flip": 0.0, "mean_ratio": 0.0} for a in APPEARANCES}
    for i, origin in enumerate(views(info["center"], info["radius"])):
        def render(name, lamp, *rest):
            scene = options.out / f"{name}_{i}.xml"
            scene.write_text(SCENE.format(o=origin, c=info["center"], size=options.size, lamp=lamp))
            sconce("render", scene, "-o", scene.with_suffix(".exr"), "--png", scene.with_suffix(".png"), *rest)
            return scene.with_suffix(".exr")

        reference = options.out / f"reference_{i}.exr"
        if not (options.keep_reference and reference.exists()):
            render("reference", LAMP.format(options.lamp.resolve(), ""), "-i", options.integrator, "-s", options.reference, "--seed", 1)
        black = sconce("compare", render("black", "", "--spp", 1), reference)["psnr_log_db"]
        for appearance in APPEARANCES:
            more = f'<string name="appearance" value="{appearance}"/><string name="geometry" value="{options.lamp.resolve()}"/>'
            picture = render(appearance, LAMP.format(options.baked.resolve(), more), "--spp", options.spp)
            figures = sconce("compare", picture, reference)
            sums[appearance]["gain_db"] += (figures["psnr_log_db"] - black) / 8
            sums[appearance]["flip"] += figures["flip"] / 8
            sums[appearance]["mean_ratio"] += sum(figures["mean_ratio"]) / 24
    return sums


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lamp", type=pathlib.Path)
    parser.add_argument("baked", type=pathlib.Path)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--reference", type=float, default=60, help="wall time of each reference")
    parser.add_argument("--integrator", default="bdpt", help="of the reference")
    parser.add_argument("--keep-reference", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/direct_view")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = measure(options)
    if options.json:
        print(json.dumps(rows))
        return
    print("| appearance | dB over black | FLIP | ratio of means |\n|---|---|---|---|")
    for name, row in rows.items():
        print(f"| {name} | {row['gain_db']:.1f} | {row['flip']:.3f} | {row['mean_ratio']:.3f} |")


if __name__ == "__main__":
    main()
