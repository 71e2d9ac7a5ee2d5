#!/usr/bin/python3
"""panned_brackets.py PHOTOS RESPONSES.csv FOLDER [PANORAMAS SEED..]: clips with ground truth from HDR photographs, as a camera's bracket would
show them

PHOTOS: a folder with Bonita.exr, Desk.exr, Flowers.exr, StillLife.exr, Tree.exr (OpenEXR's test images); RESPONSES.csv: 201 lines of 1024
relative codes (DoRF). Each exposure is one still: photons, read noise, noise reduction, a toe, the response, a pedestal, JPEG. Frames are
windows of 320x240 that pan over the stills in turn, by whole pixels, so that errors of a still stay with the scene, as in real brackets
that are panned over, and do not average out. With seeds each draws one bracket, n and its number, of a photograph or of a part of a panorama (PANORAMAS:
a folder with {adams,dikhololo,forest,kiara,studio,venice}*.hdr, 1024 columns each). Then: ./run quality FOLDER. Needs Debian's python3-opencv."""
import json
import os
import pathlib
import random
import sys
from dataclasses import dataclass

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
try:
    import cv2
    import numpy as np
except ImportError as missing:
    sys.exit(f"panned_brackets.py: {missing}; it needs Debian's python3-opencv")

ROWS, COLS = 240, 320
BASE_S = 0.002  # exposure time of 0 EV


@dataclass
class Bracket:
    name: str
    photo: str
    stops: tuple
    pedestal: tuple  # codes of r, g, b
    curve: object  # number of the red response, or the name of one that no database holds
    seed: int
    jpeg: int
    full_well: float = 4000
    read_noise: float = 6
    frames: int = 18
    pan: tuple = (2.3, 0.7)  # px per frame
    middle: float = 0.35  # relative exposure of the median at 0 EV, times three
    toe: float = 0
    smooth: bool = False


CHOSEN = [
    Bracket("b1", "Bonita", (-3, 0, 3), (18, 14, 16), 33, 1, 92),
    Bracket("b2", "Desk", (-4, 0, 4), (10, 8, 12), 99, 2, 90, middle=0.3),
    Bracket("b3", "Tree", (-2, 0, 2), (0, 0, 0), 120, 3, 88),
    Bracket("b4", "StillLife", (-2, 0, 2, 4), (5, 6, 18), 63, 4, 95, middle=0.1),
    Bracket("b5", "Desk", (-2, 2), (0, 3, 6), 15, 5, 85, middle=0.25, toe=0.003, smooth=True),
    Bracket("b6", "Flowers", (-3, 0, 3), (18, 18, 18), 142, 6, 90, smooth=True),
    Bracket("b7", "Bonita", (-4, -2, 0, 2, 4), (0, 0, 0), 48, 7, 93, toe=0.002, smooth=True),
    Bracket("b8", "Tree", (-4, 0, 4), (12, 15, 18), 180, 8, 90),
]
UNUSUAL = [
    ("c1", "linear", "Desk", (-2, 0, 2)), ("c2", "srgb", "Tree", (-3, 0, 3)), ("c3", "log", "Bonita", (-2, 0, 2)),
    ("c4", "s", "Desk", (-3, 0, 3)), ("c5", "hlg", "Bonita", (-2, 2)), ("c6", "linear", "Flowers", (-4, 0, 4)),
    ("c7", "gamma 1.4", "Tree", (-1, 1)), ("c8", "log", "Tree", (-3, 0, 3)), ("c9", "srgb", "Flowers", (0, 4)),
    ("c10", "s", "Bonita", (-4, 0)),
]


def drawn():
    """Twelve brackets at random, b9 to b20: nobody chose them."""
    draw = random.Random(77)
    photos = ["Bonita", "Desk", "Flowers", "StillLife", "Tree"]
    schedules = [(-2, 0, 2), (-3, 0, 3), (-4, 0, 4), (-2, 2), (-1, 1), (-3, 3), (-2, -0.5, 1, 2.5), (-5, 0), (-3, -1, 1, 3)]
    for number in range(9, 21):
        stops = draw.choice(schedules)
        level = draw.choice([0, draw.randint(2, 18), draw.randint(2, 18)])
        pedestal = tuple(max(0, min(20, level + draw.randint(-3, 3))) if level else 0 for _ in range(3))
        curve = draw.randrange(0, 200, 3)
        yield Bracket(f"b{number}", draw.choice(photos), stops, pedestal, curve, 7000 + number, draw.randint(82, 97),
                      draw.choice([1500, 4000, 10000]), draw.choice([3, 8, 14]), 12, middle=draw.choice([0.1, 0.25, 0.45]),
                      smooth=bool(draw.choice([0, 1])), toe=draw.choice([0, 0, 0.003]),
                      pan=(draw.uniform(-5, 5), draw.uniform(-2, 2)))


def unusual_curve(name):
    x = np.linspace(0, 1, 1024)
    if name == "linear":
        return x
    if name == "srgb":
        return np.where(x < 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    if name == "log":
        return np.log1p(500 * x) / np.log1p(500)
    if name == "s":
        y = x ** (1 / 2.2)
        return 0.8 * y * y * (3 - 2 * y) + 0.2 * y
    if name == "hlg":
        return np.where(x <= 1 / 12, np.sqrt(3 * x), 0.17883277 * np.log(np.maximum(12 * x - 0.28466892, 1e-6)) + 0.55991073)
    return x ** (1 / 1.4)


def curves_of(bracket, responses):
    if isinstance(bracket.curve, str):
        return np.tile(unusual_curve(bracket.curve), (3, 1))
    return responses[[bracket.curve, bracket.curve + 1, bracket.curve + 2]]


PHOTOS = ["Bonita", "Desk", "Flowers", "StillLife", "Tree"]
PANORAMAS = ["adams", "dikhololo", "forest", "kiara", "studio", "venice"]


def drawn_of(seed):
    """One bracket; the order of the draws is part of what a seed means."""
    draw = random.Random(seed)
    photo = draw.choice(PHOTOS + [f"{name}@{draw.randrange(1024)}" for name in PANORAMAS])  # @: its first column
    stops = draw.choice([(-2, 0, 2), (-3, 0, 3), (-4, 0, 4), (-2, 2), (-1, 1), (-3, 3), (-2, -0.5, 1, 2.5), (-5, 0),
                         (-3, -1, 1, 3), (-2.5, 0, 2.5), (-4, 0)])
    level = draw.choice([0, draw.randint(2, 18), draw.randint(2, 18)])
    pedestal = tuple(max(0, min(20, level + draw.randint(-3, 3))) if level else 0 for _ in range(3))
    curve = draw.choice([draw.randrange(199), draw.randrange(199), draw.choice(["linear", "srgb", "log", "s", "hlg", "gamma 1.4"])])
    return Bracket(f"n{seed}", photo, stops, pedestal, curve, seed, draw.randint(80, 97), draw.choice([1500, 4000, 10000]),
                   draw.choice([3, 8, 14]), 12, middle=draw.choice([0.1, 0.25, 0.45]), smooth=bool(draw.choice([0, 1])),
                   toe=draw.choice([0, 0, 0.003]), pan=(draw.uniform(-5, 5), draw.uniform(-2, 2)))


def part_of(panorama, first_column):
    """What a camera sees around the horizon, with a sun that is not brighter than four times the rest."""
    light = cv2.imread(str(panorama), cv2.IMREAD_UNCHANGED)[..., :3].astype(np.float32)
    light = np.roll(light, -first_column, 1)[130:400, :512]
    light = np.clip(light, 1e-5, np.percentile(light, 99.95) * 4)
    return cv2.resize(light, None, fx=1.15, fy=1.15, interpolation=cv2.INTER_LINEAR)


def scene_of(bracket, photos, panoramas):
    """The photograph's light [rows, cols, b g r], reduced so that a window leaves room for the pan."""
    if "@" in bracket.photo:
        name, first_column = bracket.photo.split("@")
        return part_of(next(panoramas.glob(f"{name}*.hdr")), int(first_column))
    light = cv2.imread(str(photos / f"{bracket.photo}.exr"), cv2.IMREAD_UNCHANGED)[..., :3].astype(np.float32)
    light = np.maximum(light, 1e-5)
    factor = min(light.shape[1] / COLS, light.shape[0] / ROWS) * 0.62
    light = cv2.GaussianBlur(light, (0, 0), 0.5 * max(1, factor))
    return cv2.resize(light, None, fx=1 / factor, fy=1 / factor, interpolation=cv2.INTER_AREA)


def still(exposed, bracket, curves, noise):
    """The camera's JPEG of relative exposures, decoded."""
    electrons = noise.poisson(np.minimum(exposed, 4) * bracket.full_well).astype(np.float32)
    electrons += noise.normal(0, bracket.read_noise, exposed.shape)
    x = np.clip(electrons / bracket.full_well, 0, 1).astype(np.float32)
    if bracket.smooth:
        x = cv2.bilateralFilter(x, 5, 0.04, 1.5)
    if bracket.toe:
        x = np.maximum(x - bracket.toe, 0) / (1 - bracket.toe)
    black = np.array(bracket.pedestal[::-1], np.float32)
    codes = np.empty_like(x)
    for channel in range(3):
        codes[..., channel] = np.interp(x[..., channel], np.linspace(0, 1, 1024), curves[2 - channel])
    codes = np.uint8(np.clip(np.rint(codes * (255 - black) + black), 0, 255))
    return cv2.imdecode(cv2.imencode(".jpg", codes, [cv2.IMWRITE_JPEG_QUALITY, bracket.jpeg])[1], cv2.IMREAD_COLOR)


def corners_of(bracket, shape):
    """Upper left corners of the windows, one more than frames: a pan and a hand's shake, in whole pixels."""
    (dx, dy), n, phase = bracket.pan, bracket.frames, bracket.seed
    x0, y0 = (shape[1] - COLS) / 2 - dx * n / 2, (shape[0] - ROWS) / 2 - dy * n / 2
    return [(round(x0 + dx * i + 2 * np.sin(0.7 * i + phase)), round(y0 + dy * i + 1.5 * np.sin(0.9 * i + 2 * phase)))
            for i in range(n + 1)]


def window(picture, corner):
    to_window = np.float32([[1, 0, corner[0]], [0, 1, corner[1]]])
    return cv2.warpAffine(picture, to_window, (COLS, ROWS), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                          borderMode=cv2.BORDER_REFLECT)


def film(bracket, photos, panoramas, responses, folder):
    noise = np.random.default_rng(bracket.seed)
    light, curves = scene_of(bracket, photos, panoramas), curves_of(bracket, responses)
    gain = bracket.middle / (3 * float(np.median(light[..., 1])))
    times = [2.0**stop for stop in bracket.stops]
    stills = [still(light * gain * time, bracket, curves, noise) for time in times]
    clip = folder / bracket.name
    for kind in ("ldr", "gt/hdr", "gt/flow", "gt/id"):
        (clip / kind).mkdir(parents=True, exist_ok=True)
    corners, frames, truth = corners_of(bracket, light.shape), [], []
    for i in range(bracket.frames):
        time, here, after = times[i % len(times)], corners[i], corners[i + 1]
        cv2.imwrite(str(clip / f"ldr/{i:04d}.png"), window(stills[i % len(times)], here))
        cv2.imwrite(str(clip / f"gt/hdr/{i:04d}.exr"), window(light, here), [cv2.IMWRITE_EXR_TYPE, cv2.IMWRITE_EXR_TYPE_HALF])
        flow = np.zeros((ROWS, COLS, 3), np.float32)  # occluded, dy, dx as OpenCV orders channels
        flow[..., 1], flow[..., 2] = here[1] - after[1], here[0] - after[0]
        cv2.imwrite(str(clip / f"gt/flow/{i:04d}.exr"), flow)
        cv2.imwrite(str(clip / f"gt/id/{i:04d}.png"), np.zeros((ROWS, COLS), np.uint8))
        frames.append({"file": f"ldr/{i:04d}.png", "time_s": round(i / 30, 6), "exposure_s": BASE_S * time})
        truth.append({"time_s": i / 30, "exposure_s": BASE_S * time, "r_sat": 1 / (gain * time)})
    lens = {"fx": 0.96 * COLS, "fy": 0.96 * COLS, "cx": COLS / 2, "cy": ROWS / 2}
    (clip / "clip.json").write_text(json.dumps(
        {"name": bracket.name, "width": COLS, "height": ROWS, "fps": 30, **lens, "bits": 8, "frames": frames}))
    (clip / "gt/gt.json").write_text(json.dumps(
        {"options": {"seed": bracket.seed}, "axes": "x right, y down, z forward; c2w row-major 3x4", "frames": truth,
         "r_sat_shortest": 1 / (gain * min(times)), "r_max": float(light.max()), "moving_ids": []}))
    np.savetxt(clip / "gt/crf.csv", curves, delimiter=",", fmt="%.6g")
    print(clip)


def main():
    arguments, seeds = sys.argv[1:5], sys.argv[5:]
    if len(arguments) not in (3, 4) or (len(arguments) == 4) != bool(seeds) or not all(map(str.isdigit, seeds)):
        sys.exit(__doc__)
    photos, responses, folder = pathlib.Path(arguments[0]), np.loadtxt(arguments[1], delimiter=","), pathlib.Path(arguments[2])
    if responses.shape != (201, 1024):
        sys.exit(f"{arguments[1]}: {responses.shape} is not 201 responses of 1024 codes")
    panoramas = pathlib.Path(arguments[3]) if seeds else None
    unusual = [Bracket(name, photo, stops, (0, 0, 0), curve, 8000 + i, 96, 6000, 5, 12, middle=0.25)
               for i, (name, curve, photo, stops) in enumerate(UNUSUAL)]
    for bracket in map(drawn_of, map(int, seeds)) if seeds else [*CHOSEN, *drawn(), *unusual]:
        film(bracket, photos, panoramas, responses, folder)


if __name__ == "__main__":
    main()
