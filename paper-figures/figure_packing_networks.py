#!/usr/bin/python3
"""Particle-centred and contact-centred resistor network of one packing, as in the source on compressed particles.

Colour shows potential, width shows current. Below, an enlarged detail of both, in which the path through a particle's
centre is longer than necessary."""

import json
import shutil
import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable

from figures import OUTPUT, SOURCE, claim, kept_run, name_for, request, run, save, save_claims

sys.path.insert(0, str(SOURCE / "python"))
from lichtenberg.pictures import network  # used by `lichtenberg network`

RESISTOR = ["--resistor", "length", "--resistance-per-length", "1000"]  # Ohm/m: 1 Ohm per millimetre


def measure(program, result):
    """Returns {model: results of `network`}."""
    found = json.loads(run(program, "network", result, *RESISTOR, "--json", "--no-picture"))
    return {entry["model"]: entry for entry in found["networks"]}


def around_the_middle(net):
    """Returns the surroundings of the particle nearest to the middle."""
    middle = net.position[np.argmin(np.hypot(*(net.position - net.size / 2).T))]
    reach = 3.2 * np.median(net.radius)
    return [(x - reach, x + reach) for x in middle]


def main():
    arguments = request(__doc__, ("--result", "result file of a packing to show in place of scenes/packing.toml's"))
    packing = arguments.result or kept_run(arguments.program, SOURCE / "scenes" / "packing.toml", arguments.results / "packing.h5")
    name = name_for("figure_packing_networks", arguments.result)
    OUTPUT.mkdir(exist_ok=True)
    result = OUTPUT / f"{name}.h5"  # a copy, because the networks are stored in it
    shutil.copyfile(packing, result)
    found = measure(arguments.program, result)

    network.drawing.set_style()
    figure, panels = plt.subplots(2, 2, figsize=(9.5, 9.4), layout="constrained")
    for column, model in enumerate(["particle", "contact"]):
        net = network.read(result, model)
        colours = network.panel(panels[0, column], net)
        network.panel(panels[1, column], net, around_the_middle(net))
        panels[1, column].set_title("enlarged")
    figure.colorbar(ScalarMappable(**colours), ax=panels, fraction=0.03, pad=0.01).set_label("potential (V)")
    save(figure, name)

    ratio = found["particle"]["resistance"] / found["contact"]["resistance"]
    save_claims(name, [claim("particle-centred network resists more than contact-centred", "packings",
                             "seemingly larger resistance", f"{ratio:.3g} times as much",
                             "agrees" if ratio > 1 else "differs")])


if __name__ == "__main__":
    main()
