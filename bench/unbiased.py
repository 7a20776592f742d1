#!/usr/bin/env python3
"""What --unbiased costs: relMSE times CPU seconds of the baked lamp as it is, of the same with --unbiased and of the bidirectional
path tracer on the lamp's geometry, in the rooms of headline.py, whose lamps, references and masks (in DIR/NAME) it uses.

usage: bench/unbiased.py [--seconds S] [--scene flower|demo] [--out DIR] [--threads N] [--json]"""
import argparse
import json
import os
import pathlib
import sys
import tempfile

import headline

FIGURES = (("rel_mse_seconds", "relMSE x CPU s"), ("mse_seconds", "MSE x CPU s"), ("worst_block", "worst of 16 blocks"))


def measure(name, options):
    folder = (options.out / name).resolve()
    baked, reference, mask = (folder / file for file in ("lamp.safetensors", "reference.exr", "mask.exr"))
    if not all(file.exists() for file in (baked, reference, mask)):
        sys.exit(f"{folder}: no lamp, reference or mask; run bench/headline.py --scene {name} first")
    room = folder / "room.xml" if name == "flower" else headline.ROOT / "scenes/demo_room.xml"
    lamp = headline.FLOWER / "flower_lum_only.xml" if name == "flower" else folder / "demo_lamp.xml"
    row = {"scene": name}
    with tempfile.TemporaryDirectory() as pictures:
        for kind, file, arguments in (("baked", baked, ["-i", "path"]), ("unbiased", baked, ["-i", "path", "--unbiased"]),
                                      ("bdpt", lamp, ["-i", "bdpt"])):
            picture = pathlib.Path(pictures) / f"{kind}.exr"
            rendered = headline.sconce("render", room, f"-Dlamp={file}", "--size", "320x240", "-o", picture, "-s", options.seconds, "-q",
                                       "--threads", options.threads, *arguments)
            error = headline.sconce("compare", picture, reference, "--mask", mask)
            row[kind] = {"cpu_s": rendered["cpu_s"], "samples": rendered["samples"], "rel_mse": error["rel_mse_corrected"],
                         "rel_mse_seconds": error["rel_mse_corrected"] * rendered["cpu_s"], "mse_seconds": error["mse"] * rendered["cpu_s"],
                         "worst_block": error["block_error_max"]}
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=20, help="wall time of each rendering")
    parser.add_argument("--scene", choices=("flower", "demo"))
    parser.add_argument("--out", type=pathlib.Path, default=headline.ROOT / "out/headline", help="of headline.py")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = [measure(name, options) for name in ([options.scene] if options.scene else ("flower", "demo"))]
    if options.json:
        print(json.dumps(rows))
        return
    print("| scene | figure | baked | unbiased | bdpt | unbiased / baked | bdpt / unbiased |\n|---|---|---|---|---|---|---|")
    for row in rows:
        for key, title in FIGURES:
            baked, unbiased, bdpt = (row[kind][key] for kind in ("baked", "unbiased", "bdpt"))
            print(f"| {row['scene']} | {title} | {baked:.3g} | {unbiased:.3g} | {bdpt:.3g} | {unbiased / baked:.2f} | {bdpt / unbiased:.2f} |")


if __name__ == "__main__":
    main()
