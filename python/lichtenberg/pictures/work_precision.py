"""Draws the measurements of `lichtenberg work-precision`: error against time, a line for each method.

A line joins the points of a method that are cheaper than all its more accurate ones; the others are faint.
"""
import textwrap
from pathlib import Path

from matplotlib.ticker import LogFormatterSciNotation

from .drawing import INK, plt, read_json, save, set_style

# Distinguishable by colour-blind people (Okabe & Ito); the line style of a method is that of its family.
STYLES = {
    "cut-cell": ("#0072b2", "o-"),
    "cut-cell-plain": ("#56b4e9", "o--"),
    "cut-cell-gamg": ("#e69f00", "s-"),
    "cut-cell-boomeramg": ("#d55e00", "s-"),
    "cut-cell-cholmod": ("#8c5a2b", "s-"),
    "cut-cell-aperture": ("#cc79a7", "s--"),
    "cut-cell-cuda": ("#009e73", "D-"),
    "cut-cell-gamg-cuda": ("#6fbf9a", "D--"),
    "relaxation": ("#8c8c8c", "^-"),
    "multipole": (INK, "*-"),
    "spheres": (INK, "*-"),
    "spheres-degree": ("#0072b2", "o-"),
    "freefem": ("#d55e00", "s-"),
    "split": ("#0072b2", "o-"),
    "monolithic": ("#e69f00", "s-"),
    "euler": ("#8c8c8c", "^-"),
    "mesh": ("#0072b2", "o-"),
    "mesh-gauss": ("#0072b2", "o--"),
    "mesh-splines": ("#999933", "v-"),
    "mesh-splines-gauss": ("#999933", "v--"),
    "mesh-double": ("#56b4e9", "o-"),
    "mesh-double-gauss": ("#56b4e9", "o--"),
    "mesh-cuda": ("#009e73", "D-"),
    "lammps": ("#d55e00", "s-"),
    "dipoles-ewald": ("#e69f00", "D-"),
    "dipoles-mixed-consistent": ("#009e73", "D-"),
    "dipoles-minimum-image": ("#8c8c8c", "D--"),
    "dipoles-source": ("#cc79a7", "D--"),
    "accuracy": ("#56b4e9", "*-"),
    "multirate-charges": ("#009e73", "D-"),
    "multirate-forces": ("#cc79a7", "D-"),
    "ewald": ("#e69f00", "s-"),
    "minimum-image": ("#8c8c8c", "^-"),
    "shifted-force": ("#cc79a7", "^-"),
    "multirate": (INK, "*-"),
    "multirate-cuda": ("#009e73", "*-"),
    "verlet": ("#0072b2", "o-"),
    "gear": ("#e69f00", "s-"),
    "gear-printed": ("#d55e00", "s--"),
}
OTHER = ("#f0e442", "v-")

# Axis labels of quantities that are statistics of errors.
ERRORS = {"rms force": "rms error of forces", "largest force": "largest error of a force"}


def front(points):
    """Returns the pairs (error, cost) for which no other pair is better in both, in ascending order of error."""
    best = []
    for error, cost in sorted(points):
        if not best or cost < best[-1][1]:
            best.append((error, cost))
    return best


def draw_method(axes, name, points):
    colour, style = STYLES.get(name, OTHER)
    size = 7 if "*" in style else 4
    chosen = front(points)
    rest = [point for point in points if point not in chosen]
    if rest:
        axes.plot(*zip(*rest), style[0], color=colour, alpha=0.25, markersize=size - 1, markeredgewidth=0)
    return axes.plot(*zip(*chosen), style, color=colour, markersize=size, linewidth=1.2, label=name)[0]


def draw_panel(axes, sweep, quantity, cost):
    """Returns the drawn lines, by method."""
    lines = {}
    for name in sweep["methods"]:
        points = [
            (point["errors"][quantity], point[cost])
            for point in sweep["points"]
            if point["method"] == name and point["errors"][quantity] > 0 and point[cost] > 0
        ]
        if points:
            lines[name] = draw_method(axes, name, points)
    axes.set(xscale="log", yscale="log", xlabel=ERRORS.get(quantity, f"error of the {quantity}"))
    axes.grid(True, which="major", linewidth=0.3)
    # Axes of less than two decades have more ticks.
    axes.yaxis.set_minor_formatter(LogFormatterSciNotation(minor_thresholds=(2, 0.5)))
    axes.tick_params(which="minor", length=0)
    return lines


def panels(sweep):
    """Returns the axes of the panels: one for each quantity, or one quantity against both costs."""
    quantities = list(sweep["reference_errors"])
    if len(quantities) > 1:
        return [(quantity, "seconds") for quantity in quantities]
    return [(quantities[0], "seconds"), (quantities[0], "work")]


def footnote(sweep):
    cores = f"{sweep['cores']} core{'s' if sweep['cores'] > 1 else ''}"
    return (
        f"{Path(sweep['scene']).name}: {sweep['title']}. Errors: {sweep['errors']}. Reference: {sweep['reference']}. "
        f"{sweep['processor']}, {cores}, load {sweep['load']:.1f}; {sweep['versions']}."
    )


def draw(sweep):
    """Draws the whole picture as a figure."""
    set_style()
    plt.rcParams.update({"font.size": 8, "savefig.dpi": 160})
    wanted = panels(sweep)
    labels = {"seconds": "time (s)", "work": sweep["work"]}
    same_cost = len({cost for _, cost in wanted}) == 1
    size, widths = (2.5 * len(wanted) + 1.5, 3.2), [1] * len(wanted) + [0.45]
    figure, (*row, legend) = plt.subplots(
        1, len(widths), figsize=size, width_ratios=widths, layout="constrained", gridspec_kw={"wspace": 0.03}
    )
    lines = {}
    for axes in row[1:]:
        axes.sharex(row[0])
        if same_cost:
            axes.sharey(row[0])
    for axes, (quantity, cost) in zip(row, wanted):
        lines.update(draw_panel(axes, sweep, quantity, cost))
        if same_cost and axes is not row[0]:
            axes.tick_params(which="both", labelleft=False)
        else:
            axes.set_ylabel(labels[cost])
    row[0].invert_xaxis()  # also sets all axes that share it
    legend.axis("off")
    handles = [lines[name] for name in sweep["methods"] if name in lines]
    legend.legend(handles=handles, loc="upper left", frameon=False, borderaxespad=0)
    figure.supxlabel("\n".join(textwrap.wrap(footnote(sweep), 55 * len(wanted))), fontsize=6, x=0.01, ha="left")
    return figure


def draw_file(path, out):
    save(draw(read_json(path)), out)
