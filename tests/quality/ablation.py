#!/usr/bin/python3
"""ablation.py HDRCAM CLIP.. [-o FILE]: what each part of the method is worth, the part left out or exchanged.

For each clip with ground truth (clip.json, ldr/, gt/ with novel views) and each row the recording is replayed with the row's
knobs: scores of the HDR frames, of the field's view from the clip's other camera, of its depth and of the motion of moving
objects. Rows that change motion or radiance are also scored between the frames, with every second frame left out (as
novel_time.py does). Writes a page in Markdown (default out/ablation.md)."""
import argparse
import json
import pathlib
import shlex
import statistics
import tempfile

from half_clips import half_of, refuse_without_truth, run, score

LOSSES = ("combined", "warped", "occlusion", "flow", "depth", "cycle", "spatial", "temporal", "minimal", "state", "consistency",
          "entropy", "response")


def knobs(*assignments):
    return [word for assignment in assignments for word in ("--set", assignment)]


# name, flags of replay, whether it is scored between the frames
ROWS = [
    ("**as it is**", [], True),
    ("response: none, codes as they are", knobs("response=linear"), True),
    ("response: fixed, the mean of real cameras", knobs("response=mean"), True),
    ("response: a network", knobs("response=network"), True),
    ("response: refined by the loss", knobs("refine_response=on"), True),
    ("motion blur: as stated", knobs("motion_blur=stated"), True),
    ("motion blur: none", knobs("motion_blur=off"), True),
    ("flow: fast", knobs("flow=fast"), True),
    ("flow: medium", knobs("flow=medium"), True),
    ("flow: fine", knobs("flow=fine"), True),
    ("static branch alone", knobs("branches=static"), True),
    ("dynamic branch alone", knobs("branches=dynamic"), True),
    ("the paper's blending weight", knobs("blend=weight"), False),
    ("window of 3 frames", knobs("window_frames=3"), True),
    ("window of 12 frames", knobs("window_frames=12"), True),
    ("no fit", knobs("view_steps=0"), False),
    ("100 steps a frame", knobs("view_steps=100"), False),
    *((f"without the loss `{name}`", knobs(f"loss.{name}=0"), False) for name in LOSSES),
    ("with the loss `distortion`", knobs("loss.distortion=0.01"), False),
]

COLUMNS = (("psnr_mu", "HDR frames, dB", "{:.2f}"), ("flicker", "flicker, stops", "{:.4f}"),
           ("novel_psnr_mu", "novel view, dB", "{:.2f}"), ("depth_abs_rel", "depth abs-rel", "{:.3f}"),
           ("field_flow_moving_epe_px", "moving objects, px", "{:.2f}"), ("between", "novel time, dB", "{:.2f}"))

# Novel views of the GoPro scenes, PSNR in dB: tables "tone-mapping designs" and "flow model" of the paper.
PAPER = (("without tone mapping", 17.79), ("fixed response", 25.55), ("response as an MLP", 28.76), ("piecewise response", 31.01),
         ("flow of RAFT", 30.42), ("RAFT, fine-tuned on exposures", 30.68), ("flow of DINO-Tracker", 31.01))


def first(tree, key):
    """The first number of this name, at any depth."""
    if isinstance(tree, dict):
        if isinstance(tree.get(key), (int, float)):
            return tree[key]
        tree = [value for value in tree.values() if isinstance(value, dict)]
        return next((found for found in (first(value, key) for value in tree) if found is not None), None)
    return None


def scores_of(hdrcam, clip, recording, flags, place):
    run(hdrcam, "replay", recording, "-o", place / "%06d.exr", "--truth", clip, "--layers", "depth,flow,field_flow", *flags)
    run(hdrcam, "compare", clip, place, "--json", place / "scores.json")
    scores = json.loads((place / "scores.json").read_text())
    return {key: first(scores, key) for key, _, _ in COLUMNS}


def between_frames(hdrcam, clip, half, flags, place):
    run(hdrcam, "render", half, "--speed", 0.5, "-o", place / "%06d.exr", *flags)
    frames = len(list(place.glob("*.exr")))
    return score(hdrcam, clip, place, range(1, frames, 2))


def rows_of(hdrcam, clip, scratch):
    run(hdrcam, "import", clip, "-o", scratch / "clip.mkv")
    half_of(clip, scratch / "half")
    run(hdrcam, "import", scratch / "half" / "clip.json", "--allow-outside", "-o", scratch / "half.mkv")
    for name, flags, moves in ROWS:
        with tempfile.TemporaryDirectory(dir=scratch) as place, tempfile.TemporaryDirectory(dir=scratch) as film:
            row = scores_of(hdrcam, clip, scratch / "clip.mkv", flags, pathlib.Path(place))
            if moves:
                row["between"] = between_frames(hdrcam, clip, scratch / "half.mkv", flags, pathlib.Path(film))
        print(clip.name, name, " ".join(f"{key} {value:.4g}" for key, value in row.items() if value is not None), flush=True)
        yield name, row


def page(command, clips, table):
    yield "# What each part is worth"
    yield ""
    names = ", ".join(clip.name for clip in clips)
    yield f"Made by `{command}`: {'means over' if len(clips) > 1 else 'one clip,'} {names}; `--preset balanced`."
    yield "One part is exchanged or left out at a time. HDR frames (PSNR-mu) and flicker are those of the emitted frames"
    yield "(state and field merged); novel views, depth and the motion of moving objects are the field's; novel time is the film between the"
    yield "frames, with every second frame left out."
    yield ""
    yield "README.md's clips are not in the repository. Any clip with ground truth gives such a table. With a simulated one the figures differ,"
    yield "and there is no novel view, for it has no second camera:"
    yield "```sh"
    yield "hdrcam simulate 'walk?size=320x240' --frames 24 -o walk.mkv --truth walk"
    yield "./run ablation walk"
    yield "```"
    yield ""
    yield "| | " + " | ".join(title for _, title, _ in COLUMNS) + " |"
    yield "|---|" + "---|" * len(COLUMNS)
    for name, rows in table.items():
        cells = []
        for key, _, form in COLUMNS:
            values = [row[key] for row in rows if row.get(key) is not None]
            cells.append(form.format(statistics.mean(values)) if len(values) == len(rows) else "-")
        yield f"| {name} | " + " | ".join(cells) + " |"
    yield ""
    yield "The paper's figures for its own ablations, of other clips and an offline fit (novel views, PSNR):"
    yield ""
    yield "| paper | dB |"
    yield "|---|---|"
    for name, value in PAPER:
        yield f"| {name} | {value:.2f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("hdrcam")
    parser.add_argument("clips", type=pathlib.Path, nargs="+", metavar="CLIP")
    parser.add_argument("-o", "--out", type=pathlib.Path, default="out/ablation.md")
    given = parser.parse_args()
    for clip in given.clips:
        refuse_without_truth(clip)
    table = {name: [] for name, _, _ in ROWS}
    for clip in given.clips:
        with tempfile.TemporaryDirectory() as scratch:
            for name, row in rows_of(given.hdrcam, clip.resolve(), pathlib.Path(scratch)):
                table[name].append(row)
    command = shlex.join(["./run", "ablation", *map(str, given.clips), "-o", str(given.out)])
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text("\n".join(page(command, given.clips, table)) + "\n")
    print(f"the page is {given.out}")


if __name__ == "__main__":
    main()
