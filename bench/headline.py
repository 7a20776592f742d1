#!/usr/bin/env python3
"""The table of the README: two lamps baked, their rooms rendered with the baked lamp and with our bidirectional path tracer in
the same CPU time, both against a long rendering of the real geometry.

usage: bench/headline.py [--seconds S] [--reference S] [--scene flower|demo] [--quality Q] [--out DIR] [--json]
The flower is the published Cherry Blossom chandelier; it is looked for in ../shared/scenes/zhu2021/flower."""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCONCE = ROOT / "build/release/sconce"
FLOWER = ROOT.parent / "shared/scenes/zhu2021/flower"
LAMP_PARTS = {"metalpart", "emitter", "glass_part", "glass_middle", "hanger"}


def sconce(*arguments):
    result = subprocess.run([SCONCE, *map(str, arguments), "--json"], stdout=subprocess.PIPE, text=True)
    if result.returncode:
        sys.exit(result.returncode)
    return json.loads(result.stdout)


def flower_room(folder):
    """cbox_flower_lum.xml with the lamp's parts replaced by a luminaire shape."""
    tree = ElementTree.parse(FLOWER / "cbox_flower_lum.xml")
    root = tree.getroot()
    for shape in list(root.findall("shape")):
        if shape.get("id") in LAMP_PARTS:
            root.remove(shape)
    for name in root.iter("string"):
        if name.get("name") == "filename":
            name.set("value", str(FLOWER / name.get("value")))
    luminaire = ElementTree.SubElement(root, "shape", type="luminaire")
    for key in ("filename", "keep", "appearance"):
        ElementTree.SubElement(luminaire, "string", name=key, value="$lamp" if key == "filename" else f"${key}")
    for key, value in (("keep", "none"), ("appearance", "neural")):
        root.insert(0, ElementTree.Element("default", name=key, value=value))
    tree.write(folder / "room.xml")
    return folder / "room.xml", FLOWER / "flower_lum_only.xml", "320x240"


def demo_room(folder):
    subprocess.run([ROOT / "build/release/make_demo_lamp", folder], check=True)
    return ROOT / "scenes/demo_room.xml", folder / "demo_lamp.xml", "320x240"


def reference_integrator(scene):
    # The flower's box has no mirror: light tracing reaches the whole picture and is the least noisy there.
    return "particle" if scene == "flower" else "bdpt"


def measure(name, options):
    folder = (options.out / name).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    if name == "flower" and not FLOWER.exists():
        print(f"skipped: the flower lamp is not at {FLOWER}", file=sys.stderr)
        return None
    room, lamp, size = {"flower": flower_room, "demo": demo_room}[name](folder)
    baked = folder / "lamp.safetensors"
    if options.keep_bake and baked.exists():
        bake = json.loads((folder / "bake.json").read_text())
    else:
        bake = sconce("bake", lamp, "-o", baked, "--quality", options.quality)
        (folder / "bake.json").write_text(json.dumps(bake))
    render = lambda output, geometry, *rest: sconce("render", room, f"-Dlamp={lamp if geometry else baked}", "--size", size,
                                                    "-o", folder / output, "--png", (folder / output).with_suffix(".png"), *rest)
    reference = folder / "reference.exr"
    if not (options.keep_reference and reference.exists()):
        render("reference.exr", True, "-i", reference_integrator(name), "-s", options.reference, "--seed", 1000)
    ours = render("ours.exr", False, "-i", "path", "-s", options.seconds, "--mask", folder / "mask.exr")
    bdpt = render("bdpt.exr", True, "-i", "bdpt", "-s", ours["cpu_s"] / os.cpu_count())
    compare = lambda output: sconce("compare", folder / output, reference, "--mask", folder / "mask.exr")
    ours_error, bdpt_error = compare("ours.exr"), compare("bdpt.exr")
    return {"scene": name, "flux_error": bake["flux_error"], "irradiance": bake["irradiance"], "sample_variance": bake["sample_variance"],
            "bake_seconds": bake["seconds"], "bytes": bake["bytes"], "cpu_s": [ours["cpu_s"], bdpt["cpu_s"]],
            "samples": [ours["samples"], bdpt["samples"]], "rel_mse": [ours_error["rel_mse_corrected"], bdpt_error["rel_mse_corrected"]],
            "rel_mse_with_reference_noise": [ours_error["rel_mse"], bdpt_error["rel_mse"]],
            "ratio": bdpt_error["rel_mse_corrected"] / max(ours_error["rel_mse_corrected"], 1e-12),
            "block_error_max": ours_error["block_error_max"], "block_error_mean": ours_error["block_error_mean"],
            "block_error_max_bdpt": bdpt_error["block_error_max"], "mean_ratio": ours_error["mean_ratio"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=20, help="wall time of our rendering; bdpt gets the same CPU time")
    parser.add_argument("--reference", type=float, default=300, help="wall time of the reference")
    parser.add_argument("--scene", choices=("flower", "demo"))
    parser.add_argument("--quality", default="standard")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/headline")
    parser.add_argument("--keep-bake", action="store_true", help="use the lamp of an earlier run")
    parser.add_argument("--keep-reference", action="store_true", help="use the reference of an earlier run")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = [row for row in (measure(name, options) for name in ([options.scene] if options.scene else ("flower", "demo"))) if row]
    if options.json:
        print(json.dumps(rows))
        return
    for row in rows:
        print(f"## {row['scene']}")
        print("| figure | measured |\n|---|---|")
        print("| flux error per channel | " + ", ".join(f"{100 * e:+.2f} %" for e in row["flux_error"]) + " |")
        print("| irradiance error (reference noise) | " + ", ".join(
            f"{100 * at['error']:.1f} % ({100 * at['reference_noise']:.1f} %) at {at['radii']:.3g} r" for at in row["irradiance"]) + " |")
        print(f"| 16 blocks outside the lamp, mean off by | {100 * row['block_error_max']:.2f} % at most, {100 * row['block_error_mean']:.2f} % on average (bdpt: {100 * row['block_error_max_bdpt']:.2f} % at most) |")
        print(f"| relMSE outside the lamp, {row['cpu_s'][0]:.0f} CPU s | ours {row['rel_mse'][0]:.5f} ({row['samples'][0]} spp), bdpt {row['rel_mse'][1]:.5f} ({row['samples'][1]} spp): {row['ratio']:.1f} times lower |")
        print(f"| bake | {row['bake_seconds']:.0f} s |\n| file | {row['bytes'] / 1e6:.2f} MB |\n")


if __name__ == "__main__":
    main()
