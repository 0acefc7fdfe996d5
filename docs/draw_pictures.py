#!/usr/bin/env python3
"""Draws the pictures of docs/pictures. Usage: draw_pictures.py [NAME ...], with names of scenes or `contact`.

Without a name it draws all of them. The program is the built one, or the one that LICHTENBERG names. scenes/gallery.py
runs the scenes, some of them shortened. The file TIMES stores the processor time of each run. Pictures are reduced to
the first of COLOURS and WIDTHS that gives less than LARGEST bytes.
"""
import argparse
import datetime
import itertools
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

HOME = Path(__file__).resolve().parents[1]
PICTURES = HOME / "docs/pictures"
TIMES = HOME / "docs/measurements/gallery.json"
COLOURS, WIDTHS, LARGEST = (256, 32), (640, 560), 120_000  # colours, pixels, bytes

sys.path.insert(0, str(HOME / "scenes"))

import gallery  # noqa: E402


def reduce(source, target):
    """Writes a smaller picture. Throws RuntimeError if it has more than LARGEST bytes at each width."""
    from PIL import Image

    picture = Image.open(source).convert("RGB")
    for colours, width in itertools.product(COLOURS, WIDTHS):
        size = (width, round(picture.height * width / picture.width))
        smaller = picture.resize(size, Image.Resampling.LANCZOS)
        smaller.quantize(colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(target, optimize=True)
        if target.stat().st_size < LARGEST:
            return
    raise RuntimeError(f"{target} has {target.stat().st_size} bytes, more than {LARGEST}")


def processor():
    """Returns the name of the processor."""
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor()


def record(times):
    """Writes processor times (s) of all scenes as the measurement of the gallery. `times` has the command and the time."""
    rows = {name: {"scene": name, "command": command, "time (s)": round(seconds, 1)} for name, (command, seconds) in times.items()}
    version = subprocess.run([gallery.PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout
    measurement = {
        "measures": "processor time of a run of each shipped scene with its picture",
        "command": "docs/draw_pictures.py",
        "commit": version.split()[2].strip("()"),
        "machine": f"one core of {processor()}, other load",
        "date": datetime.date.today().isoformat(),
    }
    lines = [f' "{key}": {json.dumps(value, ensure_ascii=False)},' for key, value in measurement.items()]
    lines += [' "rows": [', ",\n".join(f"  {json.dumps(rows[name])}" for name in sorted(rows)), " ]"]
    TIMES.write_text("\n".join(["{", *lines, "}"]) + "\n")


def draw_scene(name, folder):
    """Draws a scene. Returns its command and the processor time (s) of its run and pictures."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = gallery.make(name, folder)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    reduce(folder / f"{name}.png", PICTURES / f"{name}.png")
    return command, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def draw_contact():
    """Draws pairs of conductors with a gap above the contact distance, a smaller gap, and an overlap."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    radius = 1.0
    cases = [(1.5, "gap > contact_distance", "no contact:\ntwo groups, two potentials", ("#d6604d", "#4393c3")),
             (0.6, "0 < gap < contact_distance", "electrical contact:\none group, one potential", ("#9970ab",) * 2),
             (-0.15, "gap < 0: overlap", "electrical contact\nand elastic force", ("#9970ab",) * 2)]
    figure, axes = plt.subplots(1, 3, figsize=(9, 2.9))
    for axis, (gap, condition, meaning, colours) in zip(axes, cases):
        half = radius + gap / 2
        for side, colour in zip((-1, 1), colours):
            axis.add_patch(plt.Circle((side * half, 0), radius, facecolor=colour, edgecolor="black", alpha=0.8))
        if 0 < gap < radius:
            axis.plot([-half, half], [0, 0], color="black", linewidth=2.5)
        if gap > 0:
            axis.annotate("", (-gap / 2, 1.25), (gap / 2, 1.25), arrowprops={"arrowstyle": "<->"})
            axis.text(0, 1.35, "gap", ha="center", va="bottom")
            for side in (-1, 1):
                axis.plot([side * gap / 2] * 2, [0, 1.3], color="grey", linewidth=0.8, linestyle=":")
        axis.annotate("", (-half, 0), (-half - radius, 0), arrowprops={"arrowstyle": "<->"})
        axis.text(-half - radius / 2, 0.08, "$R$", ha="center", va="bottom")
        axis.set(xlim=(-2.9, 2.9), ylim=(-1.2, 1.9), aspect="equal", title=condition)
        axis.set_xlabel(meaning)
        axis.set(xticks=[], yticks=[])
    figure.suptitle("Contact of two conductors; contact_distance is one radius R by default", y=0.98)
    figure.tight_layout()
    figure.savefig(PICTURES / "contact.png", dpi=100)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="scene, or contact")
    chosen = parser.parse_args().names
    names = chosen or ["contact", *(name for name, _ in gallery.rows())]
    times = {}
    os.environ["LICHTENBERG_THREADS"] = "1"
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="lichtenberg-pictures-") as folder:
        for name in names:
            print(name, file=sys.stderr, flush=True)
            if name == "contact":
                draw_contact()
            else:
                times[name] = draw_scene(name, Path(folder))
    if not chosen:  # the measurement has one date, commit and machine
        record(times)
    return 0


if __name__ == "__main__":
    sys.exit(main())
