#!/usr/bin/env python3
"""Makes dorf_prior.inc: mean and principal directions of the logarithm of real inverse camera responses.

usage: make_dorf_prior.py DORF.csv > dorf_prior.inc

DORF.csv holds one camera curve a row (Grossberg & Nayar, "What is the space of camera response functions?", CVPR
2003; 201 curves), 1024 values 0..1 on uniform exposure 0..1. Each is inverted at the codes 1..255, floored at 1.5e-4
(the darkest codes of a table are guesses), and taken as g(z) = ln x(z) - ln x(128).
"""
import sys

if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
    sys.exit(__doc__)
try:
    import numpy as np
except ImportError as missing:
    sys.exit(f"make_dorf_prior.py: {missing}; it needs Debian's python3-numpy")

DIRECTIONS = 20  # what is left, below .0006, is far below the independent part of the prior (.004, curve_prior.cpp)
curves = np.loadtxt(sys.argv[1], delimiter=",")
exposure = np.linspace(0, 1, curves.shape[1])
logs = []
for curve in curves:
    rising = np.maximum.accumulate(curve) + np.arange(len(curve)) * 1e-12
    inverse = np.interp(np.arange(1, 256) / 255.0, rising, exposure)
    log_inverse = np.log(np.maximum(1.5e-4, inverse))
    logs.append(log_inverse - log_inverse[127])
logs = np.array(logs)
mean = logs.mean(0)
_, singular, directions = np.linalg.svd(logs - mean, full_matrices=False)
scaled = directions * (singular / np.sqrt(len(logs)))[:, None]
print("// Made by make_dorf_prior.py from the 201 curves of the DoRF database; do not edit.")
print(f"constexpr int kDorfDirections = {DIRECTIONS};")
rows = [("kDorfMean[255]", mean[None])] + [("kDorfDirection[kDorfDirections][255]", scaled[:DIRECTIONS])]
for name, values in rows:
    nested = len(values) > 1
    print(f"constexpr float {name} = {{")
    for row in values:
        body = ",".join(f"{v:.4g}f" if "." in f"{v:.4g}" or "e" in f"{v:.4g}" else f"{v:.4g}.f" for v in row)
        text = ("{" + body + "}," if nested else body)
        while len(text) > 118:
            cut = text.rfind(",", 0, 118) + 1
            print(text[:cut])
            text = text[cut:]
        print(text)
    print("};")
print(f"// standard deviation of direction {DIRECTIONS + 1}: {singular[DIRECTIONS] / np.sqrt(len(logs) * 255):.2e}",
      file=sys.stderr)
