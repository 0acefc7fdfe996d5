"""Functions for figures of ensembles: selection of the ensemble, its runs during growth, panels of counts against N or
M."""

import json
import sys

import h5py
import numpy as np

from figures import SOURCE, attempt, name_for, refuse, request, run

# Arguments of `lichtenberg ensemble`. Half of the cells per side of scenes/dendrite.toml need a quarter of the work.
# `topology_study.py cells` measures their effect.
DEFAULT = ["--conductors", "64,100,144,196,256,324", "--seeds", "4", "--vary", "field.cells=256"]

STUDENT = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
           2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042]


class Ensemble:
    """Folder of `lichtenberg ensemble` with its summary ensemble.json."""

    def __init__(self, folder, program):
        self.folder, self.program = folder, program
        self.summary = json.loads((folder / "ensemble.json").read_text())
        self.members = [member for member in self.summary["members"] if member["state"] == "finished"]
        if not self.members:
            sys.exit(f"{folder} has no finished run")

    def values(self, quantity):
        """Returns the quantity of each finished run."""
        return np.array([member["quantities"][quantity] for member in self.members])

    def slope(self, quantity):
        """Returns (slope, half width of its 95 % interval) of a count against the number of conductors."""
        found = [entry["slope"] for entry in self.summary["proportions"] if entry["quantity"] == quantity]
        if len(found) != 1:
            sys.exit(f"{self.folder}: not one slope of {quantity} but {len(found)}: the ensemble must differ in conductors "
                     "and seeds, and in nothing else")
        return found[0]["value"], found[0].get("half_width", float("inf"))

    def largest(self):
        """Returns the runs with the most conductors."""
        most = self.values("conductors").max()
        return [member for member in self.members if member["quantities"]["conductors"] == most]

    def growth(self, member, *names):
        """Returns observables of a run by frame."""
        with h5py.File(self.folder / (member["name"] + ".h5")) as file:
            return [file[f"observables/{name}/value"][()] for name in names]

    def analysis(self, member):
        """Returns the results of `lichtenberg analyse` for a run by frame."""
        path = self.folder / (member["name"] + ".h5")
        with h5py.File(path) as file:
            known = "analysis" in file
        if not known:
            run(self.program, "analyse", path, "--json")
        with h5py.File(path) as file:
            return {name: data[()] for name, data in file["analysis"].items()}


def select_ensemble(description, name):
    """Returns the ensemble of the command line and the name of its figure NAME. The default is output/sizes, with any
    sizes and seeds. If that does not exist, scenes/dendrite.toml is run in sizes up to its own."""
    arguments = request(description, ("--ensemble", "folder of `lichtenberg ensemble --conductors ...` to show"))
    folder = arguments.ensemble or arguments.results / "sizes"
    if arguments.ensemble is None and not (folder / "ensemble.json").exists():
        fill(arguments.program, folder)
    if not (folder / "ensemble.json").exists():
        sys.exit(f"{folder} is no folder of `lichtenberg ensemble`: ensemble.json is missing")
    ensemble = Ensemble(folder, arguments.program)
    members = ensemble.summary["members"]
    print(f"{folder}: {len(ensemble.members)} of {len(members)} runs are finished")
    return ensemble, name_for(name, arguments.ensemble)


def fill(program, folder):
    """Runs the default ensemble. Names failed members; the figure shows the others."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    result = attempt(program, "ensemble", SOURCE / "scenes" / "dendrite.toml", *DEFAULT, "--quiet", "--out", folder)
    if result.returncode == 1 and (folder / "ensemble.json").exists():
        print(result.stderr.strip(), file=sys.stderr)
    elif result.returncode != 0:
        refuse(program, result)


def draw_law(axes, published, largest, label):
    axes.plot([0, largest], [0, published * largest], color="tab:blue", label=label)
    axes.set_xlim(0, 1.03 * largest)


def draw_slope(axes, slope, largest):
    """Draws the slope of this program's runs with its interval; a single run has none."""
    value, half_width = slope
    ends = np.array([0, largest])
    words = f"{value:.3f} ± {half_width:.3f}" if np.isfinite(half_width) else f"{value:.3f}, one run"
    axes.plot(ends, value * ends, color="tab:red", linewidth=1, label=f"ours, {words}")
    if not np.isfinite(half_width):
        return
    axes.fill_between(ends, (value - half_width) * ends, (value + half_width) * ends, color="tab:red", alpha=0.15,
                      linewidth=0)


def scatter(axes, x, y, **style):
    """Draws runs as transparent markers, because runs of equal counts coincide. Must be the last call for its axes."""
    axes.plot(x, y, linestyle="", marker="o", markersize=4, color="tab:red", alpha=0.4, markeredgewidth=0, **style)
    axes.set_ylim(bottom=0)  # ends autoscaling, so it comes last


def pooled_slope(series):
    """Returns the slope of counts against M over the frames of many runs with its 95 % interval. Uses least squares
    with weights 1/M as for other slopes. Frames of a run are correlated, so each run gives one slope, and the interval
    is that of their mean (Student's t)."""
    slopes = np.array([count.sum() / size.sum() for size, count in series])
    if len(slopes) < 2:
        return slopes.mean(), float("inf")
    return slopes.mean(), student_factor(len(slopes) - 1) * slopes.std(ddof=1) / np.sqrt(len(slopes))


def student_factor(freedom):
    """Returns the quantile .975 of Student's t distribution: from the table, beyond it from the expansion about the
    normal distribution."""
    return STUDENT[freedom - 1] if freedom <= len(STUDENT) else 1.960 + 2.37 / freedom
