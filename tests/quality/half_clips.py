"""A clip with ground truth of which every second frame is left out, for pictures between the frames."""
import json
import statistics
import subprocess


def run(*words):
    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


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
