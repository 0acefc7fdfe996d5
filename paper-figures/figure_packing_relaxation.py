#!/usr/bin/python3
"""Relaxation of scenes/packing.toml: four frames, and energy and largest force against iterations of every method.

The source shows it as a film, by gradient descent.
"""

import sys

import h5py
import matplotlib.pyplot as plt

from figures import SOURCE, kept_run, request, save

sys.path.insert(0, str(SOURCE / "python"))
from lichtenberg.pictures import drawing, packing  # used by `lichtenberg plot`

METHODS = {"gradient-descent": "#1a1a1a", "fire": "#d55e00", "lbfgs": "#0c7bdc", "lbfgs-newton": "#009e73"}
SHOWN = [0, 128, 2048]  # iterations of gradient descent; the last frame is added


def result_of(arguments, method):
    """Returns the result file of the scene by this method; runs the scene if it does not exist."""
    arguments.results.mkdir(parents=True, exist_ok=True)
    scene = arguments.results / f"packing-{method}.toml"
    text = (SOURCE / "scenes" / "packing.toml").read_text()
    scene.write_text(text.replace("[minimize]", f'[output]\npicture = false\n\n[minimize]\nmethod = "{method}"'))
    return kept_run(arguments.program, scene, scene.with_suffix(".h5"))


def frames(path):
    """Returns the indices of the frames to show."""
    with h5py.File(path) as file:
        times = list(file["particles/conductors/position/time"][()])
    return [times.index(iteration) for iteration in SHOWN] + [None]


def draw_history(axes, results):
    energy_axes, force_axes = axes
    for method, path in results.items():
        with h5py.File(path) as file:
            history = file["relaxation"]
            iteration = history["iteration"][()]
            unit = file["summary/largest_force"][()] / file["summary/relative_largest_force"][()]
            energy, force = history["energy"][()], history["largest_force"][()] / unit
        style = {"color": METHODS[method], "linewidth": 1, "label": method}
        energy_axes.plot(iteration[1:], energy[1:] * 1e6, **style)
        force_axes.plot(iteration[1:], force[1:], **style)
    energy_axes.set(xscale="log", yscale="log", xlabel="iteration", ylabel=r"energy ($\mu$J; $k$ = 1 $\mu$J)")
    force_axes.set(xscale="log", yscale="log", xlabel="iteration", ylabel="largest net force ($k/R$)")
    force_axes.legend(frameon=False, fontsize=8)


def main():
    arguments = request(__doc__.splitlines()[0])
    results = {method: result_of(arguments, method) for method in METHODS}
    drawing.set_style()
    figure = plt.figure(figsize=(10, 6), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=[1, 1.3])
    descent = results["gradient-descent"]
    for axes, frame in zip(above.subplots(1, 4), frames(descent)):
        with h5py.File(descent) as file:
            shown = packing.DrawnPacking(file, frame)
        packing.draw_panel(axes, shown)
        axes.set_title(f"iteration {shown.iteration}", fontsize=9)
    draw_history(below.subplots(1, 2), results)
    save(figure, "figure_packing_relaxation")


if __name__ == "__main__":
    main()
