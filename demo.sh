#!/usr/bin/env bash
# The whole path on the project's own lamp and room: bake, render with the baked lamp, render the same room with our
# bidirectional path tracer in the same CPU time, make a reference, compare, report. Ends with the figures.
# usage: ./demo.sh [SECONDS]      of rendering for the two compared pictures (default 15); results in out/demo
set -euo pipefail
cd "$(dirname "$0")"
seconds=${1:-15}
tools/setup.sh build
out=out/demo
mkdir -p $out
sconce=build/release/sconce
room=scenes/demo_room.xml

build/release/make_demo_lamp $out
echo "== bake the lamp"
$sconce bake $out/demo_lamp.xml -o $out/demo_lamp.safetensors --json >$out/bake.json
echo "== the room with the baked lamp, as its file shows it"
$sconce render $room -D "lamp=$PWD/$out/demo_lamp.safetensors" -D appearance=surface -i path -s "$seconds" -o $out/baked.exr --png $out/baked.png --mask $out/mask.exr --json >$out/baked.json
echo "== the same, the camera seeing the lamp's geometry"
$sconce render $room -D "lamp=$PWD/$out/demo_lamp.safetensors" -D appearance=geometry -D keep=all -i path -s "$seconds" -o $out/baked_look.exr --png $out/baked_look.png --json >$out/baked_look.json
echo "== the room with the lamp's geometry, bidirectional, the same time"
$sconce render $room -D "lamp=$PWD/$out/demo_lamp.xml" -i bdpt -s "$seconds" -o $out/bdpt.exr --png $out/bdpt.png --json >$out/bdpt.json
echo "== the reference: the same for six times as long"
$sconce render $room -D "lamp=$PWD/$out/demo_lamp.xml" -i bdpt -s "$((6 * seconds))" --seed 1000 -o $out/reference.exr --png $out/reference.png --json >$out/reference.json

for name in baked baked_look bdpt; do
  $sconce compare $out/$name.exr $out/reference.exr --mask $out/mask.exr --json >$out/$name.compare.json
done
$sconce report -o $out/report.html --title "sconce: the demonstration lamp in its room" --mask $out/mask.exr \
  --bake $out/bake.json -r "reference (geometry, bdpt)=$out/reference.exr,$out/reference.json" \
  "baked lamp, path=$out/baked.exr,$out/baked.json" \
  "baked lamp, its geometry for the camera=$out/baked_look.exr,$out/baked_look.json" "geometry, bdpt, same time=$out/bdpt.exr,$out/bdpt.json" >/dev/null

python3 - $out <<'PYTHON'
import json, sys
out = sys.argv[1]
load = lambda name: json.load(open(f"{out}/{name}.json"))
bake = load("bake")
print()
print(f"baked lamp: {bake['bytes'] / 1e6:.2f} MB in {bake['seconds']:.0f} s, flux off by " + ", ".join(f"{100 * e:+.2f} %" for e in bake["flux_error"]))
print(f"{'outside the lamp':<28}{'CPU s':>8}{'spp':>6}{'relMSE':>10}{'less ref. noise':>17}{'worst block':>13}")
errors = {}
for name, label in (("baked", "baked lamp, path"), ("baked_look", "  its geometry looked at"), ("bdpt", "geometry, bdpt")):
    render, compare = load(name), load(f"{name}.compare")
    errors[name] = max(compare["rel_mse_corrected"], 1e-9)
    print(f"{label:<28}{render['cpu_s']:8.1f}{render['samples']:6d}{compare['rel_mse']:10.5f}{compare['rel_mse_corrected']:17.5f}{100 * compare['block_error_max']:11.2f} %")
print(f"at the same time the baked lamp's error is {errors['bdpt'] / errors['baked']:.1f} times lower")
print(f"report: {out}/report.html")
PYTHON
