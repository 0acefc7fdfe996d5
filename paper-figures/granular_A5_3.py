#!/usr/bin/python3
"""Figure G A5.3: charge and density of a gas as a fluid, from initially separated charges of either sign; in the plane.
"""

import json
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import figures
from figures import claim, save, save_claims
from gases import parse_arguments


def fields_of(program, cells):
    """Returns the maps of `lichtenberg theory hydrodynamics`: [(title, length, {field: [cells, cells]})]."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flow.json"
        figures.run(program, "theory", "hydrodynamics", "--separated", "--cells", cells, "--json", path)
        answer = json.loads(path.read_text())
    return [(maps["title"], maps["length"], {field["name"]: np.reshape(field["values"], (maps["cells"], maps["cells"]))
                                             for field in maps["fields"]}) for maps in answer["maps"]]


def main():
    arguments = parse_arguments(__doc__)
    pictures = fields_of(arguments.program, 64 if arguments.full else 32)
    figure, grid = plt.subplots(2, len(pictures), figsize=(3.4 * len(pictures), 6), layout="constrained")
    for column, (title, length, fields) in zip(grid.T, pictures):
        for axes, name, words, colours in zip(column, ("charge", "density"), ("charge density", "density"), ("RdBu_r", "viridis")):
            reach = np.abs(fields[name]).max()
            limits = {"vmin": -reach, "vmax": reach} if name == "charge" else {}
            image = axes.imshow(fields[name], origin="lower", extent=(0, length, 0, length), cmap=colours, **limits)
            figure.colorbar(image, ax=axes, shrink=0.8)
            axes.set_title(f"{words}\n{title.replace('t_0', '$t_0$')}", fontsize=7)
            axes.set(xlabel="$x$ ($l_0$)", ylabel="$y$ ($l_0$)")
    save(figure, "granular_A5_3")
    last = pictures[-1][2]
    weak = np.abs(last["charge"]) < np.quantile(np.abs(last["charge"]), 0.25)
    ratio = float(last["density"][weak].mean() / last["density"].mean())
    save_claims("granular_A5_3", [
        claim("density where charge changes sign (a quarter of the cells), over the mean, at the end", "G A5.3",
              "dense there", f"{ratio:.2f}", "agrees" if ratio > 1.05 else "differs",
              "charge goes with the mass: where it is dense there is charge, of one sign; restitution .7, R = .9, one noise: the "
              "source states no parameters")])


if __name__ == "__main__":
    main()
