"""Means over the members of an ensemble, as a table and as JSON."""
import math
from dataclasses import dataclass

CONDUCTORS = "population.count"
COURSE = {
    "connected_fraction": "connected",
    "endpoint_fraction": "endpoints f1",
    "branch_fraction": "branch points B",
    "loops": "loops",
    "time": "time (s)",
    "field_solves": "field solves",
    "seconds": "wall time (s)",
}
TOPOLOGY = {f"degree_fraction_{k}": f"f{k}" for k in (2, 3, 4)} | {f"strahler_fraction_{k}": f"Strahler {k}" for k in (1, 2, 3)}
GAS = {
    "temperature": "T with flow",
    "local_temperature": "T",
    "mean_square_charge": "<q^2>",
    "clusters": "clusters",
    "largest_cluster": "largest",
    "mean_aggregate": "mean of 2 and more",
}
GAS_EVENTS = {
    "dissipated_energy": "dissipated",
    "energy_error": "energy off by",
    "collisions": "collisions",
    "transfers": "transfers of charge",
    "largest_overlap": "largest overlap",
    "time": "time (t0)",
    "seconds": "wall time (s)",
}
# Counts that are proportional to the number of conductors according to D.
LAWS = {
    "endpoints": ("endpoints", "D 7.11"),
    "branch_points": ("branch points", "D 7.12"),
    "strahler_1": ("Strahler 1", "D 7.18"),
    "strahler_2": ("Strahler 2", "D 7.18"),
    "strahler_3": ("Strahler 3", "D 7.18"),
}


@dataclass
class Summary:
    points: list  # (settings without the seed, number of runs, estimates by quantity), for members that differ only in the seed
    proportions: list  # (settings without seed and number of conductors, quantity, estimate of its slope)


def without(settings, keys):
    return [setting for setting in settings if setting[0] not in keys]


def groups_apart_from(keys, members):
    """Groups the finished members by all settings except those of `keys`, in the order of each group's first member."""
    groups = {}
    for member in members:
        if member.state == "finished":
            alike = tuple((key, text) for key, text, _ in without(member.settings, keys))
            groups.setdefault(alike, []).append(member)
    return list(groups.values())


def values_of(members, quantity):
    """Returns the values of a quantity for all members; None if a member lacks it."""
    values = [member.quantities.get(quantity) for member in members]
    return None if None in values else values


def summarize(program, members):
    points, proportions = [], []
    for group in groups_apart_from(["seed"], members):
        found = {quantity: values_of(group, quantity) for quantity in group[0].quantities}
        means = {quantity: program.ask(mean=values) for quantity, values in found.items() if values}
        points.append((without(group[0].settings, ["seed"]), len(group), means))
    for group in groups_apart_from(["seed", CONDUCTORS], members):
        conductors = values_of(group, "conductors")
        if conductors and len(set(conductors)) > 1:
            others = without(group[0].settings, ["seed", CONDUCTORS])
            counts = {quantity: values_of(group, quantity) for quantity in LAWS}
            slopes = {quantity: program.ask(slope=[conductors, values]) for quantity, values in counts.items() if values}
            proportions += [(others, quantity, slope) for quantity, slope in slopes.items()]
    return Summary(points, proportions)


def shown(value, half_width):
    """Formats a value and its interval: the interval with two significant digits, the value to the same decimal
    place. If both are small they have a common power of ten."""
    if not half_width:
        return f"{value:.4g}{'' if half_width is None else ' ± 0'}"
    largest = max(abs(value), half_width)
    if largest < 1e-3:
        power = math.floor(math.log10(largest))
        return f"({shown(value / 10.0**power, half_width / 10.0**power)})e{power}"
    decimals = max(0, 1 - math.floor(math.log10(half_width)))
    return f"{value:.{decimals}f} ± {half_width:.{decimals}f}"


def estimate_in_words(estimate):
    return shown(estimate["value"], estimate.get("half_width"))


def table(points, columns):
    """Formats the table as lines, with only those columns that contain values."""
    present = [name for name in columns if any(name in quantities for _, _, quantities in points)]
    if not present:
        return ""
    rows = [[key for key, _, _ in points[0][0]] + ["runs"] + [columns[name] for name in present]]
    for settings, runs, quantities in points:
        cells = [estimate_in_words(quantities[name]) if name in quantities else "" for name in present]
        rows.append([text for _, text, _ in settings] + [str(runs)] + cells)
    widths = [max(map(len, column)) for column in zip(*rows)]
    widths[-1] = 0
    return "".join("  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths)) + "\n" for row in rows) + "\n"


def print_summary(summary):
    if not summary.points:
        return ""
    text = "means over the runs of different seeds, with 95 % confidence intervals (Student's t)\n\n"
    if {"dissipated_energy", "collisions"} <= summary.points[0][2].keys():
        text += "at the end, in units of the scene's scales; T relative to the flow in cells, and with it\n\n"
        text += table(summary.points, GAS) + table(summary.points, GAS_EVENTS)
    else:
        text += table(summary.points, COURSE) + table(summary.points, TOPOLOGY)
    if summary.proportions:
        text += "least squares through the origin over all runs, N conductors\n\n"
    for settings, quantity, slope in summary.proportions:
        name, source = LAWS[quantity]
        others = "".join(f"  {key} = {written}" for key, written, _ in settings)
        text += f"{name:<14} = ({estimate_in_words(slope)}) N  ({source}){others}\n"
    return text


def to_json(program, scene, members, summary):
    def plain(settings):
        return {key: value for key, _, value in settings}

    return {
        "scene": scene,
        "intervals": "95 %, Student's t",
        "members": [
            {"name": member.name, "settings": plain(member.settings), "state": member.state}
            | {name: getattr(member, name) for name in ("sentence", "quantities", "warnings") if getattr(member, name)}
            for member in members
        ],
        "points": [
            {"settings": plain(settings), "runs": runs, "quantities": means} for settings, runs, means in summary.points
        ],
        "proportions": [
            {"settings": plain(settings), "quantity": quantity, "slope": slope}
            for settings, quantity, slope in summary.proportions
        ],
        "version": program.version,  # version of the summary; each result file states that of its run
        "commit": program.commit,
    }
