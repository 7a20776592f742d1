#!/usr/bin/env python3
"""Queries of the published networks, ours against onnxruntime: the same file's weights, one thread each, in turn within one run.
usage: bench/paper_inference.py LAMP.safetensors [--runs N]      (a lamp baked with --preset paper; or none: random weights)
Makes an environment of its own (build/venv-onnx: onnxruntime, onnx, numpy) where there is none.

Ours is sconce_luminaire_eval of libsconce: lines to encoding to network to radiance. Against it stand onnxruntime's graph of the
whole (u and w given, encoding by Sin and Cos) and of the network alone (encoded input given), which has less to do than ours."""
import argparse
import ctypes
import json
import os
import pathlib
import statistics
import struct
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
VENV = ROOT / "build" / "venv-onnx"


def enter_environment():
    if pathlib.Path(sys.prefix) == VENV:
        return
    if not (VENV / ".complete").exists():
        subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
        subprocess.run([VENV / "bin/pip", "install", "-q", "onnxruntime", "onnx", "numpy"], check=True)
        (VENV / ".complete").touch()
    os.execv(VENV / "bin/python", [VENV / "bin/python", *sys.argv])


def read_tensors(path):
    import numpy as np
    data = path.read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8:8 + length])
    return {name: np.frombuffer(data, "<f4", (at["data_offsets"][1] - at["data_offsets"][0]) // 4, 8 + length + at["data_offsets"][0])
            for name, at in header.items() if name != "__metadata__"}


def write_random_lamp(path):
    """A unit sphere with random weights of the scale that training starts from; L is then about 1."""
    import numpy as np
    random = np.random.default_rng(1)
    tensors = {"proxy": np.array([0, 0, 0, 0, 1] + [0] * 11), "flux": np.ones(3)}
    for name, inputs, width, hidden, outputs in (("eval", 120, 512, 7, 3), ("transparency", 120, 512, 7, 3), ("sampling", 3, 256, 4, 768)):
        sizes = [(inputs, width)] + [(width, width)] * hidden + [(width, outputs)]
        parts = []
        for n_in, n_out in sizes:
            parts += [random.standard_normal(n_in * n_out) * (1 / n_in) ** 0.5, 0.1 * random.standard_normal(n_out)]
        tensors[f"paper.{name}"] = np.concatenate(parts)
    header, at = {"__metadata__": {"format": "sconce-luminaire", "format_version": "1"}}, 0
    for name, values in tensors.items():
        header[name] = {"dtype": "F32", "shape": [len(values)], "data_offsets": [at, at + 4 * len(values)]}
        at += 4 * len(values)
    text = json.dumps(header).encode()
    path.write_bytes(struct.pack("<Q", len(text)) + text + b"".join(v.astype("<f4").tobytes() for v in tensors.values()))


def make_session(weights, encode):
    import numpy as np
    import onnx
    import onnxruntime
    from onnx import TensorProto, helper, numpy_helper
    nodes, constants = [], []

    def constant(name, values, kind="float32"):
        constants.append(numpy_helper.from_array(np.ascontiguousarray(values, kind), name))
        return name

    def node(kind, inputs, output, **attributes):
        nodes.append(helper.make_node(kind, inputs, [output], **attributes))
        return output

    x = "input"
    if encode:  # [n, 2 vectors, 3] -> [n, 2, 10 frequencies, sin and cos, 3] -> [n, 120]
        spread = node("Reshape", [x, constant("shape5", [-1, 2, 1, 1, 3], "int64")], "spread")
        angle = node("Mul", [spread, constant("frequencies", (np.pi * 2.0 ** np.arange(10)).reshape(1, 1, 10, 1, 1))], "angle")
        both = node("Concat", [node("Sin", [angle], "sine"), node("Cos", [angle], "cosine")], "both", axis=3)
        x = node("Reshape", [both, constant("shape2", [-1, 120], "int64")], "encoded")
    layers, at, activations = [120] + [512] * 8 + [3], 0, [x]
    for l, (n_in, n_out) in enumerate(zip(layers, layers[1:])):
        w = constant(f"w{l}", weights[at:at + n_in * n_out].reshape(n_out, n_in).T)
        at += n_in * n_out
        b = constant(f"b{l}", weights[at:at + n_out])
        at += n_out
        y = node("Gemm", [activations[-1], w, b], f"y{l}")
        if l in (3, 5, 7):
            y = node("Add", [y, activations[-2]], f"sum{l}")
        activations.append(node("Relu", [y], f"relu{l}") if l < 8 else y)
    assert at == 1902083 == len(weights)
    y = activations[-1]
    if encode:
        y = node("Sub", [node("Exp", [node("Relu", [y], "positive")], "exponential"), constant("one", [1.0])], "radiance")
    shape = ["n", 2, 3] if encode else ["n", 120]
    graph = helper.make_graph(nodes, "eval", [helper.make_tensor_value_info("input", TensorProto.FLOAT, shape)],
                              [helper.make_tensor_value_info(y, TensorProto.FLOAT, ["n", 3])], constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    model.ir_version = 9
    onnx.checker.check_model(model)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    return onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])


class Luminaire:
    def __init__(self, path):
        self.library = ctypes.CDLL(ROOT / "build" / "release" / "libsconce.so")
        self.handle = ctypes.c_void_p()
        error = ctypes.create_string_buffer(1100)
        if self.library.sconce_luminaire_open(ctypes.byref(self.handle), os.fsencode(path), error):
            sys.exit(error.raw[4:].split(b"\0")[0].decode())

    def eval(self, point, w, radiance):
        pointer = ctypes.c_void_p
        self.library.sconce_luminaire_eval(self.handle, ctypes.c_size_t(len(point)), pointer(point.ctypes.data), pointer(w.ctypes.data),
                                           pointer(radiance.ctypes.data))


def timed(call, queries, total):
    start = time.process_time()
    for _ in range(max(1, total // queries)):
        call()
    return (time.process_time() - start) / max(1, total // queries) / queries


def main():
    enter_environment()
    import numpy as np
    import onnxruntime
    parser = argparse.ArgumentParser()
    parser.add_argument("lamp", nargs="?", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=9)
    options = parser.parse_args()
    if not options.lamp:
        options.lamp = ROOT / "build" / "random_paper.safetensors"
        write_random_lamp(options.lamp)
    tensors = read_tensors(options.lamp)
    center, radius = tensors["proxy"][1:4], tensors["proxy"][4]
    luminaire = Luminaire(options.lamp)
    whole, network = make_session(tensors["paper.eval"], True), make_session(tensors["paper.eval"], False)
    random = np.random.default_rng(2)
    print(f"onnxruntime {onnxruntime.__version__}, one thread; median of {options.runs} runs in turn [k queries per CPU second], ratio of the medians")
    for queries in (4096, 256):
        u = random.standard_normal((queries, 3))
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        w = random.standard_normal((queries, 3))
        w /= np.linalg.norm(w, axis=1, keepdims=True)
        w *= np.sign(np.sum(u * w, axis=1, keepdims=True))  # the light leaves through u
        point, w = (center + radius * u).astype(np.float32), w.astype(np.float32)
        lines = np.stack([u, w], 1).astype(np.float32)
        angle = lines.astype(np.float64)[:, :, None, :] * (np.pi * 2.0 ** np.arange(10))[None, None, :, None]
        encoded = np.stack([np.sin(angle), np.cos(angle)], 3).reshape(queries, 120).astype(np.float32)
        radiance = np.zeros((queries, 3), np.float32)
        luminaire.eval(point, w, radiance)
        expected = whole.run(None, {"input": lines})[0]
        difference = np.abs(np.log1p(radiance) - np.log1p(expected))
        calls = {"ours": lambda: luminaire.eval(point, w, radiance), "onnxruntime, whole": lambda: whole.run(None, {"input": lines}),
                 "onnxruntime, network": lambda: network.run(None, {"input": encoded})}
        seconds = {name: [] for name in calls}
        for run in range(options.runs + 1):
            for name, call in calls.items():
                seconds[name].append(timed(call, queries, 8192))
        median = {name: statistics.median(times[1:]) for name, times in seconds.items()}  # without the first run
        print(f"batch {queries}: " + "; ".join(f"{name} {1e-3 / t:.1f}" for name, t in median.items()))
        for name in list(calls)[1:]:
            ratios = sorted(b / a for a, b in zip(seconds["ours"][1:], seconds[name][1:]))
            print(f"  ours over {name}: {median[name] / median['ours']:.2f} ({ratios[0]:.2f} to {ratios[-1]:.2f} in single runs)")
        print(f"  difference of log(1 + L): mean {difference.mean():.1e}, largest {difference.max():.1e}, of a mean of {np.log1p(expected).mean():.2f}")


main()
