#!/usr/bin/env python3
"""CPU seconds to an error: rooms lit by a complicated lamp, rendered with the baked lamp and by everything else.

usage: bench/time_to_error.py [--scene flower|crystal] [--seconds S] [--reference S] [--out DIR] [--json]

The error is relMSE (eps 1e-3) outside the lamp against a long rendering of the real geometry, freed of that rendering's noise; so
what the baked lamp gets wrong is in it. Every renderer runs with 1, 2, 4 ... samples until it has had S CPU seconds. Where an
error lies between two runs it is interpolated; where it was not reached for good, it follows from noise ~ 1 / time (the median over
the runs; ours, which runs 6 S seconds: with a constant bias) and is marked with *. "sphere" is the floor: the same room lit by a plain sphere of the lamp's flux, against its own reference.
Other renderers' errors hold what they do by other conventions too (Schlick's microfacets, tessellated spheres: a per cent; LuxCore: its brightness).
Mitsuba 3 (llvm variant: DRJIT_LIBLLVM_PATH may have to name a libLLVM that knows the processor) and LuxCore take part where their
Python packages are installed. Writes results.json and chart.svg."""
import argparse
import json
import math
import os
import pathlib
import re
import resource
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

from headline import FLOWER, ROOT, flower_room, reference_integrator, sconce

SCENES = {"flower": "Cherry Blossom in the box", "crystal": "crystal lamp, polished floor"}
TARGETS = (0.01, 0.001)
SIZE = (320, 240)
LEAST_TOLD = 5e-5  # less is lost in the reference's noise
BIAS_SHOWS = 6  # ours runs that many times longer, for its bias to be told from its noise
COLORS = {"ours": "#c1121f", "ours bdpt": "#1d3557", "ours particle": "#457b9d", "sphere": "#555555", "sphere, Mitsuba 3": "#999999",
          "Mitsuba 3 ptracer": "#2a9d8f", "LuxCore bidir": "#e9a03b"}


# --- The rooms. ---
def defaults_replaced(root, values):
    for element in root.findall("default"):
        values.setdefault(element.get("name"), element.get("value"))
        root.remove(element)
    for element in root.iter():
        for key, text in element.attrib.items():
            element.set(key, re.sub(r"\$(\w+)", lambda m: values.get(m[1], m[0]), text))


def modernize(root):
    """Mitsuba 3's spelling and this film's size; the lamp and the room stay."""
    for element in root.iter():
        if element.get("name"):
            element.set("name", re.sub(r"([A-Z])", lambda m: "_" + m[1].lower(), element.get("name")))
        if element.tag == "spectrum" and ":" not in element.get("value"):
            element.tag = "rgb"
    root.set("version", "3.0.0")
    integrator = root.find("integrator")
    integrator.set("type", "path")
    for child in list(integrator):
        if child.get("name") not in ("max_depth", "rr_depth"):
            integrator.remove(child)
    film = root.find("sensor").find("film")
    for child in list(film):
        film.remove(child)
    for name, value in zip(("width", "height"), SIZE):
        ElementTree.SubElement(film, "integer", name=name, value=str(value))
    film.set("type", "hdrfilm")
    ElementTree.SubElement(film, "rfilter", type="box")
    sampler = root.find("sensor").find("sampler")
    sampler.set("type", "independent")  # others round the number of samples up


def merged_room(room, lamp, out, sphere=None):
    """The room as one file that any reader of Mitsuba's scenes knows: the lamp's shapes, or a sphere, in place of the luminaire."""
    tree = ElementTree.parse(room)
    root = tree.getroot()
    defaults_replaced(root, {"lamp": str(lamp)})
    luminaire = next(s for s in root.findall("shape") if s.get("type") == "luminaire")
    root.remove(luminaire)
    placed = luminaire.find("transform")
    steps = list(placed) if placed is not None else []
    if sphere:
        center, radius, radiance = sphere
        shape = ElementTree.SubElement(root, "shape", type="sphere")
        ElementTree.SubElement(shape, "point", name="center", value=", ".join(map(str, center)))
        ElementTree.SubElement(shape, "float", name="radius", value=str(radius))
        ElementTree.SubElement(shape, "transform", name="to_world").extend(steps)
        emitter = ElementTree.SubElement(shape, "emitter", type="area")
        ElementTree.SubElement(emitter, "rgb", name="radiance", value=", ".join(map(str, radiance)))
        shapes = []
    else:
        parsed = ElementTree.parse(lamp).getroot()
        defaults_replaced(parsed, {})
        shapes = [e for e in parsed if e.tag in ("bsdf", "texture", "shape")]
    for element in shapes:
        for inner in element.iter():
            if inner.get("id"):
                inner.set("id", "lamp_" + inner.get("id"))
            if inner.tag == "string" and inner.get("name") == "filename":
                inner.set("value", str((pathlib.Path(lamp).parent / inner.get("value")).resolve()))
        if element.tag == "shape":
            transform = element.find("transform")
            if transform is None:
                transform = ElementTree.SubElement(element, "transform", name="to_world")
            transform.extend(steps)
        root.append(element)
    for element in root.iter("string"):
        if element.get("name") == "filename" and not os.path.isabs(element.get("value")):
            element.set("value", str((pathlib.Path(room).parent / element.get("value")).resolve()))
    modernize(root)
    tree.write(out)
    return out


def crystal_room():
    return ROOT / "scenes/crystal_room.xml", ROOT / "build/release/lamps/crystal_lamp/crystal_lamp.xml"


# --- Contenders: each yields (samples, CPU seconds, picture). ---
def ours_runs(folder, name, scene, integrator, budget, *more):
    samples, spent = 1, 0
    while spent < budget:
        out = folder / f"{name.replace(' ', '_')}.exr"
        done = sconce("render", scene, "-o", out, "-i", integrator, "--size", "%dx%d" % SIZE, "--spp", samples, "--seed", samples, "--quiet", *more)
        spent = done["cpu_s"]
        yield samples, spent, out
        samples *= 2


def mitsuba_runs(folder, name, scene, integrator, budget):
    """In a process of its own, which prints a line for every picture."""
    command = [sys.executable, __file__, "--mitsuba", str(scene), integrator, str(budget), str(folder / f"{name.replace(' ', '_').replace(',', '')}.exr")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            samples, spent, out = line.split(maxsplit=2)
            yield int(samples), float(spent), pathlib.Path(out.strip())


def mitsuba_process(scene, integrator, budget, out):
    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    mi.logger().clear_appenders()
    loaded = mi.load_file(scene)
    depth = int(re.search(r'name="max_depth" value="(-?\d+)"', pathlib.Path(scene).read_text())[1])
    tracer = mi.load_dict({"type": integrator, "max_depth": depth, "rr_depth": 5})
    film = loaded.sensors()[0].film()
    if tuple(film.size()) != SIZE:
        sys.exit("the scene's film has another size")

    def cpu():
        usage = resource.getrusage(resource.RUSAGE_SELF)
        return usage.ru_utime + usage.ru_stime

    import numpy as np
    np.array(mi.render(loaded, integrator=tracer, spp=1, seed=0))  # compiles
    samples, spent = 1, 0.0
    while spent < float(budget):
        parts, begin = [], cpu()
        for first in range(0, samples, 64):  # memory grows with the samples of one call
            count = min(64, samples - first)
            parts.append((count, np.array(mi.render(loaded, integrator=tracer, spp=count, seed=samples * 1000 + first))))
        spent = cpu() - begin
        mi.Bitmap((sum(n * image for n, image in parts) / samples).astype(np.float32)).write(out)
        print(samples, spent, out, flush=True)
        samples *= 2


def luxcore_runs(folder, name, scene, definitions, budget):
    import mitsuba as mi
    import numpy as np
    mi.set_variant("scalar_rgb")
    for share in (1 / 8, 1 / 4, 1 / 2, 1):
        raw, out = folder / "luxcore.npy", folder / f"{name.replace(' ', '_')}.exr"
        answer = subprocess.run([sys.executable, ROOT / "bench/luxcore.py", "-", "--lux", json.dumps(
            [str(scene), definitions, *SIZE, budget * share, 1, str(raw)])], stdout=subprocess.PIPE, text=True)
        if answer.returncode:
            print("left out: LuxCore failed on this scene", file=sys.stderr)
            return
        found = json.loads(answer.stdout)
        mi.Bitmap(np.ascontiguousarray(np.load(raw))).write(str(out))
        yield round(found["spp"]), found["cpu_s"], out


# --- Measuring. ---
def error_of(picture, reference, mask):
    return sconce("compare", picture, reference, "--mask", mask)


def seconds_to(series, target, biased):
    """(CPU seconds, whether extrapolated), or None where the bias alone is more."""
    reached = [i for i, run in enumerate(series) if run[2] <= target]
    if reached and all(run[2] <= target for run in series[reached[0]:]):  # and stays there
        if reached[0] == 0:
            return series[0][1], True
        (_, t0, e0), (_, t1, e1) = series[reached[0] - 1:reached[0] + 1]
        share = math.log(e0 / target) / math.log(e0 / max(e1, target / 10))
        return math.exp(math.log(t0) + share * (math.log(t1) - math.log(t0))), False
    products = sorted(t * max(e, 0) for _, t, e in series[1:] or series)
    noise, bias = products[len(products) // 2], 0.0
    if biased and len(series) > 2:  # error = noise / time + bias^2, through the last run and the one of a quarter of its time
        (_, t0, e0), (_, t1, e1) = series[-3], series[-1]
        bias = max(0.0, (e1 * t1 - e0 * t0) / (t1 - t0))
        noise = max(e1 - bias, 0) * t1
    return (noise / (target - bias), True) if bias < target else None


def has_package(name):
    return subprocess.run([sys.executable, "-c", f"import {name}"], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL).returncode == 0


def measure(scene, options):
    folder = (options.out / scene).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    if scene == "flower" and not FLOWER.exists():
        print(f"left out: the flower lamp is not at {FLOWER}", file=sys.stderr)
        return None
    room, lamp = flower_room(folder)[:2] if scene == "flower" else crystal_room()
    baked = folder / "lamp.safetensors"
    if not baked.exists():
        sconce("bake", lamp, "-o", baked, "--quality", "standard")
    info = sconce("info", baked)
    radius, flux = info["radius"], info["flux"]
    sphere = info["center"], radius / 4, [f / (4 * math.pi ** 2 * (radius / 4) ** 2) for f in flux]
    with_sphere, mask = merged_room(room, lamp, folder / "sphere_room.xml", sphere), folder / "mask.exr"
    size = ("--size", "%dx%d" % SIZE)
    sconce("render", room, f"-Dlamp={baked}", "-o", folder / "mask_of.exr", "-i", "path", *size, "--spp", 1, "--mask", mask)
    references = {"real": folder / "reference.exr", "sphere": folder / "sphere_reference.exr"}
    if not references["real"].exists():
        sconce("render", room, f"-Dlamp={lamp}", "-o", references["real"], "-i", reference_integrator(scene), *size,
               "-s", options.reference, "--seed", 1000000)
    if not references["sphere"].exists():
        sconce("render", with_sphere, "-o", references["sphere"], "-i", "path", "--exact", *size, "-s", options.reference / 5, "--seed", 1000000)
    contenders = {
        "ours": ("real", ours_runs(folder, "ours", room, "path", BIAS_SHOWS * options.seconds, f"-Dlamp={baked}")),
        "ours bdpt": ("real", ours_runs(folder, "bdpt", room, "bdpt", options.seconds, f"-Dlamp={lamp}")),
        "ours particle": ("real", ours_runs(folder, "particle", room, "particle", options.seconds, f"-Dlamp={lamp}")),
        "sphere": ("sphere", ours_runs(folder, "sphere", with_sphere, "path", options.seconds)),
    }
    if has_package("mitsuba"):
        merged = merged_room(room, lamp, folder / "merged_room.xml")
        contenders["Mitsuba 3 ptracer"] = "real", mitsuba_runs(folder, "ptracer", merged, "ptracer", options.seconds)
        contenders["sphere, Mitsuba 3"] = "sphere", mitsuba_runs(folder, "mitsuba sphere", with_sphere, "path", options.seconds)
    if has_package("pyluxcore") and has_package("mitsuba"):
        source = FLOWER / "cbox_flower_lum.xml" if scene == "flower" else room
        contenders["LuxCore bidir"] = "real", luxcore_runs(folder, "luxcore", source, {"lamp": str(lamp)}, options.seconds)
    rows = {}
    for name, (kind, runs) in contenders.items():
        series = []
        for samples, cpu, picture in runs:
            error = error_of(picture, references[kind], mask)["rel_mse_corrected"]
            series.append((samples, cpu, error))
            print(f"{scene:8s} {name:20s} {samples:6d} samples {cpu:9.2f} CPU s  relMSE {error:.6f}", file=sys.stderr)
        if not series:
            continue
        rows[name] = {"series": series, "to": {str(t): seconds_to(series, t, name == "ours") for t in TARGETS}}
    return {"scene": scene, "rows": rows}


# --- Showing. ---
def markdown(results):
    lines = []
    for result in results:
        lines += [f"## {SCENES[result['scene']]}, {SIZE[0]}x{SIZE[1]}",
                  "| renderer | CPU s to relMSE " + " | to ".join(map(str, TARGETS)) + " | times ours |", "|---|---|---|---|"]
        ours = result["rows"]["ours"]["to"]
        for name, row in result["rows"].items():
            cells, times = [], []
            for target in map(str, TARGETS):
                found = row["to"][target]
                cells.append("its bias is more" if found is None else f"{found[0]:.3g}{'*' if found[1] else ''}")
                times.append("-" if found is None or ours[target] is None else f"{found[0] / ours[target][0]:.3g}")
            lines.append(f"| {name} | {cells[0]} | {cells[1]} | {times[0]}, {times[1]} |")
        lines.append("")
    return "\n".join(lines)


def chart(results):
    """Error against CPU seconds, both logarithmic, one line a renderer, one panel a scene."""
    width, height, left, top = 460, 340, 58, 34
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{len(results) * width}" height="{height + 30}" font-family="sans-serif" font-size="11">',
           f'<rect width="100%" height="100%" fill="#fff"/>']
    for panel, result in enumerate(results):
        told = {name: [(t, e) for _, t, e in row["series"] if e > LEAST_TOLD] for name, row in result["rows"].items()}
        points = [point for series in told.values() for point in series]
        x0, x1 = (f(math.log10(t) for t, _ in points) for f in (min, max))
        y0, y1 = (f(math.log10(e) for _, e in points) for f in (min, max))
        x0, x1, y0, y1 = math.floor(x0 * 2) / 2, math.ceil(x1 * 2) / 2, math.floor(y0 - 0.3), math.ceil(y1)
        X = lambda t: panel * width + left + (math.log10(t) - x0) / (x1 - x0) * (width - left - 130)
        Y = lambda e: top + (y1 - math.log10(e)) / (y1 - y0) * (height - top - 30)
        out.append(f'<text x="{panel * width + left}" y="18" font-size="13" font-weight="bold">{SCENES[result["scene"]]}</text>')
        for k in range(math.ceil(x0), math.floor(x1) + 1):
            out.append(f'<line x1="{X(10 ** k):.1f}" y1="{top}" x2="{X(10 ** k):.1f}" y2="{height - 30}" stroke="#e4e4e4"/>'
                       f'<text x="{X(10 ** k):.1f}" y="{height - 14}" text-anchor="middle">{10 ** k:g} s</text>')
        for k in range(y0, y1 + 1):
            out.append(f'<line x1="{X(10 ** x0):.1f}" y1="{Y(10 ** k):.1f}" x2="{X(10 ** x1):.1f}" y2="{Y(10 ** k):.1f}" stroke="#e4e4e4"/>'
                       f'<text x="{X(10 ** x0) - 6:.1f}" y="{Y(10 ** k) + 4:.1f}" text-anchor="end">{10.0 ** k:g}</text>')
        labels = []
        for name in result["rows"]:
            line = [(X(t), Y(e)) for t, e in told[name]]
            out.append(f'<polyline fill="none" stroke="{COLORS[name]}" stroke-width="{3 if name == "ours" else 1.8}" points="'
                       + " ".join(f"{x:.1f},{y:.1f}" for x, y in line) + '"/>')
            labels.append([line[-1][1], line[-1][0], name])
        labels.sort()
        for a, b in zip(labels, labels[1:]):
            b[0] = max(b[0], a[0] + 13)
        for y, x, name in labels:
            out.append(f'<text x="{x + 6:.1f}" y="{y + 4:.1f}" fill="{COLORS[name]}">{name}</text>')
        out.append(f'<text x="{panel * width + 12}" y="{top + (height - top) / 2}" transform="rotate(-90 {panel * width + 12} {top + (height - top) / 2})" '
                   f'text-anchor="middle">relMSE outside the lamp</text>'
                   f'<text x="{panel * width + left + 130}" y="{height + 6}" text-anchor="middle">CPU seconds</text>')
    return "\n".join(out + ["</svg>"]) + "\n"


def main():
    if len(sys.argv) == 6 and sys.argv[1] == "--mitsuba":
        mitsuba_process(*sys.argv[2:])
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", choices=tuple(SCENES), action="append")
    parser.add_argument("--seconds", type=float, default=60, help="CPU seconds of every renderer's longest run, at least")
    parser.add_argument("--reference", type=float, default=600, help="wall seconds of the reference; an earlier run's is kept")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/time_to_error")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    results = [r for r in (measure(scene, options) for scene in options.scene or SCENES) if r]
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "results.json").write_text(json.dumps(results, indent=1))
    (options.out / "chart.svg").write_text(chart(results))
    print(json.dumps(results) if options.json else markdown(results))


if __name__ == "__main__":
    main()
