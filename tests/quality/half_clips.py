"""A clip with ground truth of which every second frame is left out, for pictures between the frames."""
import json
import shlex
import statistics
import subprocess
import sys


def run(*words):
    """A program that fails ends the script in a sentence."""
    words = [str(word) for word in words]
    try:
        ended = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    except OSError as failed:
        sys.exit(f"'{words[0]}' does not start: {failed.strerror}")
    if ended.returncode != 0:
        sys.exit(f"'{shlex.join(words)}' failed: {ended.stderr.decode().strip()}")


def refuse_without_truth(clip):
    if not (clip / "gt" / "gt.json").exists():
        sys.exit(f"'{clip}' is no clip with ground truth (clip.json, ldr/ and gt/)")


def half_of(clip, folder):
    """The clip's even frames as a clip of their own, with pictures linked to."""
    facts = json.loads((clip / "clip.json").read_text())
    facts["frames"] = facts["frames"][::2]
    facts["fps"] = facts["fps"] / 2
    folder.mkdir()
    (folder / "ldr").symlink_to((clip / "ldr").resolve())
    (folder / "clip.json").write_text(json.dumps(facts))


def score(hdrcam, clip, folder, missing):
    """PSNR-mu of the frames of `missing`; the clip's gain is that of all frames in the folder."""
    out = folder / "scores.json"
    run(hdrcam, "compare", clip, folder, "--json", out)
    values = {frame["frame"]: frame["psnr_mu"] for frame in json.loads(out.read_text())["per_frame"]}
    return statistics.mean(values[frame] for frame in missing if frame in values)
