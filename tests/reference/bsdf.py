#!/usr/bin/env python3
"""Records what Mitsuba 3 says of BSDFs, for tests/unit/scene/test_bsdf_reference.c.

    python3 bsdf.py > bsdf_values.txt      (needs the package mitsuba; 3.9.1 was used)

Lines of the output:
    bsdf XML                                             what follows is of this BSDF (both programs read the same text)
    smooth WI[3] WO[3] F_COS[3] PDF                      eval and pdf (nan: not to be compared), tracing radiance
    delta WI[3] WO[3] THROUGHPUT[3]                      sample: weight times probability
All numbers are dimensionless or 1/sr; directions are local and point away from the surface.
"""
import math
import mitsuba as mi

mi.set_variant("scalar_rgb")

ROUGH = [
    '<string name="distribution" value="{d}"/><float name="alpha" value="{a}"/>'.format(d=d, a=a)
    for d, a in [("ggx", 0.5), ("ggx", 0.05), ("beckmann", 0.3), ("beckmann", 0.1)]
]
ANISOTROPIC = '<string name="distribution" value="ggx"/><float name="alpha_u" value="0.1"/><float name="alpha_v" value="0.4"/>'
TINT = '<rgb name="specular_reflectance" value="1, 0.9, 0.8"/>'
COLOUR = '<rgb name="diffuse_reflectance" value="0.1, 0.5, 0.8"/>'
GLASS = TINT + '<rgb name="specular_transmittance" value="0.7, 0.9, 1"/>'
WATER = '<string name="int_ior" value="water"/>'
MATERIALS = "none a-C Ag Al Au Be Cr Cu Cu2O CuO Hg HgTe Ir K Li Mo Na_palik Nb Ni_palik Rh Se-e Ta Te-e TiC TiN VC V_palik VN W"

CASES = [("diffuse", '<rgb name="reflectance" value="0.2, 0.4, 0.6"/>')]
CASES += [("conductor", f'<string name="material" value="{m}"/>') for m in MATERIALS.split()]
CASES += [("roughconductor", r + '<string name="material" value="Cu"/>' + TINT) for r in ROUGH + [ANISOTROPIC]]
CASES += [("roughdielectric", r + GLASS) for r in ROUGH]
CASES += [("roughdielectric", ROUGH[0] + WATER), ("roughdielectric", ROUGH[1] + '<float name="int_ior" value="2.4"/>')]
CASES += [("dielectric", ""), ("dielectric", GLASS), ("dielectric", '<string name="int_ior" value="diamond"/>')]
CASES += [("thindielectric", ""), ("thindielectric", GLASS)]
CASES += [("plastic", COLOUR), ("plastic", COLOUR + TINT + '<boolean name="nonlinear" value="true"/>')]
CASES += [("roughplastic", r + COLOUR) for r in (ROUGH[0], ROUGH[1], ROUGH[2])]
CASES += [("roughplastic", ROUGH[3] + COLOUR + TINT + '<boolean name="nonlinear" value="true"/>')]
PAINT = '<rgb name="base_color" value="0.6, 0.3, 0.1"/>'


def principled(**numbers):
    return ("principled", PAINT + "".join(f'<float name="{n}" value="{v}"/>' for n, v in numbers.items()))


CASES += [("principled", ""), principled(roughness=0.2, specular=0.9), principled(roughness=0.3, metallic=1)]
CASES += [principled(roughness=0.4, metallic=0.6, anisotropic=0.8), principled(roughness=0.4, spec_tint=0.7, specular=0.2)]
CASES += [principled(sheen=0.8, sheen_tint=0.4), principled(sheen=1, metallic=0.3, flatness=0.6), principled(flatness=1, roughness=0.9)]
CASES += [principled(clearcoat=1, clearcoat_gloss=0.2), principled(clearcoat=0.5, clearcoat_gloss=0.9, roughness=0.8, eta=1.9)]
CASES += [principled(spec_trans=1, roughness=0.3), principled(spec_trans=0.6, roughness=0.5, metallic=0.3, eta=1.33, clearcoat=0.7)]
CASES += [principled(spec_trans=0.8, roughness=0.25, anisotropic=0.5, spec_tint=0.5, sheen=0.5, eta=2.2)]


def direction(theta, phi):
    return [math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)]


def around(theta, phi):
    """Directions near the mirror direction, near the straight continuation, and elsewhere."""
    for offset in (0.0, 0.03, -0.1, 0.35):
        yield direction(theta + offset, phi + math.pi + 0.5 * offset)
        inner = math.asin(min(1.0, math.sin(theta) / 1.5)) + offset
        yield direction(math.pi - inner if theta < math.pi / 2 else inner, phi + math.pi - 0.5 * offset)
    yield direction(0.4, 2.0)
    yield direction(1.2, 4.0)
    yield direction(math.pi - 0.8, 1.0)


def numbers(*groups):
    return " ".join("%.9g" % v for group in groups for v in group)


def record(kind, parameters):
    xml = f'<bsdf type="{kind}">{parameters}</bsdf>'
    bsdf = mi.load_string(xml.replace("<bsdf ", '<bsdf version="3.0.0" ', 1))
    context = mi.BSDFContext()
    print("bsdf " + xml)
    sided = "dielectric" in kind or "spec_trans" in parameters
    for theta, phi in [(0.1, 0.3), (0.7, 2.5), (1.3, 5.0)] + ([(math.pi - 0.5, 1.0), (math.pi - 0.9, 4.0)] if sided else []):
        si = mi.SurfaceInteraction3f()
        si.wi = direction(theta, phi)
        if mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth):
            for wo in around(theta, phi):
                value, pdf = bsdf.eval_pdf(context, si, wo)
                if kind == "principled":
                    pdf = math.nan  # each samples it in its own way
                print("smooth " + numbers(si.wi, wo, value, [pdf]))
        if mi.has_flag(bsdf.flags(), mi.BSDFFlags.Delta):
            for u in (0.0, 0.9999):
                sample, weight = bsdf.sample(context, si, u, [0.3, 0.6])
                if mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta) and sample.pdf > 0:
                    print("delta " + numbers(si.wi, sample.wo, [v * sample.pdf for v in weight]))
                elif mi.has_flag(sample.sampled_type, mi.BSDFFlags.Null):
                    print("delta " + numbers(si.wi, sample.wo, [v * sample.pdf for v in weight]))


for case in CASES:
    record(*case)
