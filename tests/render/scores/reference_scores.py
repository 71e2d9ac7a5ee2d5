#!/usr/bin/python3
"""reference_scores.py CLIP OUT [SKIP]: the scores of render/scores/ a second time, in numpy and OpenCV.

The expected numbers of scores_test.cpp come from here. Needs Debian's python3-opencv; not run by the test suite:
    HDRCAM_KEEP_CLIP=/tmp/clip hdrcam_tests '[keep-clip]' && reference_scores.py /tmp/clip /tmp/clip/out
"""
import json
import os
import sys

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
try:
    import cv2
    import numpy as np
except ImportError as missing:
    sys.exit(f"reference_scores.py: {missing}; it needs Debian's python3-opencv")

LUMINANCE_BGR = np.array([0.0722, 0.7152, 0.2126], np.float32)
PU21 = [0.353487901, 0.3734658629, 8.277049286e-05, 0.9062562627, 0.09150303166, 0.9099517204, 596.3148142]


def picture(path):
    return np.nan_to_num(cv2.imread(path, cv2.IMREAD_UNCHANGED).astype(np.float32), nan=0, posinf=6e4, neginf=0)


def mu_law(x):
    return np.log1p(5000 * x) / np.log(5001.0)


def pu21(luminance):
    y = np.clip(luminance, 0.005, 10000) ** PU21[3]
    return PU21[6] * (((PU21[0] + PU21[1] * y) / (1 + PU21[2] * y)) ** PU21[4] - PU21[5])


def decibel(error):
    return float(-10 * np.log10(max(np.mean(error**2), 1e-12)))


def ssim(a, b):
    blur = lambda m: cv2.GaussianBlur(m, (11, 11), 1.5)
    mean_a, mean_b = blur(a), blur(b)
    var_a, var_b, cov = blur(a * a) - mean_a**2, blur(b * b) - mean_b**2, blur(a * b) - mean_a * mean_b
    return float((((2 * mean_a * mean_b + 1e-4) * (2 * cov + 9e-4))
                  / ((mean_a**2 + mean_b**2 + 1e-4) * (var_a + var_b + 9e-4))).mean())


def log2(luminance):
    return np.log2(np.maximum(luminance, 2.0**-14))


def well_exposed_gain(truth, estimate, white, channel):
    ratios = []
    for g, e in zip(truth.values(), estimate.values()):
        g, e = g[..., channel].ravel()[::11], e[..., channel].ravel()[::11]
        used = (g > white * 0.004) & (g < white * 0.6) & (e > 0)
        ratios.append(np.log(g[used] / e[used]))
    return float(np.exp(np.median(np.concatenate(ratios))))


def flicker(flow, before, now):
    """|d log2 E - d log2 G| along the flow, and where it is comparable."""
    rows, cols = flow.shape[:2]
    x, y = np.meshgrid(np.arange(cols, dtype=np.float32), np.arange(rows, dtype=np.float32))
    to_x, to_y = x + flow[..., 2], y + flow[..., 1]
    seen = (flow[..., 0] < 0.5) & (to_x >= 0) & (to_y >= 0) & (to_x <= cols - 1) & (to_y <= rows - 1)
    change = lambda a, b: cv2.remap(b.astype(np.float32), to_x, to_y, cv2.INTER_LINEAR) - a.astype(np.float32)
    return np.abs(change(before["e"], now["e"]) - change(before["g"], now["g"])), seen


def scores(clip, out, skip=1):
    facts, answers = json.load(open(f"{clip}/clip.json")), json.load(open(f"{clip}/gt/gt.json"))
    found = {int(name[:-4]): f"{out}/{name}" for name in os.listdir(out) if name.endswith(".exr")}
    frames = [i for i in range(skip, len(facts["frames"]) - skip) if i in found]
    truth = {i: picture(f"{clip}/gt/hdr/{i:04d}.exr") for i in frames}
    estimate = {i: picture(found[i]) for i in frames}
    brightest = np.concatenate([g.max(2).ravel()[::7] for g in truth.values()])
    white = float(min(np.percentile(brightest, 99.9), answers["r_sat_shortest"]))
    gain = np.array([well_exposed_gain(truth, estimate, white, c) for c in range(3)], np.float32)
    kept = {k: [] for k in ("psnr_mu psnr_l psnr_pu ssim_mu log_rmse flicker flick_bg psnr_mu_mov").split()}
    bias, before = {}, None
    for i in frames:
        g, e = np.clip(truth[i], 0, white) / white, np.clip(estimate[i] * gain, 0, white) / white
        error = mu_law(g) - mu_law(e)
        kept["psnr_mu"].append(decibel(error))
        kept["psnr_l"].append(decibel(g - e))
        kept["psnr_pu"].append(decibel((pu21(g * 4000.0) - pu21(e * 4000.0)) / pu21(4000.0)))
        gl, el = g @ LUMINANCE_BGR, e @ LUMINANCE_BGR
        kept["ssim_mu"].append(ssim(mu_law(gl).astype(float), mu_law(el).astype(float)))
        now = {"i": i, "g": log2(gl), "e": log2(el)}
        kept["log_rmse"].append(float(np.sqrt(((now["e"] - now["g"]) ** 2).mean())))
        frame = facts["frames"][i]
        exposure = frame["exposure_s"] * frame.get("gain", 1) * frame.get("digital_gain", 1)
        bias.setdefault(round(np.log2(exposure) * 2), []).append((now["e"] - now["g"]).mean())
        now["moving"] = np.isin(cv2.imread(f"{clip}/gt/id/{i:04d}.png", 0), answers["moving_ids"])
        if now["moving"].any():
            kept["psnr_mu_mov"].append(decibel(error[now["moving"]]))
        if before and before["i"] == i - 1:
            change, seen = flicker(picture(f"{clip}/gt/flow/{i - 1:04d}.exr"), before, now)
            kept["flicker"].append(change[seen].mean())
            kept["flick_bg"].append(change[seen & ~before["moving"]].mean())
        before = now
    result = {name: float(np.mean(values)) for name, values in kept.items()}
    result.update(phase=float(np.std([np.mean(b) for b in bias.values()])), worst_psnr_mu=min(kept["psnr_mu"]),
                  N=white, gain=[float(v) for v in gain[::-1]], frames=len(frames))
    return result


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4) or not all(skip.isdigit() for skip in sys.argv[3:]):
        sys.exit(__doc__)
    for name, value in scores(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 1).items():
        print(name, value)
