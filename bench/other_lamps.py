#!/usr/bin/env python3
"""Lamps of other kinds than those of lamps/: nothing was tuned to them but what docs/experiments.md says. Each is written,
baked and measured; what a bake gets wrong shows here first.

    other_lamps.py PROGRAM [LAMP ...] [--quality draft|standard|high] [--keep FOLDER]

One Markdown row a lamp: seconds, megabytes, flux error, irradiance error at 1.2 and 4 radii (noise), mean error of the
transparency (of an opaque lamp's), relative variance of a light sample (of a uniform one's)."""
import argparse
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

GLASS = '<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>'
HOLLOW = '<bsdf type="dielectric"><float name="int_ior" value="1"/><float name="ext_ior" value="1.5"/></bsdf>'
BLACK = '<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>'


def matt(color):
    return f'<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="{color}"/></bsdf></bsdf>'


def metal(name, alpha):
    return (f'<bsdf type="twosided"><bsdf type="roughconductor"><string name="material" value="{name}"/>'
            f'<float name="alpha" value="{alpha}"/></bsdf></bsdf>')


def frosted(alpha, inside=1.5, outside=1):
    return (f'<bsdf type="roughdielectric"><float name="alpha" value="{alpha}"/><float name="int_ior" '
            f'value="{inside}"/><float name="ext_ior" value="{outside}"/></bsdf>')


def shines(radiance):
    return BLACK + f'<emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter>'


def point(name, p):
    return '<point name="%s" x="%.6g" y="%.6g" z="%.6g"/>' % (name, *p)


def sphere(center, radius, inside):
    return f'<shape type="sphere">{point("center", center)}<float name="radius" value="{radius}"/>{inside}</shape>'


def tube(p0, p1, radius, inside):
    return (f'<shape type="cylinder">{point("p0", p0)}{point("p1", p1)}<float name="radius" value="{radius}"/>'
            f'{inside}</shape>')


def placed(kind, steps, inside):
    return f'<shape type="{kind}"><transform name="to_world">{steps}</transform>{inside}</shape>'


def checkerboard(name, colors, scale):
    return (f'<texture name="{name}" type="checkerboard"><rgb name="color0" value="{colors[0]}"/><rgb name="color1" '
            f'value="{colors[1]}"/><transform name="to_uv"><scale x="{scale[0]}" y="{scale[1]}"/></transform></texture>')


def on_sphere(n):
    """Fibonacci's spiral."""
    for i in range(n):
        z, turn = 1 - 2 * (i + 0.5) / n, 2.39996 * i
        s = math.sqrt(1 - z * z)
        yield s * math.cos(turn), z, s * math.sin(turn)


def ring(n, radius, height):
    at = [(radius * math.cos(2 * math.pi * i / n), height(2 * math.pi * i / n), radius * math.sin(2 * math.pi * i / n))
          for i in range(n)]
    return zip(at, at[1:] + at[:1])


def neon():
    """A wavy ring of neon tubes round a ball of polished gold."""
    tubes = "".join(tube(a, b, 0.012, shines("20, 3, 8")) for a, b in ring(24, 1, lambda t: 0.1 * math.sin(3 * t)))
    return tubes + sphere((0, 0, 0), 0.15, metal("Au", 0.01))


def fluorescent():
    """Two metres of tube in frosted glass under a white fixture."""
    return (tube((-1, 0, 0), (1, 0, 0), 0.008, shines(60)) + tube((-1.01, 0, 0), (1.01, 0, 0), 0.02, frosted(0.2)) +
            placed("cube", '<scale x="1.02" y="0.01" z="0.03"/><translate y="0.04"/>', matt(0.8)))


def twelve_tubes():
    """Tubes of twelve colours, spread like the ribs of a basket."""
    turns = [2 * math.pi * i / 12 for i in range(12)]
    return "".join(tube((0.1 * math.cos(t), -0.5, 0.1 * math.sin(t)), (0.6 * math.cos(t), 0.5, 0.6 * math.sin(t)), 0.008,
                        shines(f"20, {5 + i}, {2 + i}")) for i, t in enumerate(turns))


def filaments():
    """Three glowing filaments in a bulb of clear glass with a gold cap."""
    wires = [((0.01, -0.02, 0), (0.012, 0.02, 0)), ((-0.01, -0.02, 0.004), (-0.012, 0.02, 0)),
             ((0, -0.02, -0.01), (0, 0.02, -0.012))]
    return (sphere((0, 0, 0), 0.045, GLASS) + sphere((0, 0, 0), 0.044, HOLLOW) +
            "".join(tube(a, b, 0.0007, shines("1000, 700, 300")) for a, b in wires) +
            tube((0, 0.04, 0), (0, 0.07, 0), 0.013, metal("Au", 0.1)))


def globe():
    """A bulb in a globe of frosted glass."""
    return (sphere((0, 0, 0), 0.2, frosted(0.3)) + sphere((0, 0, 0), 0.19, frosted(0.3, 1, 1.5)) +
            sphere((0, 0, 0), 0.03, shines("300, 250, 200")) + tube((0, 0.19, 0), (0, 0.24, 0), 0.06, metal("Au", 0.1)))


def grille():
    """Two bulbs behind perforated copper."""
    copper = f'<bsdf type="mask">{checkerboard("opacity", (1, 0), (24, 12))}{metal("Cu", 0.02)}</bsdf>'
    return (sphere((0, 0, 0), 0.3, copper) + sphere((0, 0.05, 0), 0.04, shines(200)) +
            sphere((0, -0.1, 0.05), 0.02, shines("50, 50, 400")))


def paper():
    """A bulb in a drum of paper, on a stand."""
    drum = ('<bsdf type="mixturebsdf"><string name="weights" value="0.45 0.45"/>' + matt("0.9, 0.85, 0.7") +
            '<bsdf type="difftrans"><rgb name="transmittance" value="0.9, 0.8, 0.6"/></bsdf></bsdf>')
    return (tube((0, -0.12, 0), (0, 0.12, 0), 0.18, drum) + sphere((0, 0, 0), 0.03, shines("100, 90, 80")) +
            tube((0, -0.3, 0), (0, -0.03, 0), 0.012, matt(0.3)))


def shade():
    """A bulb in clear glass within an opaque drum."""
    return (tube((0, -0.15, 0), (0, 0.15, 0), 0.2, matt("0.8, 0.7, 0.6")) + sphere((0, 0, 0), 0.03, shines("100, 80, 60")) +
            sphere((0, 0, 0), 0.036, GLASS))


def lens():
    """A spot: a disk behind a ball of glass in a metal tube."""
    disk = '<scale value="%g"/><rotate x="1" angle="90"/><translate y="%g"/>'
    return (tube((0, 0, 0), (0, 0.3, 0), 0.1, metal("Al", 0.1)) + placed("disk", disk % (0.02, 0.28), shines(500)) +
            placed("disk", disk % (0.1, 0.3), matt(0.5)) + sphere((0, 0.1, 0), 0.08, GLASS))


def panel():
    """A chequered panel behind a slab of frosted glass."""
    glow = (BLACK + '<emitter type="area">' + checkerboard("radiance", ("40, 30, 20", "1, 2, 8"), (8, 2)) +
            "</emitter>")
    return (placed("rectangle", '<scale x="0.6" y="0.15"/>', glow) +
            placed("cube", '<scale x="0.62" y="0.17" z="0.01"/><translate z="0.05"/>', frosted(0.3)))


def crystals_far_away():
    """Eighty cubes of glass round a frosted bulb, in millimetres, far from the origin."""
    draw, center = random.Random(3), (500, -300, 1200)
    text = (sphere(center, 8, shines("3000, 2500, 2000")) + sphere(center, 30, frosted(0.1)) +
            sphere(center, 28, frosted(0.1, 1, 1.5)))
    for x, y, z in on_sphere(80):
        r, axis = draw.uniform(70, 150), [draw.uniform(0.1, 1) for _ in range(3)]
        text += placed("cube", '<scale value="%g"/><rotate x="%g" y="%g" z="%g" angle="%g"/><translate x="%g" y="%g" z="%g"/>' %
                       (draw.uniform(4, 12), *axis, draw.uniform(0, 360), center[0] + r * x, center[1] + r * y,
                        center[2] + r * z), GLASS)
    return text


def bright_and_dim():
    """A hot point and a cold ball ten thousand times dimmer, and a mirror ball."""
    return (sphere((-0.2, 0, 0), 0.01, shines("1e5, 1e3, 10")) + sphere((0.2, 0, 0), 0.1, shines("0.1, 0.5, 5")) +
            sphere((-0.2, 0, 0), 0.05, GLASS) +
            sphere((0, 0.2, 0), 0.12, '<bsdf type="conductor"><string name="material" value="none"/></bsdf>'))


LAMPS = [neon, fluorescent, twelve_tubes, filaments, globe, grille, paper, shade, lens, panel, crystals_far_away,
         bright_and_dim]


def row(name, e):
    at = {round(i["radii"], 1): i for i in e["irradiance"]}
    irradiance = ", ".join("%.1f" % (100 * at[r]["error"]) for r in (1.2, 4.0))
    return "| %s | %.0f s | %.2f | %.2f %% | %s %% (%.1f) | %.3f (%.2f) | %.1f (%.0f) |" % (
        name.replace("_", " "), e["seconds"], e["bytes"] / 1e6, 100 * max(map(abs, e["flux_error"])), irradiance,
        100 * at[1.2]["reference_noise"], e["transparency_error"], e["transparency_error_black"], e["sample_variance"],
        e["sample_variance_uniform"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("lamps", nargs="*", metavar="LAMP", help=", ".join(f.__name__ for f in LAMPS))
    parser.add_argument("--quality", default="draft")
    parser.add_argument("--keep", metavar="FOLDER", help="of the lamps and their files")
    options = parser.parse_args()
    unknown = set(options.lamps) - {f.__name__ for f in LAMPS}
    if unknown:
        sys.exit("no lamp is called " + ", ".join(sorted(unknown)))
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(options.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        print("| lamp | bake | MB | flux, at most | irradiance at 1.2, 4 radii (noise) | transparency (opaque) | "
              "variance (uniform) |\n|---|---|---|---|---|---|---|")
        for lamp in LAMPS:
            if options.lamps and lamp.__name__ not in options.lamps:
                continue
            source = folder / (lamp.__name__ + ".xml")
            source.write_text(f'<scene version="3.0.0">\n<!-- {lamp.__doc__} -->\n{lamp()}\n</scene>\n')
            done = subprocess.run([options.program, "bake", source, "-o", source.with_suffix(".safetensors"), "--quality",
                                   options.quality, "--json", "--quiet"], stdout=subprocess.PIPE, check=True)
            print(row(lamp.__name__, json.loads(done.stdout)), flush=True)


if __name__ == "__main__":
    main()
