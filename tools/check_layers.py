#!/usr/bin/env python3
"""Checks that every #include points down: the layers are the LAYERS list of CMakeLists.txt, lowest first."""
import pathlib
import re
import sys

root = pathlib.Path(__file__).resolve().parent.parent
layers = re.findall(r'"([^"]+)"', re.search(r"set\(LAYERS ([^)]*)\)", (root / "CMakeLists.txt").read_text()).group(1))
level = {folder: i for i, layer in enumerate(layers) for folder in layer.split()}

wrong = []
files = sorted((root / "src").rglob("*.[ch]"))
for path in files:
    folder = path.relative_to(root / "src").parts[0]
    for number, line in enumerate(path.read_text().splitlines(), 1):
        match = re.match(r'#include "([^"/]+)/', line)
        if match and match.group(1) in level:
            target = match.group(1)
            if target != folder and level[target] >= level[folder]:
                wrong.append(f"{path.relative_to(root)}:{number}: {folder} includes {target}, which is not below it")
        if folder == "cli" and re.match(r'#include "[^"]*/', line):
            wrong.append(f"{path.relative_to(root)}:{number}: the program uses include/sconce only")
print("\n".join(wrong) if wrong else f"{len(files)} files: every include points down the layers")
sys.exit(bool(wrong))
