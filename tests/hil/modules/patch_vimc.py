#!/usr/bin/env python3
"""patch_vimc.py vimc-sensor.c: gives the kernel's virtual sensor the controls of a real one.

EXPOSURE (lines) and ANALOGUE_GAIN (sixteenths) act on the picture at once; VBLANK, HBLANK and PIXEL_RATE are there to be
read, and say that a line of 640 pixels lasts 31.7 us.
"""
import sys

SCALE = """	tpg_fill_plane_buffer(&vsensor->tpg, 0, 0, vsensor->frame);
	{	/* 1000 lines at gain 16/16 leave the pattern as it is */
		const struct vimc_pix_map *v = vimc_pix_map_by_code(vsensor->mbus_format.code);
		u32 n = vsensor->mbus_format.width * vsensor->mbus_format.height, i;
		u32 k = READ_ONCE(vsensor->exposure) * READ_ONCE(vsensor->again) * 16 / 1000; /* 8.8 fixed point */

		if (v && v->bpp == 2) {
			u16 *q = (u16 *)vsensor->frame;
			u32 top = (v->pixelformat == V4L2_PIX_FMT_SBGGR12 || v->pixelformat == V4L2_PIX_FMT_SGBRG12 ||
				   v->pixelformat == V4L2_PIX_FMT_SGRBG12 || v->pixelformat == V4L2_PIX_FMT_SRGGB12) ?
					  4095 : 1023;

			for (i = 0; i < n; i++)
				q[i] = min_t(u32, (q[i] * k) >> 8, top);
		} else if (v) {
			for (i = 0; i < n * v->bpp; i++)
				vsensor->frame[i] = min_t(u32, (vsensor->frame[i] * k) >> 8, 255);
		}
	}
"""
SET = """	case V4L2_CID_EXPOSURE:
		vsensor->exposure = ctrl->val;
		break;
	case V4L2_CID_ANALOGUE_GAIN:
		vsensor->again = ctrl->val;
		break;
	case V4L2_CID_VBLANK:
		break;
	case VIMC_CID_OSD_TEXT_MODE:
"""
NEW = """	v4l2_ctrl_handler_init(&vsensor->hdl, 12);
	vsensor->exposure = 1000;
	vsensor->again = 16;
	v4l2_ctrl_new_std(&vsensor->hdl, &vimc_sensor_ctrl_ops, V4L2_CID_EXPOSURE, 1, 4000, 1, 1000);
	v4l2_ctrl_new_std(&vsensor->hdl, &vimc_sensor_ctrl_ops, V4L2_CID_ANALOGUE_GAIN, 16, 256, 1, 16);
	v4l2_ctrl_new_std(&vsensor->hdl, &vimc_sensor_ctrl_ops, V4L2_CID_VBLANK, 4, 4000, 1, 45);
	v4l2_ctrl_new_std(&vsensor->hdl, NULL, V4L2_CID_HBLANK, 160, 160, 1, 160);
	v4l2_ctrl_new_std(&vsensor->hdl, NULL, V4L2_CID_PIXEL_RATE, 25200000, 25200000, 1, 25200000);
"""
EDITS = [
    ("	u64 start_stream_ts;\n", "	u64 start_stream_ts;\n	u32 exposure, again;\n"),
    ("	tpg_fill_plane_buffer(&vsensor->tpg, 0, 0, vsensor->frame);\n", SCALE),
    ("	case VIMC_CID_OSD_TEXT_MODE:\n", SET),
    ("	v4l2_ctrl_handler_init(&vsensor->hdl, 4);\n", NEW),
]


def main(path):
    with open(path) as file:
        text = file.read()
    for old, new in EDITS:
        assert old in text, f"this kernel's vimc differs: no {old!r}"
        text = text.replace(old, new, 1)
    with open(path, "w") as file:
        file.write(text)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
