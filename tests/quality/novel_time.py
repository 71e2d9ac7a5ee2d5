#!/usr/bin/python3
"""novel_time.py HDRCAM CLIP [--keep FOLDER] [-- FLAGS..]: how good the pictures between the frames are.

Every second frame of a clip with ground truth (clip.json, ldr/, gt/) is left out. `hdrcam render --speed 0.5`
makes the film of the others with the missing moments between them, and `hdrcam compare` scores the frames that
were left out. Beside it, from the film's other frames, which are those of `hdrcam replay` to the bit: the mean of the two
neighbours, and the two neighbours warped half way along OpenCV's DIS flow between them and blended.
FLAGS go to render. Needs python3-opencv. Prints one line of PSNR-mu in dB, mean over the frames left out."""
import argparse
import os
import pathlib
import sys
import tempfile

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
try:
    import cv2
    import numpy as np
except ImportError as missing:
    sys.exit(f"novel_time.py: {missing}; it needs Debian's python3-opencv")

from half_clips import half_of, refuse_without_truth, run, score


def read(path):
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)[..., :3].astype(np.float32)


def codes(picture, white):
    luminance = picture @ np.float32([0.25, 0.5, 0.25])
    return (255 * np.log1p(500 * np.clip(luminance / white, 0, 1)) / np.log(501)).astype(np.uint8)


def warped_half_way(a, b, white):
    dis = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    dis.setFinestScale(0)
    rows, cols = a.shape[:2]
    x, y = np.meshgrid(np.arange(cols, dtype=np.float32), np.arange(rows, dtype=np.float32))

    def half(near, far):
        flow = dis.calc(codes(near, white), codes(far, white), None)
        # the picture half way shows at p what `near` shows at p - flow / 2
        return cv2.remap(near, x - flow[..., 0] / 2, y - flow[..., 1] / 2, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)

    return np.maximum(0, (half(a, b) + half(b, a)) / 2)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("hdrcam")
    parser.add_argument("clip", type=pathlib.Path)
    parser.add_argument("--keep", type=pathlib.Path, help="a folder for all pictures")
    cut = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    given, flags = parser.parse_args(sys.argv[1:cut]), sys.argv[cut + 1:]
    refuse_without_truth(given.clip)
    with tempfile.TemporaryDirectory() as scratch:
        place = given.keep or pathlib.Path(scratch)
        place.mkdir(parents=True, exist_ok=True)
        half_of(given.clip, place / "half")
        run(given.hdrcam, "import", place / "half" / "clip.json", "--allow-outside", "-o", place / "half.mkv")
        run(given.hdrcam, "render", place / "half.mkv", "--speed", 0.5, "-o", place / "film" / "%06d.exr", *flags)
        film = sorted((place / "film").glob("*.exr"))
        missing = range(1, len(film), 2)
        kept = [read(path) for path in film[::2]]
        white = float(np.percentile(np.stack(kept), 99.9))
        scores = {"render": score(given.hdrcam, given.clip, place / "film", missing)}
        peers = {"mean": lambda a, b: (a + b) / 2, "warped": lambda a, b: warped_half_way(a, b, white)}
        for name, between in peers.items():
            (place / name).mkdir()
            for i, picture in enumerate(kept):
                cv2.imwrite(str(place / name / f"{2 * i:06d}.exr"), picture)
                if i + 1 < len(kept):
                    cv2.imwrite(str(place / name / f"{2 * i + 1:06d}.exr"), between(picture, kept[i + 1]))
            scores[name] = score(given.hdrcam, given.clip, place / name, missing)
    print(given.clip.name, " ".join(f"{name} {value:.2f}" for name, value in scores.items()))


if __name__ == "__main__":
    main()
