#!/usr/bin/env python3
"""Values of FLIP by its authors' program, for tests/unit/image/test_metric.c.

Needs numpy and flip_evaluator 1.7 (pip install flip_evaluator). Makes the image pairs of that test by the same
formulas, evaluates them at the viewing distance sconce uses, prints the table and fails where the values recorded in
the test differ by more than 1e-4:  python3 tests/reference/flip.py
"""

import math
import pathlib
import re
import sys

import flip_evaluator
import numpy as np

WIDTH, HEIGHT = 61, 47
PROBES = [(0, 0), (30, 20), (60, 46)]


def pair(case, x, y, c):
    """Reference and image of one pixel and channel, as in test_metric.c."""
    if case == 0:
        return 0.5 + 0.5 * math.sin(0.13 * x + 0.21 * y + c), 0.5 + 0.5 * math.sin(0.13 * x + 0.21 * y + c + 0.3)
    if case == 1:
        return 0.8 * ((x // 5 + y // 7) % 2) + 0.1 * c, 0.8 * (((x + 1) // 5 + y // 7) % 2) + 0.1 * c
    if case == 2:
        value = ((x * x + 3 * y * y + c * 37) % 101) / 100
        return value, 0.9 * value + 0.05
    if case == 3:
        return (1.0 if c == 1 else 0.0), (1.0 if c == 2 else 0.0)
    return 2 * math.sin(0.2 * x * (c + 1)), 2 * math.sin(0.2 * x * (c + 1)) + 0.3 * math.cos(0.3 * y)


def evaluate(case, exposure):
    images = np.array([[[pair(case, x, y, c) for c in range(3)] for x in range(WIDTH)] for y in range(HEIGHT)])
    images = np.clip(images.astype(np.float32) * np.float32(exposure), 0, 1)
    ppd = 0.7 * (3840 / 0.7) * math.pi / 180
    map_, mean, _ = flip_evaluator.evaluate(np.ascontiguousarray(images[..., 0]), np.ascontiguousarray(images[..., 1]),
                                            "LDR", inputsRGB=False, applyMagma=False, parameters={"ppd": ppd})
    return [float(mean)] + [float(map_[y, x, 0]) for x, y in PROBES]


def main():
    test = pathlib.Path(__file__).resolve().parents[1] / "unit/image/test_metric.c"
    block = re.search(r"flip_recorded\[\] = \{(.*?)\n\};", test.read_text(), re.S).group(1)
    rows = [[float(v) for v in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", row)] for row in re.findall(r"\{([^{}]*\{[^{}]*\})\}", block)]
    worst = 0.0
    for case, exposure in [(0, 1), (1, 1), (2, 1), (3, 1), (4, 0.7)]:
        values = evaluate(case, exposure)
        print("    {%d, %.1ff, {%s}}," % (case, exposure, ", ".join("%.6ff" % v for v in values)))
        row = [r for r in rows if r[0] == case]
        worst = max([worst] + [abs(a - b) for a, b in zip(row[0][2:], values)]) if row else math.inf
    print("largest difference to the recorded values:", worst)
    return 0 if worst < 1e-4 else 1


if __name__ == "__main__":
    sys.exit(main())
