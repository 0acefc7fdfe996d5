#!/usr/bin/env python3
"""The particle-centred and the contact-centred resistor network of one packing, as in the source on compressed
particles; colour is potential, width is current. Below, a piece of both, enlarged: where the path through a particle's
centre is a detour."""

import argparse
import json
import shutil
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable

from figures import OUTPUT, SOURCE, claim, run, save, save_claims

sys.path.insert(0, str(SOURCE / "src" / "commands"))
import network  # noqa: E402  the pictures of `lichtenberg network`

NAME = "figure_packing_networks"
RESISTOR = ["--resistor", "length", "--resistance-per-length", "1000"]  # Ohm/m: 1 Ohm a millimetre


def packing(build):
    """The result file of scenes/packing.toml, run once."""
    result = OUTPUT / "packing.h5"
    if not result.exists():
        OUTPUT.mkdir(exist_ok=True)
        run(build / "lichtenberg", "run", SOURCE / "scenes" / "packing.toml", "--out", result)
    return result


def measure(build, result):
    """model -> what `network` finds."""
    found = json.loads(run(build / "lichtenberg", "network", result, *RESISTOR, "--json", "--no-picture"))
    return {entry["model"]: entry for entry in found["networks"]}


def around_the_middle(net):
    """The surroundings of the particle nearest to the middle."""
    middle = net.position[np.argmin(np.hypot(*(net.position - net.size / 2).T))]
    reach = 3.2 * np.median(net.radius)
    return [(x - reach, x + reach) for x in middle]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=Path, default=SOURCE / "build", help="folder of the built programs")
    parser.add_argument("--result", type=Path, help="result file of a packing to show in place of scenes/packing.toml's")
    request = parser.parse_args()
    build = request.build.resolve()
    OUTPUT.mkdir(exist_ok=True)
    result = OUTPUT / f"{NAME}.h5"  # a copy: the networks are kept in it
    shutil.copyfile(request.result or packing(build), result)
    found = measure(build, result)

    network.plot.set_style()
    figure, panels = plt.subplots(2, 2, figsize=(9.5, 9.4), layout="constrained")
    for column, model in enumerate(["particle", "contact"]):
        net = network.read(result, model)
        colours = network.panel(panels[0, column], net)
        network.panel(panels[1, column], net, around_the_middle(net))
        panels[1, column].set_title("enlarged")
    figure.colorbar(ScalarMappable(**colours), ax=panels, fraction=0.03, pad=0.01).set_label("potential (V)")
    save(figure, NAME)

    ratio = found["particle"]["resistance"] / found["contact"]["resistance"]
    save_claims(NAME, [claim("particle-centred network resists more than contact-centred", "packings",
                             "seemingly larger resistance", f"{ratio:.3g} times as much",
                             "agrees" if ratio > 1 else "DIFFERS")])


if __name__ == "__main__":
    main()
