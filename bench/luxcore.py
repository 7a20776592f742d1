#!/usr/bin/env python3
"""Our bidirectional path tracer against LuxCore's (pyluxcore, BIDIRCPU) on the same scene in the same CPU time.

    bench/luxcore.py PROGRAM [--scene flower|demo] [--seconds S] [--runs N] [--size WxH] [--lamp demo_lamp.xml] [--json]

Every run of either program gets S seconds of CPU time on one thread, with a seed of its own. The error of a run is the
relMSE, mean of (x - m)^2 / (m^2 + 1e-3) over the pixels and colours outside the lamp, against the mean m of the same
program's other runs, times (N-1)/N for the noise of m: the variance alone, so differences of convention do not count.
Both are scaled to the same mean of 1; medians of blocks are compared to see that the pictures are the same. What the programs
took more or less than S is put right as noise falls with 1/time. Median over the runs. "Trimmed" leaves out the hundredth
of the pixels with the largest errors: in the demo room few paths carry the lamp's caustics into mirror and glass ball.

LuxCore has no rough plastic like ours, so both programs get the demo room with diffuse surfaces instead. Differences that
stay: LuxCore has no analytic spheres and cylinders (they are tessellated, with smooth normals), its microfacets are
Schlick's (the same D as GGX, another G), and it bounds the light's and the camera's walk where we bound the whole path.
LuxCore's own Russian roulette settings are kept.
Needs the packages of tests/reference/requirements.txt and pyluxcore (2.11.2 was measured)."""
import argparse
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
FLOWER = ROOT.parent / "shared/scenes/zhu2021/flower/cbox_flower_lum.xml"


# --- Mitsuba's XML, as much of it as the two scenes use, into LuxCore's properties and meshes. ---
def numbers(text):
    return [float(v) for v in re.split(r"[,\s]+", text.strip())]


def plain(name):  # toWorld -> to_world
    return re.sub(r"([A-Z])", lambda m: "_" + m[1].lower(), name or "")


def values(element):
    """The plain parameters of an element by name."""
    found = {}
    for child in element:
        name = plain(child.get("name"))
        if child.tag in ("float", "integer"):
            found[name] = float(child.get("value"))
        elif child.tag in ("string", "boolean"):
            found[name] = child.get("value")
        elif child.tag == "rgb":
            v = numbers(child.get("value"))
            found[name] = v * 3 if len(v) == 1 else v
        elif child.tag == "spectrum":
            found[name] = spectrum_rgb(child.get("value"))
        elif child.tag in ("point", "vector"):
            found[name] = (numbers(child.get("value")) if child.get("value") else
                           [float(child.get(c, 0)) for c in "xyz"])
        elif child.tag == "texture":
            t = values(child)
            uv = transform(child.find("transform"))
            found[name] = ("checkerboard", t["color0"], t["color1"], float(uv[0, 0]), float(uv[1, 1]))
    return found


def spectrum_rgb(text):
    """Reflectance at wavelengths to linear sRGB under D65, with the CIE curves as sums of Gaussians (Wyman et al. 2013)."""
    if ":" not in text:
        v = numbers(text)
        return v * 3 if len(v) == 1 else v
    pairs = np.array([[float(x) for x in p.split(":")] for p in text.split(",")])
    w = np.arange(400.0, 701.0, 5)
    r = np.interp(w, pairs[:, 0], pairs[:, 1])

    def lobe(mean, left, right):
        return np.exp(-0.5 * ((w - mean) / np.where(w < mean, left, right)) ** 2)

    xyz = np.array([1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
                    0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
                    1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8)])
    white = np.array([0.95047, 1, 1.08883]) / xyz.sum(1)  # an equal-energy light moved to D65's white
    matrix = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
    return list(np.clip(matrix @ (xyz @ r * white), 0, 1))


def transform(element):
    m = np.eye(4)
    for step in element if element is not None else ():
        one = np.eye(4)
        if step.tag == "translate":
            one[:3, 3] = [float(step.get(c, 0)) for c in "xyz"]
        elif step.tag == "scale":
            value = step.get("value")
            one[:3, :3] = np.diag([float(value)] * 3 if value else [float(step.get(c, 1)) for c in "xyz"])
        elif step.tag == "rotate":
            axis = np.array([float(step.get(c, 0)) for c in "xyz"])
            axis /= np.linalg.norm(axis)
            a = np.radians(float(step.get("angle")))
            k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
            one[:3, :3] = np.eye(3) + np.sin(a) * k + (1 - np.cos(a)) * k @ k
        else:
            sys.exit(f"transform <{step.tag}> is not known here")
        m = one @ m
    return m


def grid(rows, columns, point):
    """A surface over [0,1]^2 with normals from `point`, which gives position and normal."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    p, n = point(u.ravel(), v.ravel())
    faces = []
    for i in range(rows):
        for j in range(columns):
            a = i * (columns + 1) + j
            b, c, d = a + 1, a + columns + 2, a + columns + 1
            faces += [(a, b, c), (a, c, d)]
    faces = np.array(faces)
    a, b, c = (p[faces[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    faces = faces[np.linalg.norm(area, axis=1) > 1e-12]
    a, b, c = (p[faces[:, k]] for k in range(3))
    inward = (np.cross(b - a, c - a) * n[faces[:, 1]]).sum(1) < 0
    faces[inward] = faces[inward][:, ::-1]
    return p, n, None, faces


def sphere(center, radius, rows):
    def point(u, v):
        n = np.stack([np.sin(np.pi * v) * np.cos(2 * np.pi * u), np.cos(np.pi * v), np.sin(np.pi * v) * np.sin(2 * np.pi * u)], 1)
        return center + radius * n, n
    return grid(rows, 2 * rows, point)


def cylinder(p0, p1, radius):
    along = p1 - p0
    side = np.cross(along, [1.0, 0.3, 0.2])
    side /= np.linalg.norm(side)
    other = np.cross(along / np.linalg.norm(along), side)

    def point(u, v):
        n = np.cos(2 * np.pi * u)[:, None] * side + np.sin(2 * np.pi * u)[:, None] * other
        return p0 + v[:, None] * along + radius * n, n
    return grid(1, 32, point)


def rectangle():
    p = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    return p, np.tile([0.0, 0, 1], (4, 1)), (p[:, :2] + 1) / 2, np.array([[0, 1, 2], [0, 2, 3]])


def cube():
    parts = []
    p, n, uv, f = rectangle()
    for axis in range(3):
        for sign in (1, -1):
            r = np.zeros((3, 3))
            r[axis, 2], r[(axis + 1) % 3, 0], r[(axis + 2) % 3, 1] = sign, sign, 1
            parts.append(((p + [0, 0, 1]) @ r.T, n @ r.T, uv, f))
    return (np.concatenate([q[0] for q in parts]), np.concatenate([q[1] for q in parts]),
            np.concatenate([q[2] for q in parts]), np.concatenate([q[3] + 4 * i for i, q in enumerate(parts)]))


def obj(path, face_normals):
    v, vn, vt, corner, faces = [], [], [], {}, []
    for line in open(path):
        word = line.split()
        if not word:
            continue
        if word[0] in ("v", "vn", "vt"):
            {"v": v, "vn": vn, "vt": vt}[word[0]].append([float(x) for x in word[1:4]])
        elif word[0] == "f":
            ids = []
            for c in word[1:]:
                key = tuple(int(i) if i else 0 for i in (c + "//").split("/")[:3])
                ids.append(corner.setdefault(key, len(corner)))
            faces += [(ids[0], ids[i], ids[i + 1]) for i in range(1, len(ids) - 1)]
    at = [[(k[i] - 1 if k[i] > 0 else k[i]) for k in corner] for i in range(3)]
    p = np.array(v)[at[0]]
    n = np.array(vn)[at[2]] if vn and not face_normals else None
    return p, n, np.array([x[:2] for x in vt])[at[1]] if vt else None, np.array(faces)


class Converter:
    def __init__(self, definitions):
        self.definitions, self.properties, self.meshes, self.materials, self.camera = definitions, [], [], {}, None
        self.depth = 32

    def put(self, key, *value):
        self.properties.append(f"scene.{key} = " + " ".join(f'"{v}"' if isinstance(v, str) else f"{v:.9g}" for v in value))

    def color(self, key, value):
        if isinstance(value, tuple):
            name = key.replace(".", "_")
            _, c0, c1, x, y = value
            self.put(f"textures.{name}.type", "checkerboard2d")
            self.put(f"textures.{name}.texture1", *c0)
            self.put(f"textures.{name}.texture2", *c1)
            # Mitsuba has two by two fields to a unit of uv, LuxCore one by one
            self.put(f"textures.{name}.mapping.type", "uvmapping2d")
            self.put(f"textures.{name}.mapping.uvscale", 2 * x, -2 * y)
            self.put(key, name)
        else:
            self.put(key, *value)

    def bsdf(self, element, name):
        kind, v = element.get("type"), values(element)
        nested = element.find("bsdf")
        key = f"materials.{name}"
        if kind == "twosided":
            if nested is not None:
                return self.bsdf(nested, name)
            self.materials[element.get("id")] = self.materials[element.find("ref").get("id")]
            return self.materials[element.get("id")]
        if kind == "diffuse":
            self.put(f"{key}.type", "matte")
            self.color(f"{key}.kd", v.get("reflectance", [0.5] * 3))
        elif kind in ("dielectric", "roughdielectric"):
            rough = kind == "roughdielectric"
            self.put(f"{key}.type", "roughglass" if rough else "glass")
            self.put(f"{key}.kr", *v.get("specular_reflectance", [1] * 3))
            self.put(f"{key}.kt", *v.get("specular_transmittance", [1] * 3))
            self.put(f"{key}.interiorior", v.get("int_ior", 1.5046))
            self.put(f"{key}.exteriorior", v.get("ext_ior", 1.000277))
            if rough:
                self.put(f"{key}.uroughness", v["alpha"])
                self.put(f"{key}.vroughness", v["alpha"])
        elif kind == "conductor":
            self.put(f"{key}.type", "mirror")
            self.put(f"{key}.kr", 0.97, 0.96, 0.95)  # silver
        elif kind == "blendbsdf":
            parts = [self.bsdf(part, f"{name}_{i}") for i, part in enumerate(element.findall("bsdf"))]
            self.put(f"{key}.type", "mix")
            self.put(f"{key}.material1", parts[0])
            self.put(f"{key}.material2", parts[1])
            self.put(f"{key}.amount", v["weight"])
        elif kind == "roughconductor":
            copper = [0.2004, 0.9240, 1.1022], [3.9129, 2.4528, 2.1421]
            if v.get("material") == "none":
                copper = [0.0] * 3, [1.0] * 3
            self.put(f"{key}.type", "metal2")
            for part, default in zip(("eta", "k"), copper):
                self.put(f"textures.{name}_{part}.type", "constfloat3")
                self.put(f"textures.{name}_{part}.value", *v.get(part, default))
                self.put(f"{key}.{'n' if part == 'eta' else 'k'}", f"{name}_{part}")
            self.put(f"{key}.uroughness", v.get("alpha", 0.1))
            self.put(f"{key}.vroughness", v.get("alpha", 0.1))
        else:
            sys.exit(f"bsdf {kind} is not known here")
        for holder in (element.get("id"), name):
            self.materials[holder] = name
        return name

    def shape(self, element, folder, outer):
        kind, v = element.get("type"), values(element)
        to_world = outer @ transform(element.find("transform"))
        name = f"shape{len(self.meshes)}"
        if kind == "luminaire":
            lamp = pathlib.Path(self.definitions["lamp"]).resolve()
            return self.read(lamp, to_world, lamp=True)
        emitter = element.find("emitter")
        if kind == "obj":
            mesh = obj(folder / v["filename"], v.get("face_normals") == "true")
        elif kind == "sphere":
            mesh = sphere(np.array(v["center"]), v["radius"], 8 if emitter is not None else 48)
        elif kind == "cylinder":
            mesh = cylinder(np.array(v["p0"]), np.array(v["p1"]), v["radius"])
        elif kind in ("rectangle", "cube"):
            mesh = rectangle() if kind == "rectangle" else cube()
        else:
            sys.exit(f"shape {kind} is not known here")
        if emitter is not None:
            self.put(f"materials.{name}.type", "matte")
            self.put(f"materials.{name}.kd", 0, 0, 0)
            self.put(f"materials.{name}.emission", *values(emitter)["radiance"])
            material = name
        elif element.find("ref") is not None:
            material = self.materials[element.find("ref").get("id")]
        else:
            material = self.bsdf(element.find("bsdf"), name)
        p, n, uv, faces = mesh
        p = p @ to_world[:3, :3].T + to_world[:3, 3]
        if n is not None:
            n = n @ np.linalg.inv(to_world[:3, :3])
            n /= np.linalg.norm(n, axis=1, keepdims=True)
        if np.linalg.det(to_world[:3, :3]) < 0:
            faces = faces[:, ::-1]
        self.meshes.append((name, p, n, uv, faces))
        self.put(f"objects.{name}.shape", name)
        self.put(f"objects.{name}.material", material)
        return None

    def read(self, path, outer=np.eye(4), lamp=False):
        text = path.read_text()
        for name in re.findall(r'<default name="(\w+)" value="[^"]*"/>', text):
            text = text.replace("$" + name, self.definitions.get(name, "1"))
        root = ElementTree.fromstring(text.encode())
        prefix = "lamp_" if lamp else ""
        for i, element in enumerate(root):
            if element.tag == "bsdf":
                inner = element.find("bsdf")  # an id may be on the inner one
                ids = [e.get("id") for e in (element, inner) if e is not None and e.get("id")]
                made = self.bsdf(element, prefix + (ids[0] if ids else f"bsdf{i}"))
                self.materials.update({id_: made for id_ in ids})
        for element in root:
            if element.tag == "shape":
                self.shape(element, path.parent, outer)
        if not lamp:
            sensor = root.find("sensor")
            look = sensor.find("transform").find("lookat")
            self.camera = values(sensor)["fov"], *(numbers(look.get(k)) for k in ("origin", "target", "up"))
            self.depth = int(values(root.find("integrator")).get(plain("maxDepth"), -1))
            self.depth = 32 if self.depth < 0 else self.depth


def lux_run(path, definitions, width, height, seconds, seed, out):
    """One rendering, in a process of its own: writes the image and prints the CPU seconds it took."""
    with open(os.devnull, "w") as sink:
        kept = os.dup(1)
        os.dup2(sink.fileno(), 1)
        import pyluxcore
        pyluxcore.Init(lambda _: None)
    converter = Converter(definitions)
    converter.read(path)
    fov, origin, target, up = converter.camera
    converter.put("camera.type", "perspective")
    converter.put("camera.lookat.orig", *origin)
    converter.put("camera.lookat.target", *target)
    converter.put("camera.up", *up)
    converter.put("camera.fieldofview", fov)
    converter.put("camera.screenwindow", -1, 1, -height / width, height / width)
    converter.put("camera.autofocus.enable", 0)
    scene = pyluxcore.Scene()
    for name, p, n, uv, faces in converter.meshes:
        scene.DefineMesh(name, *([tuple(map(float if a is not faces else int, row)) for row in a] if a is not None else None
                                 for a in (p, faces, n, uv)), None, None)
    properties = pyluxcore.Properties()
    properties.SetFromString("\n".join(converter.properties))
    scene.Parse(properties)
    settings = pyluxcore.Properties()
    settings.SetFromString(f"""
        renderengine.type = BIDIRCPU
        renderengine.seed = {seed}
        native.threads.count = 1
        sampler.type = SOBOL
        sampler.sobol.adaptive.strength = 0
        path.maxdepth = {converter.depth}
        light.maxdepth = {converter.depth}
        path.clamping.variance.maxvalue = 0
        scene.epsilon.min = 1e-6
        film.width = {width}
        film.height = {height}
        film.filter.type = BOX
        film.filter.width = 0.5
        film.imagepipelines.0.0.type = NOP
        film.outputs.0.type = RGB_IMAGEPIPELINE
        film.outputs.0.index = 0
        film.outputs.0.filename = x.exr
        film.noiseestimation.warmup = 1000000
        """)
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(settings, scene))
    usage = resource.getrusage(resource.RUSAGE_SELF)
    begin = usage.ru_utime + usage.ru_stime
    session.Start()
    while True:
        time.sleep(0.1)
        usage = resource.getrusage(resource.RUSAGE_SELF)
        spent = usage.ru_utime + usage.ru_stime - begin
        if spent >= seconds:
            break
    session.Pause()
    usage = resource.getrusage(resource.RUSAGE_SELF)
    spent = usage.ru_utime + usage.ru_stime - begin
    session.UpdateStats()
    samples = session.GetStats().Get("stats.renderengine.pass").GetFloat()
    image = np.zeros((height, width, 3), np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB_IMAGEPIPELINE, image, 0)
    session.Stop()
    np.save(out, image[::-1])
    os.write(kept, json.dumps({"cpu_s": spent, "spp": samples}).encode())
    os._exit(0)


# --- Measurement. ---
def exr_rgb(path):
    import mitsuba as mi
    mi.set_variant("scalar_rgb")
    bitmap = mi.Bitmap(str(path))
    names = [field.name for field in bitmap.struct_()]
    return np.array(bitmap)[:, :, [names.index(c) for c in "RGB"]].astype(float)


def ours_run(program, path, definitions, width, height, spp, seed, out, depth):
    command = [program, "render", str(path), "-o", out, "--integrator", "bdpt", "--size", f"{width}x{height}", "--spp", str(spp),
               "--seed", str(seed), "--threads", "1", "--quiet", "--max-depth", str(depth),
               *(f"-D{k}={v}" for k, v in definitions.items())]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    if subprocess.run(command, stdout=subprocess.DEVNULL).returncode:
        sys.exit("failed: " + " ".join(map(str, command)))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return exr_rgb(out), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def relative_errors(images, mask):
    """The relMSE of every image against the mean of the others, freed of that mean's noise: plain and trimmed."""
    images = [i[mask] for i in images]
    scale = 1 / np.mean(images)
    found = []
    for i, image in enumerate(images):
        others = np.mean([images[j] for j in range(len(images)) if j != i], 0) * scale
        share = (len(images) - 1) / len(images)
        errors = np.sort(np.mean((image * scale - others) ** 2 / (others ** 2 + 1e-3), -1))
        found.append((share * errors.mean(), share * errors[:-len(errors) // 100].mean()))
    return np.array(found)


def diffuse_room(out):
    """The demo room with its rough plastics as diffuse surfaces of the same colour."""
    tree = ElementTree.parse(ROOT / "scenes/demo_room.xml")
    for bsdf in tree.iter("bsdf"):
        if bsdf.get("type") == "roughplastic":
            bsdf.set("type", "diffuse")
            for child in list(bsdf):
                if child.get("name") == "alpha":
                    bsdf.remove(child)
                elif child.get("name") == "diffuse_reflectance":
                    child.set("name", "reflectance")
    tree.write(out)
    return out


def outside_lamp(name, width, height):
    """All pixels but those of the lamp's bounding sphere: centre (from the camera, in its axes) and radius."""
    y, x = np.mgrid[0.5:height, 0.5:width]
    if name == "flower":
        center, radius, fov = np.array([0, 0, 25.0]), 2.3, 70
    else:
        eye, target, lamp = np.array([-1.5, 1.45, 2.35]), np.array([0.2, 1.3, -0.6]), np.array([0.2, 2.2, -0.4])
        z = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(z, [0, 1, 0])
        right /= np.linalg.norm(right)
        center, radius, fov = np.array([right, np.cross(right, z), z]) @ (lamp - eye), 0.52, 62
    t = np.tan(np.radians(fov / 2))
    d = np.stack([(2 * x / width - 1) * t, (1 - 2 * y / height) * t * height / width, np.ones_like(x)], -1)
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    distance = np.linalg.norm(center)
    return d @ (center / distance) < np.sqrt(1 - (radius / distance) ** 2)


def compare(options, name, folder):
    path, definitions = (FLOWER, {}) if name == "flower" else (
        diffuse_room(pathlib.Path(folder) / "room.xml"), {"lamp": str(options.lamp.resolve())})
    width, height = map(int, options.size.split("x"))
    mask = outside_lamp(name, width, height)
    depth = Converter(definitions)
    depth.read(path)
    depth = depth.depth
    _, once = ours_run(options.program, path, definitions, width, height, 4, 99, f"{folder}/x.exr", depth)
    _, twice = ours_run(options.program, path, definitions, width, height, 20, 98, f"{folder}/x.exr", depth)
    per_spp = (twice - once) / 16
    spp = max(1, round(options.seconds / per_spp))
    ours, theirs = [], []
    for seed in range(1, options.runs + 1):  # in turn, so that a busy machine disturbs both alike
        image, spent = ours_run(options.program, path, definitions, width, height, spp, seed, f"{folder}/x.exr", depth)
        ours.append((image, spent))
        answer = subprocess.run([sys.executable, __file__, "-", "--lux", json.dumps([str(path), definitions, width, height,
                                 options.seconds, seed, f"{folder}/lux.npy"])], stdout=subprocess.PIPE, text=True)
        if answer.returncode:
            sys.exit("LuxCore failed")
        theirs.append((np.load(f"{folder}/lux.npy").astype(float), json.loads(answer.stdout)))
    if options.keep:
        np.savez(f"{options.keep}_{name}.npz", ours=np.mean([i for i, _ in ours], 0), theirs=np.mean([i for i, _ in theirs], 0))
    cpu_ours, cpu_theirs = [c for _, c in ours], [a["cpu_s"] for _, a in theirs]
    e_ours, e_theirs = (np.median(relative_errors([i for i, _ in images], mask) * np.array(cpu)[:, None], 0) / options.seconds
                        for images, cpu in ((ours, cpu_ours), (theirs, cpu_theirs)))
    a, b = (np.mean([i for i, _ in x], 0) for x in (ours, theirs))
    block = 16  # the same picture: medians of blocks, which fireflies do not move
    h, w = height // block * block, width // block * block

    def blocks(image):
        return np.median(image[:h, :w].reshape(h // block, block, w // block, block, 3), (1, 3))
    return {"scene": name, "size": options.size, "cpu_seconds": options.seconds, "runs": options.runs, "spp_ours": spp,
            "spp_luxcore": float(np.median([a["spp"] for _, a in theirs])),
            "mpaths_per_cpu_s_ours": width * height / per_spp * 1e-6,
            "cpu_ours": float(np.median(cpu_ours)), "cpu_luxcore": float(np.median(cpu_theirs)),
            "median_ratio": float(np.median(blocks(a)) / np.median(blocks(b))),
            "block_correlation": float(np.corrcoef(blocks(a).ravel(), blocks(b).ravel())[0, 1]),
            "relmse_ours": e_ours[0], "relmse_luxcore": e_theirs[0], "luxcore_over_ours": e_theirs[0] / e_ours[0],
            "trimmed_ours": e_ours[1], "trimmed_luxcore": e_theirs[1], "luxcore_over_ours_trimmed": e_theirs[1] / e_ours[1]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--scene", choices=("flower", "demo"), action="append")
    parser.add_argument("--seconds", type=float, default=20, help="CPU seconds of a run")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--lamp", type=pathlib.Path, default=ROOT / "out/demo/demo_lamp.xml", help="the demo lamp's XML")
    parser.add_argument("--keep", help="prefix of files for the mean images (NumPy)")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--lux", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.lux:
        path, *rest = json.loads(options.lux)
        lux_run(pathlib.Path(path), *rest)
    results = []
    for name in options.scene or ("flower", "demo"):
        if not (FLOWER if name == "flower" else options.lamp).exists():
            print(f"skipped: {name}, its files are not here", file=sys.stderr)
            continue
        with tempfile.TemporaryDirectory() as folder:
            results.append(compare(options, name, folder))
    if options.json:
        print(json.dumps(results, indent=1))
    else:
        print("scene   CPU s    spp ours/LuxCore   brightness ratio, block correlation   relMSE ours/LuxCore: ratio   trimmed")
        for r in results:
            print(f"{r['scene']:7s} {r['cpu_seconds']:5g} {r['spp_ours']:6d} / {r['spp_luxcore']:<6g} {r['median_ratio']:14.3f}, "
                  f"{r['block_correlation']:.4f} {r['relmse_ours']:18.4g} / {r['relmse_luxcore']:<9.4g} {r['luxcore_over_ours']:6.2f} "
                  f"{r['trimmed_ours']:8.4g} / {r['trimmed_luxcore']:.4g} {r['luxcore_over_ours_trimmed']:6.2f}")


if __name__ == "__main__":
    main()
