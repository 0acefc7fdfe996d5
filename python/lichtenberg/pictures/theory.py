"""Draws the JSON of `lichtenberg theory`: a panel for each quantity, lines for theory and points for a run, and fields."""
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.ticker import NullFormatter

from .drawing import plt, read_json, save, set_style, with_unit

# Distinguishable by colour-blind people (Okabe & Ito).
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8c8c8c"]
DASHES = ["-", "--", ":", "-."]
FOUND = ["#08519c", "#9ecae1"]


def numbers(values):
    return np.array([np.nan if value is None else value for value in values], float)


def colour_of(labels):
    """Returns one colour per label, in the order of their first use: curves with the same label belong together."""
    return {label: COLOURS[k % len(COLOURS)] for k, label in enumerate(dict.fromkeys(labels))}


def draw_panel(axes, table, panel):
    columns = table["columns"]
    x = numbers(next(iter(columns.values()))["values"])
    colours = colour_of(columns[name]["label"] for one in table["panels"] for name in one["columns"])
    seen = {}
    for k, found in enumerate(f for f in table["found"] if f["of"] in panel["columns"]):
        axes.plot(numbers(found["x"]), numbers(found["y"]), "o", color=FOUND[k % 2], markersize=2.5, label=found["label"])
    for name in panel["columns"]:
        label = columns[name]["label"]
        n = seen[label] = seen.get(label, -1) + 1
        style = {"color": colours[label], "linestyle": DASHES[n % len(DASHES)], "linewidth": 1.2}
        axes.plot(x, numbers(columns[name]["values"]), label=label if n == 0 else None, **style)
    unit = columns[panel["columns"][0]]["unit"]
    axes.set_ylabel(with_unit(panel["label"], unit))
    axes.legend(frameon=False, fontsize=7)
    set_scales(axes, table, panel)


def set_scales(axes, table, panel):
    if table["logarithmic"]:
        axes.set_xscale("log")
    drawn = np.concatenate([line.get_ydata() for line in axes.lines])
    drawn = drawn[np.isfinite(drawn)]
    if panel["logarithmic"] and (drawn > 0).any():
        axes.set_yscale("log")
        lowest = drawn[drawn > 0].min()
        if drawn.max() < 1.2 * lowest:  # a logarithmic axis has no ticks in such a short range
            axes.set_yscale("linear")
        elif drawn.max() > 30 * lowest:
            axes.yaxis.set_minor_formatter(NullFormatter())
    if not panel["logarithmic"] and (drawn < 0).any() and (drawn > 0).any():
        axes.axhline(0, color="#8c8c8c", linewidth=0.6)


def map_colours(field, values):
    """Returns colours of a field: white is 0 if it has a sign; a density or temperature has a logarithmic scale."""
    if field["logarithmic"] and values.min() > 0 and values.max() > 1.2 * values.min():
        return {"cmap": "viridis", "norm": LogNorm(max(values.min(), 1e-6 * values.max()), values.max())}
    if values.min() < 0:
        reach = np.abs(values).max()
        return {"cmap": "RdBu_r", "vmin": -reach, "vmax": reach}
    return {"cmap": "viridis"}


def draw_map(figure, axes, maps, field):
    values = numbers(field["values"]).reshape(maps["cells"], maps["cells"])
    extent = (0, maps["length"], 0, maps["length"])
    image = axes.imshow(values, origin="lower", extent=extent, interpolation="nearest", **map_colours(field, values))
    figure.colorbar(image, ax=axes, shrink=0.85)
    axes.set_title(field["label"], fontsize=8)
    axes.tick_params(labelsize=6)


def draw_maps(figure, all_maps):
    """Draws fields: one row per instant, one column per field."""
    for part, maps in zip(np.atleast_1d(figure.subfigures(len(all_maps), 1)), all_maps):
        part.suptitle(f"{maps['title']}, lengths in $l_0$", fontsize=8)
        grid = part.subplots(1, len(maps["fields"]))
        for axes, field in zip(np.atleast_1d(grid), maps["fields"]):
            draw_map(part, axes, maps, field)


def draw_panels(figure, panels, columns):
    grid = figure.subplots(-(-len(panels) // columns), columns, squeeze=False)
    for axes in grid.flat[len(panels) :]:
        axes.remove()
    for axes, (table, panel) in zip(grid.flat, panels):
        draw_panel(axes, table, panel)
        first = next(iter(table["columns"].values()))
        axes.set_xlabel(with_unit(first["label"], first["unit"]))


def draw(answer):
    set_style()
    panels = [(table, panel) for table in answer["tables"] for panel in table["panels"]]
    columns = 1 if len(panels) < 3 else 2
    heights = [2.7 * -(-len(panels) // columns)] + ([2.5 * len(answer["maps"])] if answer.get("maps") else [])
    figure = plt.figure(figsize=(6 if columns == 1 else 9, 0.8 + sum(heights)), layout="constrained")
    parts = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    draw_panels(parts[0], panels, columns)
    if answer.get("maps"):
        draw_maps(parts[1], answer["maps"])
    figure.suptitle(f"{answer['title']}\nof {answer['of']}", fontsize=9)
    return figure


def draw_file(path, out):
    save(draw(read_json(path)), out)
