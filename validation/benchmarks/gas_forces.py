#!/usr/bin/python3
"""Draws the cost of a gas's charge forces against their error, without and with induced dipoles.

    gas_forces.py [--program build/lichtenberg] [--scene scenes/granular-gas.toml]
                  [--polarized scenes/polarized-gas.toml] [--seconds 10] [--folder FOLDER] --out PICTURE
    gas_forces.py --draw FOLDER --out PICTURE

Compares all summation methods. Runs `work-precision` on the scene (with LAMMPS' PPPM if `lmp` is installed) and on the
polarized scene. The latter has as many grains in the same box, so both have equal charges at equal positions. All
methods are compared with the same exact forces. --folder keeps the figures charges.json and dipoles.json; --draw draws
these.
"""
import argparse
import json
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))

from lichtenberg.pictures.drawing import plt, set_style
from lichtenberg.pictures.work_precision import draw_panel

CHARGES = {"mesh": "our mesh, as a run takes it", "mesh-gauss": "with Gauss' splitting", "mesh-splines": "with B-splines",
           "mesh-double": "in double precision", "ewald": "Ewald's sums", "lammps": "LAMMPS' PPPM"}
DIPOLES = {"mesh": "all images, by the mesh", "ewald": "all images, by Ewald's sums",
           "dipoles-mixed-consistent": "mixed, consistent", "dipoles-minimum-image": "nearest images",
           "dipoles-source": "as the source has it"}


def sweep(arguments, folder, name, scene, methods, settings):
    command = [str(arguments.program), "work-precision", str(scene), "--methods", ",".join(methods), "--seconds",
               f"{arguments.seconds:g}", "--json", f"{name}.json", "--output", f"{name}.png", "--overwrite"]
    for key, value in settings.items():
        command += ["--set", f"{key}={value}"]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)


def same_gas(scene):
    """Returns settings that give another gas the grains of this one."""
    with open(scene, "rb") as file:
        text = tomllib.load(file)
    return {"domain.size": text["domain"]["size"], "population.count": text["population"][0]["count"]}


def measure(arguments, folder):
    sweep(arguments, folder, "charges", arguments.scene, CHARGES, {})
    sweep(arguments, folder, "dipoles", arguments.polarized, DIPOLES, same_gas(arguments.scene))


def panel(axes, found, labels, title):
    own = found["reference_errors"]["rms force"]  # errors below that of the reference are not significant
    found["points"] = [point for point in found["points"] if point["errors"]["rms force"] >= own]
    lines = draw_panel(axes, found, "rms force", "seconds")
    axes.legend([lines[name] for name in labels if name in lines], [labels[name] for name in labels if name in lines],
                loc="upper left", bbox_to_anchor=(0, -0.2), ncols=2, frameon=False, fontsize=7)
    axes.set_title(title, fontsize=8)


def draw(folder):
    found = {name: json.loads((folder / f"{name}.json").read_text()) for name in ("charges", "dipoles")}
    set_style()
    plt.rcParams.update({"font.size": 8, "savefig.dpi": 160})
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.5, 4.2), sharex=True, sharey=True, layout="constrained")
    first = found["charges"]
    panel(left, first, CHARGES, "charges alone")
    panel(right, found["dipoles"], DIPOLES, "with the dipoles that they induce")
    left.invert_xaxis()
    left.set_ylabel("time of one core (s)")
    loads = sorted(sweep["load"] for sweep in found.values())
    figure.suptitle(f"{first['title']}; {first['processor']}, load {loads[0]:.0f} to {loads[1]:.0f} on {first['cores']} cores",
                    fontsize=8)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=Path("build/lichtenberg"))
    parser.add_argument("--scene", type=Path, default=Path("scenes/granular-gas.toml"))
    parser.add_argument("--polarized", type=Path, default=Path("scenes/polarized-gas.toml"))
    parser.add_argument("--seconds", type=float, default=10, help="what is expected to take longer is left out")
    parser.add_argument("--folder", type=Path, help="where the figures stay")
    parser.add_argument("--draw", type=Path, help="figures that were kept: nothing is measured")
    parser.add_argument("--out", type=Path, required=True, help="picture to write")
    arguments = parser.parse_args()
    for name in ("program", "scene", "polarized"):
        setattr(arguments, name, getattr(arguments, name).resolve())
    with tempfile.TemporaryDirectory() as name:
        folder = (arguments.draw or arguments.folder or Path(name)).resolve()
        folder.mkdir(exist_ok=True)
        if not arguments.draw:
            measure(arguments, folder)
        draw(folder).savefig(arguments.out)


if __name__ == "__main__":
    main()
