#!/usr/bin/env python3
"""drawn_clips.py [--unusual | --fast] GENERATOR DATA FOLDER SEED..: clips with ground truth whose settings nobody chose

GENERATOR: a renderer of clips with the flags below (--out, --style, --pano, --crf..) that writes clip.json, ldr/ and gt/. DATA: a folder with
panoramas/*.hdr, photos/{Desk,Tree,Bonita}.exr and the 201 responses of DoRF (dorf201_on_uniform_E_1024.csv). Each seed draws a scene, a
camera's path, objects and their speed, a cycle of exposures, three responses, full well, read noise and bits; half of the clips are JPEG, four in
ten come through a camera's engine with exposures that are not quite the stated ones. 16 frames of 320x240. --unusual: further from what the
program was made with: other sizes, lenses and frame rates, steps of up to six stops, exposures that jitter, objects that cross the picture in a few
frames, harder compression and sharpening. --fast: objects that move three to six times as fast, 14 frames of 480x360. Then:
./run quality FOLDER."""
import os
import random
import subprocess
import sys

PANORAMAS = ["adams_place_bridge_1k", "dikhololo_night_1k", "forest_slope_1k", "kiara_1_dawn_1k", "studio_small_03_1k", "venice_sunset_1k"]
RESPONSES = 201
CYCLES = ["-2,0,2", "-3,0,3", "-2,2", "-3,1", "-4,0", "-4,0,4", "-2,0,2,4", "0,3", "-1.5,0,1.5", "-3,-1,1,3"]  # EV


def scene(draw, seed, data, photos):
    """World, textures and responses; the order of the draws is part of what a seed means."""
    return {
        "style": draw.choice(["dome", "street", "room"]),
        "pano": f"{data}/panoramas/{draw.choice(PANORAMAS)}.hdr",
        "tex": ",".join(f"{data}/photos/{photo}.exr" for photo in photos),
        "crfcsv": f"{data}/dorf201_on_uniform_E_1024.csv",
        "crf": ",".join(str(draw.randrange(RESPONSES)) for _ in range(3)),
        "seed": seed,
    }


def drawn(seed, data, objects=(1, 6), speeds=(0.5, 1, 1, 2, 3)):
    """The generator's flags. objects: the least number of them, and one more than the most."""
    draw = random.Random(seed)
    flags = {
        **scene(draw, seed, data, ["Desk", "Tree", "Bonita"]),
        "ev": draw.choice(CYCLES),
        "cam": draw.choice(["handheld", "handheld", "pan", "dolly", "orbit", "none"]),
        "objs": draw.randrange(*objects),
        "speed": draw.choice(speeds),
        "fullwell": draw.choice([1200, 3000, 6000, 12000]),
        "read": draw.choice([3, 6, 8, 14]),
        "bits": draw.choice([8, 8, 10, 12]),
        "frames": 16,
        "w": 320,
        "h": 240,
    }
    if draw.random() < 0.5:
        flags["jpeg"] = draw.choice([80, 88, 93, 96])
        flags["bits"] = 8
    if draw.random() < 0.4:
        flags["isp"] = 1
        flags["toe"] = draw.choice([0, 0.002, 0.004])
        flags["evnominal"] = 0.06
        flags["sharpen"] = draw.choice([0, 0.3, 0.6])
    if flags["style"] == "room":
        flags["lamps"] = draw.randrange(1, 4)
    return flags


def fast(seed, data):
    """As drawn(), with objects that move farther than their own size from one frame to the next but one."""
    return {**drawn(seed, data, objects=(2, 6), speeds=(3, 4, 6)), "frames": 14, "w": 480, "h": 360}


UNUSUAL_CYCLES = ["-6,0", "-5,-1,3", "-1,1", "-5,0,5", "0,2,4", "-2,-1,0,1", "-3,3", "-4,-2,0", "0,5", "-2,4,1"]  # EV


def unusual(seed, data):
    """As drawn(), from wider ranges."""
    draw = random.Random(seed * 7)
    width, height = draw.choice([(320, 240), (256, 256), (360, 202), (400, 300), (240, 320)])
    flags = {
        **scene(draw, seed, data, ["Tree", "Bonita", "Desk"]),
        "ev": draw.choice(UNUSUAL_CYCLES),
        "evjit": draw.choice([0, 0, 0.1, 0.2]),
        "emid": draw.choice([0.002, 0.004, 0.01, 0.02]),
        "cam": draw.choice(["handheld", "pan", "dolly", "orbit", "none"]),
        "camspeed": draw.choice([0.5, 1, 2]),
        "objs": draw.randrange(0, 7),
        "speed": draw.choice([0.5, 1, 2, 4]),
        "pulse": draw.choice([0, 0, 1]),
        "mirror": draw.choice([0, 0, 1]),
        "fullwell": draw.choice([800, 2500, 9000, 20000]),
        "read": draw.choice([2, 5, 12, 20]),
        "bits": draw.choice([8, 8, 10, 12]),
        "frames": draw.choice([14, 18, 22]),
        "fps": draw.choice([15, 24, 30, 60]),
        "w": width,
        "h": height,
        "fov": draw.choice([40, 55, 75]),
    }
    if flags["style"] != "street" and draw.random() < 0.4:
        flags["lamps"] = draw.randrange(1, 4)
    if draw.random() < 0.5:
        flags["jpeg"] = draw.choice([60, 75, 85, 95])
        flags["bits"] = 8
    if draw.random() < 0.45:
        flags["isp"] = draw.choice([0.5, 1])
        flags["toe"] = draw.choice([0, 0.003, 0.01])
        flags["sharpen"] = draw.choice([0, 0.4, 1])
        flags["evnominal"] = draw.choice([0, 0.06, 0.15])
    return flags


def main():
    settings = drawn
    if sys.argv[1:2] in (["--unusual"], ["--fast"]):
        settings = {"--unusual": unusual, "--fast": fast}[sys.argv.pop(1)]
    if len(sys.argv) < 5 or not all(seed.isdigit() for seed in sys.argv[4:]):
        sys.exit(__doc__)
    generator, data, folder = sys.argv[1:4]
    for seed in map(int, sys.argv[4:]):
        out = f"{folder}/s{seed}"
        if os.path.exists(f"{out}/clip.json"):
            continue
        flags = {"out": out, "name": f"s{seed}", **settings(seed, data)}
        made = subprocess.run([generator] + [word for flag, value in flags.items() for word in (f"--{flag}", str(value))],
                              capture_output=True, text=True)
        if made.returncode != 0:
            sys.exit(f"drawn_clips.py: '{generator}' failed on seed {seed}: {made.stderr.strip()[-300:]}")
        print(out, flush=True)


main()
