"""Draws observables of results over time, or the table of an ensemble.

Curves of several runs share axes; each run has a colour. Members of an ensemble have a colour for each variant, and the mean
over its seeds is a thick line.
"""
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import LogLocator, MaxNLocator

from ..result import text_of, unit_of, warnings_of
from . import drawing
from .drawing import InputError, with_unit

# Distinguishable by colour-blind people (Okabe & Ito).
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c8c8c"]
DASHES = ["-", "--", ":", "-."]
THEORY = "#404040"
MOST_RUNS = 200  # curves of an ensemble


@dataclass
class Panel:
    label: str
    columns: list  # [(name, label)]
    theory: tuple = ("", "")  # name and label of the curve that theory expects
    logarithmic: bool = False


@dataclass
class RunSeries:
    """Observables of a run over time."""

    name: str
    title: str
    unit_of_time: str
    panels: list  # default panels
    columns: dict = field(default_factory=dict)  # name -> (time, values, unit)
    logarithmic: bool = False  # whether the time axis is logarithmic
    start: float = 0.0  # origin of the shown time
    words_of_time: str = "time"
    warning: str = ""

    def column(self, name):
        if name not in self.columns:
            raise InputError(f"{self.name} has not recorded {name}: it has {', '.join(sorted(self.columns))}")
        time, values, unit = self.columns[name]
        return time - self.start, values, unit


def read(path):
    return drawing.read_file(path, lambda file: series_in(file, path))


def series_in(file, path):
    """Throws InputError."""
    drawing.frame_index(file, path, None)
    run = RunSeries(Path(path).stem, file["scene"].attrs["title"], "s", [])
    run.warning = drawing.warning_line(warnings_of(file))
    add_observables(file, run)
    add_group(file, run, "analysis")
    if "gas" in file:
        add_gas(file, run)
    elif "relaxation" in file or "observables/size_x" in file:
        add_packing(file, run)
    else:
        add_conductors(file, run)
    return run


def add_observables(file, run):
    for name, group in file.get("observables", {}).items():
        value = group["value"][()]
        if value.ndim == 1:
            run.columns[name] = group["time"][()], value.astype(float), unit_of(group["value"])
            continue
        labels = group["value"].attrs.get("terminals", group.attrs.get("terminals", range(value.shape[1])))
        for k, label in enumerate(labels):
            run.columns[f"{name}:{text_of(label)}"] = group["time"][()], value[:, k].astype(float), unit_of(group["value"])


def add_group(file, run, name, argument="time"):
    group = file.get(name, {})
    if argument not in group:
        return
    time = group[argument][()].astype(float)
    for column, data in group.items():
        if column != argument and data.ndim == 1 and len(data) == len(time):
            run.columns.setdefault(column, (time, data[()].astype(float), unit_of(data)))


def add_gas(file, run):
    for name in list(file["gas"]):
        run.columns.pop(name, None)  # it has ten rows a frame
    add_group(file, run, "gas")
    run.unit_of_time, run.logarithmic = "t0", True
    scene = tomllib.loads(text_of(file["scene/text"][()]))
    stages = scene.get("equilibration") or scene.get("stage", [])  # its name in earlier versions
    warm_up = sum(stage.get("duration", 0) for stage in stages if stage.get("elastic", True))
    if file["gas/time"][-1] > warm_up > 0:
        run.start, run.words_of_time = warm_up, f"time after the warm-up of {warm_up:g}"
    line = ("haff_temperature", "homogeneous and neutral, restitution of the contacts")
    columns = [("temperature", "with the flow"), ("local_temperature", "relative to it")]
    run.panels.append(Panel("temperature", columns, line, True))
    if np.ptp(file["gas/mean_square_charge"]) > 0:
        line = ("expected_square_charge", "homogeneous, two at a time")
        run.panels.append(Panel("⟨q²⟩", [("mean_square_charge", "grains")], line, True))
    clusters = [("mean_aggregate", "grains in contact: mean of two and more"), ("density_cluster_size", "dense cells: S")]
    run.panels.append(Panel("size of clusters", clusters, logarithmic=True))


def add_packing(file, run):
    if "observables/size_x" in file:  # a packing with loads
        run.unit_of_time, run.words_of_time = "1", "load"
        labels = {"pressure": "pressure", "packing_fraction": "packing fraction", "backbone_coordination": "contacts"}
        run.panels += [Panel(label, [(name, "")]) for name, label in labels.items()]
        return
    add_group(file, run, "relaxation", "iteration")
    for name in ("energy", "largest_force"):
        if name in file["relaxation"]:
            data = file["relaxation"][name]
            run.columns[name] = file["relaxation/iteration"][()].astype(float), data[()], unit_of(data)
    run.unit_of_time, run.words_of_time = "1", "iteration"
    for name, label in [("energy", "energy"), ("largest_force", "largest net force")]:
        run.panels.append(Panel(label, [(name, "")], logarithmic=True))


def add_conductors(file, run):
    suggested = [
        Panel("energy of the field", [("energy", "")]),
        Panel("charge on the conductors", [("charge_held", "")]),
        Panel("connected to an electrode", [("connected", "")]),
        Panel("conductors of the tree", [("endpoints", "endpoints"), ("branch_points", "branch points")]),
        Panel("power", [("supplied_power", "supplied"), ("dissipated_power", "dissipated")]),
        Panel("kinetic energy", [("energy_kinetic", "")]),
    ]
    for panel in suggested:
        panel.columns = [(name, label) for name, label in panel.columns if varies(run, name)]
    run.panels = [panel for panel in suggested if panel.columns]


def varies(run, name):
    values = run.columns.get(name, (0, np.zeros(1), ""))[1]
    values = values[np.isfinite(values)]
    return len(values) > 1 and np.ptp(values) > 0


def points_of(run, name, logarithmic):
    """Returns the times and values that can be shown: finite, and positive on logarithmic axes."""
    time, values, _ = run.column(name)
    shown = np.isfinite(values)
    if run.logarithmic:
        shown &= time > 0
    if logarithmic:
        shown &= values > 0
    return time[shown], values[shown]


def set_scale(axes, logarithmic):
    """Sets a logarithmic axis if the values span more than a factor of three; with less, its ticks would not be
    round numbers."""
    drawn = [line.get_ydata() for line in axes.lines if len(line.get_ydata()) > 2]
    shown = np.concatenate(drawn) if drawn else np.ones(1)
    shown = shown[np.isfinite(shown)]
    if not logarithmic or len(shown) == 0 or shown.min() <= 0 or shown.max() <= 3 * shown.min():
        axes.ticklabel_format(axis="y", scilimits=(-3, 4), useOffset=False)
        return
    axes.set_yscale("log")
    if shown.max() < 30 * shown.min():  # less than 1.5 powers of ten need more ticks
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter("")


def new_figure(count, title):
    drawing.set_style()
    columns = 1 if count <= 3 else 2
    rows = -(-count // columns)
    size = (6.2 if columns == 1 else 9.6, 0.9 + 2.2 * rows)
    figure, grid = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False)
    for axes in grid.flat[count:]:
        axes.remove()
    figure.suptitle(title, fontsize=10, parse_math=False)
    return figure, list(grid.flat[:count])


def plain_panel(name, run):
    return Panel(name.replace("_", " "), [(name, "")], logarithmic=run.logarithmic)


def panels_of(runs, names):
    """Returns the panels of these names, or those that the first run suggests and all runs have."""
    if names:
        for run in runs:
            for name in names:
                run.column(name)
        return [plain_panel(name, runs[0]) for name in names]
    panels = [p for p in runs[0].panels if all(name in run.columns for run in runs for name, _ in p.columns)]
    if not panels:
        names = " and ".join(run.name for run in runs)
        raise InputError(f"there is no time series that {names} recorded{' in common' if len(runs) > 1 else ''}")
    return panels


def draw_panel(axes, panel, runs, groups):
    """Draws curves. `groups`: for each run its colour, and whether its curve represents others."""
    several = len(set(groups)) > 1 or len(runs) > 1
    for k, (name, label) in enumerate(panel.columns):
        for run, group in zip(runs, groups):
            time, values = points_of(run, name, panel.logarithmic)
            colour = COLOURS[(group if several else k) % len(COLOURS)]
            style = {"color": colour, "linestyle": DASHES[k % 4] if several else "-", "linewidth": 1.1}
            marker = {"marker": "o", "markersize": 2.5} if len(values) <= 40 else {}
            axes.plot(time, values, label=label if run is runs[0] and label and len(values) else None, **style, **marker)
    name, label = panel.theory
    if name in runs[0].columns and len(runs) == 1:
        style = {"color": THEORY, "linewidth": 1, "linestyle": "--", "label": label, "zorder": 1}
        axes.plot(*points_of(runs[0], name, panel.logarithmic), **style)
    finish(axes, panel, runs[0])


def finish(axes, panel, run):
    axes.set_ylabel(with_unit(panel.label, run.column(panel.columns[0][0])[2]))
    if run.logarithmic and any((line.get_xdata() > 0).any() for line in axes.lines if len(line.get_xdata())):
        axes.set_xscale("log")
    set_scale(axes, panel.logarithmic)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(frameon=False, fontsize=7)
    axes.set_xlabel(with_unit(run.words_of_time, run.unit_of_time))
    axes.tick_params(labelsize=8)


def draw_runs(runs, names):
    panels = panels_of(runs, names)
    titles = list(dict.fromkeys(run.title for run in runs if run.title))
    title = titles[0] if len(titles) == 1 else " and ".join(titles)
    figure, grid = new_figure(len(panels), with_warnings(title, runs))
    for axes, panel in zip(grid, panels):
        draw_panel(axes, panel, runs, list(range(len(runs))))
    if len(runs) > 1:
        draw_names(figure, [run.name for run in runs])
    return figure


def with_warnings(title, runs):
    """Returns the title and the results' warnings below it, with their names if there are several."""
    lines = [f"{run.name}: {run.warning}" if len(runs) > 1 else run.warning for run in runs if run.warning]
    return "\n".join([title, *lines])


def draw_names(figure, names, more=""):
    """Draws the legend of colours and names below the panels."""
    lines = [plt.Line2D([], [], color=COLOURS[k % len(COLOURS)], linewidth=2, label=name.replace("$", r"\$")) for k, name in enumerate(names)]
    if more:
        lines.append(plt.Line2D([], [], color="#505050", linewidth=2.4, label=more))
    columns = min(3, len(lines))
    height = 0.22 * -(-len(lines) // columns) / figure.get_size_inches()[1]
    figure.get_layout_engine().set(rect=(0, height, 1, 1 - height))
    figure.legend(handles=lines, loc="lower center", ncols=columns, frameon=False, fontsize=8)


def read_table(path):
    """Returns the table of an ensemble from its folder, or from the file itself. Throws InputError."""
    path = Path(path) / "ensemble.json" if Path(path).is_dir() else Path(path)
    if not path.exists():
        raise InputError(f"there is no {path}, the table of an ensemble: name a result file or the folder of an ensemble")
    table = drawing.read_json(path)
    if not isinstance(table, dict) or "members" not in table or "points" not in table:
        raise InputError(f"{path} is no table of an ensemble")
    return table


def variant_of(member):
    settings = {key: value for key, value in member["settings"].items() if key != "seed"}
    return ", ".join(f"{key} = {value}" for key, value in settings.items()) or "all seeds"


def draw_ensemble(path, names):
    finished = [m for m in read_table(path)["members"] if m["state"] == "finished"]
    members = finished[:MOST_RUNS]
    folder = path if Path(path).is_dir() else Path(path).parent
    if not members:
        raise InputError(f"no member of the ensemble {path} has finished: there is nothing to draw")
    variants = list(dict.fromkeys(variant_of(m) for m in members))
    runs = [read(str(Path(folder) / f"{m['name']}.h5")) for m in members]
    groups = [variants.index(variant_of(m)) for m in members]
    panels = panels_of(runs, names)
    figure, grid = new_figure(len(panels), with_warnings(runs[0].title, runs))
    for axes, panel in zip(grid, panels):
        draw_members(axes, panel, runs, groups)
    some = f" of the first {MOST_RUNS} of {len(finished)} runs" if len(members) < len(finished) else ""
    draw_names(figure, variants, f"mean over seeds, thin: each{some}")
    return figure


def draw_members(axes, panel, runs, groups):
    for k, (name, label) in enumerate(panel.columns):
        for group in sorted(set(groups)):
            curves = [points_of(run, name, False) for run, own in zip(runs, groups) if own == group]
            style = {"color": COLOURS[group % len(COLOURS)], "linestyle": DASHES[k % 4]}
            for time, values in curves:
                axes.plot(time, values, linewidth=0.5, alpha=0.45, **style)
            curves = [curve for curve in curves if len(curve[0])]
            if curves:
                axes.plot(*mean_of(curves), linewidth=1.9, label=label if group == min(groups) and label else None, **style)
    finish(axes, Panel(panel.label, panel.columns, logarithmic=panel.logarithmic), runs[0])


def mean_of(curves):
    """Returns the mean curve at the times of the shortest curve, which all curves contain."""
    time = min((curve[0] for curve in curves), key=lambda times: times[-1])
    return time, np.mean([np.interp(time, *curve) for curve in curves], axis=0)


TABLE = ["connected_fraction", "endpoint_fraction", "branch_fraction", "loops", "local_temperature", "mean_square_charge"]
TABLE += ["mean_aggregate", "largest_cluster", "time"]


def draw_table(folder, names):
    """Draws means with confidence intervals over the varied keys; one key along the axis, others by colour."""
    points = read_table(folder)["points"]
    keys = [key for key in (points[0]["settings"] if points else {})]
    if not keys:
        raise InputError(f"the ensemble in {folder} varies only seeds: `plot --series {folder}` draws its time series")
    along = max(keys, key=lambda key: len({str(p["settings"][key]) for p in points}))
    known = set.intersection(*(set(p["quantities"]) for p in points))
    for name in names or []:
        if name not in known:
            raise InputError(f"the ensemble in {folder} has no {name}: it has {', '.join(sorted(known))}")
    differ = [name for name in TABLE if name in known and len({p["quantities"][name]["value"] for p in points}) > 1]
    chosen = names or differ[:6]
    if not chosen:
        raise InputError(f"the means of the ensemble {folder} do not differ: name those to draw with --observables")
    figure, grid = new_figure(len(chosen), f"{Path(folder).name}: means over seeds, 95 % confidence")
    others = list(dict.fromkeys(variant_of({"settings": without(p["settings"], along)}) for p in points))
    for axes, name in zip(grid, chosen):
        draw_means(axes, points, name, along, others)
    if len(others) > 1:
        draw_names(figure, others)
    return figure


def without(settings, key):
    return {other: value for other, value in settings.items() if other != key}


def draw_means(axes, points, name, along, others):
    values = [p["settings"][along] for p in points]
    numbers = all(isinstance(v, (int, float)) for v in values)
    tick_positions = {str(v): v if numbers else k for k, v in enumerate(dict.fromkeys(values))} if not numbers else None
    for group, other in enumerate(others):
        own = [p for p in points if variant_of({"settings": without(p["settings"], along)}) == other]
        x = [p["settings"][along] if numbers else tick_positions[str(p["settings"][along])] for p in own]
        y = [p["quantities"][name]["value"] for p in own]
        error = within_shares(name, y, [p["quantities"][name].get("half_width", 0) for p in own])
        style = {"color": COLOURS[group % len(COLOURS)], "marker": "o", "markersize": 4, "linewidth": 0.8, "capsize": 3}
        axes.errorbar(x, y, error, **style)
    if tick_positions:
        axes.set_xticks(list(tick_positions.values()), list(tick_positions))
    elif len(set(values)) <= 8:
        axes.set_xticks(sorted(set(values)))
    axes.margins(x=0.1)
    axes.set(xlabel=along, ylabel=name.replace("_", " "))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.tick_params(labelsize=8)


def within_shares(name, values, half_widths):
    """[2, R] lengths of the error bars below and above; those of a fraction end at 0 and 1."""
    below = above = np.array(half_widths, float)
    if name.endswith("fraction") or "_fraction_" in name:
        below, above = np.minimum(below, values), np.minimum(above, 1 - np.array(values))
    return np.array([below, above])


def picture_name(request):
    stems = [Path(path).with_suffix("") if not Path(path).is_dir() else Path(path) for path in request.result]
    what = "series" if request.series else "means"
    chosen = f"-{request.observables.replace(',', '-').replace(':', '-')}" if request.observables else ""
    beside = "".join(f"-beside-{stem.name}" for stem in stems[1:])
    return request.out or f"{stems[0]}{beside}-{what}{chosen}.png"


def draw(request, is_ensemble):
    """Draws curves of a request of `lichtenberg plot`: files over time, or without `series` an ensemble's means. Throws
    InputError and Failure."""
    names = request.observables.split(",") if request.observables else None
    drawing.check_picture(picture_name(request), request.overwrite)
    if is_ensemble:
        figure = (draw_ensemble if request.series else draw_table)(request.result[0], names)
    else:
        figure = draw_runs([read(path) for path in request.result], names)
    drawing.save(figure, picture_name(request))
    drawing.messages.say(f"{picture_name(request)} shows {'curves over time' if request.series else 'means'}")
