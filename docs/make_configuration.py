#!/usr/bin/env python3
"""make_configuration.py HDRCAM: rewrites the tables of docs/configuration.md from what the program prints (--print-config).
A test compares the page with the program."""
import pathlib
import re
import subprocess
import sys

if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
    sys.exit(__doc__)

root = pathlib.Path(__file__).resolve().parent.parent
titles = {"camera": "Camera", "schedule": "Schedule", "sync": "Sync and trigger lines", "fit": "Fit", "knobs": "Knobs",
          "output": "Output", "video": "Video", "record": "Recording", "machine": "Machine"}
source = "".join((root / "firmware_host" / name).read_text()
                 for name in ("settings/setting_fields.cpp", "sinks/sink_table.cpp"))


def printed(*flags):
    try:
        return subprocess.run([sys.argv[1], "live", "--print-config", *flags], capture_output=True, text=True,
                              check=True).stdout
    except (OSError, subprocess.CalledProcessError) as failed:
        sys.exit(f"make_configuration.py: '{sys.argv[1]}' prints no settings: {failed}")


def knobs_of(preset):
    """name -> value, of the commented lines."""
    return dict(re.findall(r'^#([\w.]+) = "(.*)"$', printed("--preset", preset), re.M))


def flag_of(table, name):
    found = re.search(rf'"{table}\.{name}",\s*"(-[^"]*)"', source)
    if not found:
        found = re.search(rf'{{"{name}", "(-[^"]*)"', source)
    if not found:  # a name that has a constant
        found = re.search(rf'::k{name.capitalize()},\s*"(-[^"]*)"', source)
    return found[1]


def knob_row(name, about, presets):
    gives, rest = about.removesuffix('; "": as the preset has it)').split("; costs: ", 1)
    costs, takes = rest.rsplit(" (", 1)
    return f"| `{name}` | {' | '.join(values[name] for values in presets)} | {takes} | {gives} | {costs} |\n"


def tables():
    presets = [knobs_of(preset) for preset in ("realtime", "fast", "balanced", "best")]
    text, table, about = "", "", ""
    for line in printed().splitlines():
        if line.startswith("["):
            table = line.strip("[]")
            text += f"{'' if not text else chr(10)}## {titles[table]}\n\n"
            if table == "knobs":
                text += ("The knobs for `--set NAME=VALUE` and `[knobs]` (`online/knobs.h`), with each preset's values.\n\n"
                         "| name | realtime | fast | balanced | best | takes | gives | costs |\n|---|---|---|---|---|---|---|---|\n")
            else:
                text += "| key | flag | default | meaning |\n|---|---|---|---|\n"
        elif line.startswith("# "):
            about = line[2:]
        elif line.startswith("#"):
            text += knob_row(line[1:].split(" = ")[0], about, presets)
        elif line:
            name, value = line.split(" = ", 1)
            value = value.strip('"')
            shown = f"`{value}`" if value else ""
            text += f"| `{table}.{name}` | `{flag_of(table, name)}` | {shown} | {about} |\n"
    return text


page = root / "docs" / "configuration.md"
before = page.read_text()
page.write_text(before[:before.index("## Camera")] + tables())
