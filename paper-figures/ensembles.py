"""What the figures of ensembles share: the ensemble that they show, its runs as they grow, panels of counts against N or M."""

import json
import sys

import h5py
import numpy as np

from figures import SOURCE, attempt, name_for, refuse, request, run

# As `lichtenberg ensemble` takes them. Half the cells of scenes/dendrite.toml a side, a quarter of the work; what that
# moves is measured by `topology_study.py cells`.
DEFAULT = ["--conductors", "64,100,144,196,256,324", "--seeds", "4", "--vary", "field.cells=256"]

STUDENT = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
           2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042]


class Ensemble:
    """A folder that `lichtenberg ensemble` has filled, and its summary ensemble.json."""

    def __init__(self, folder, program):
        self.folder, self.program = folder, program
        self.summary = json.loads((folder / "ensemble.json").read_text())
        self.members = [member for member in self.summary["members"] if member["state"] == "finished"]
        if not self.members:
            sys.exit(f"{folder} has no finished run")

    def values(self, quantity):
        """Of each finished run."""
        return np.array([member["quantities"][quantity] for member in self.members])

    def slope(self, quantity):
        """The pair (slope, half width of its 95 % interval) of a count against the number of conductors."""
        found = [entry["slope"] for entry in self.summary["proportions"] if entry["quantity"] == quantity]
        if len(found) != 1:
            sys.exit(f"{self.folder}: not one slope of {quantity} but {len(found)}: the ensemble must differ in conductors "
                     "and seeds, and in nothing else")
        return found[0]["value"], found[0].get("half_width", float("inf"))

    def largest(self):
        """The runs of the most conductors."""
        most = self.values("conductors").max()
        return [member for member in self.members if member["quantities"]["conductors"] == most]

    def growth(self, member, *names):
        """Observables of a run, frame by frame."""
        with h5py.File(self.folder / (member["name"] + ".h5")) as file:
            return [file[f"observables/{name}/value"][()] for name in names]

    def analysis(self, member):
        """What `lichtenberg analyse` finds in a run, frame by frame."""
        path = self.folder / (member["name"] + ".h5")
        with h5py.File(path) as file:
            known = "analysis" in file
        if not known:
            run(self.program, "analyse", path, "--json")
        with h5py.File(path) as file:
            return {name: data[()] for name, data in file["analysis"].items()}


def requested(description, name):
    """The ensemble that the command line names, and the name of the figure NAME of it. By default that of output/sizes,
    whatever sizes and seeds it has; if there is none, scenes/dendrite.toml is run in sizes up to its own."""
    asked = request(description, ("--ensemble", "folder of `lichtenberg ensemble --conductors ...` to show"))
    folder = asked.ensemble or asked.results / "sizes"
    if asked.ensemble is None and not (folder / "ensemble.json").exists():
        fill(asked.program, folder)
    if not (folder / "ensemble.json").exists():
        sys.exit(f"{folder} is no folder of `lichtenberg ensemble`: ensemble.json is missing")
    ensemble = Ensemble(folder, asked.program)
    members = ensemble.summary["members"]
    print(f"{folder}: {len(ensemble.members)} of {len(members)} runs are finished")
    return ensemble, name_for(name, asked.ensemble)


def fill(program, folder):
    """Runs the default ensemble. Members that fail are named, and the figure is of the others."""
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
    """Our own slope with its interval; one run has none."""
    value, half_width = slope
    ends = np.array([0, largest])
    words = f"{value:.3f} ± {half_width:.3f}" if np.isfinite(half_width) else f"{value:.3f}, one run"
    axes.plot(ends, value * ends, color="tab:red", linewidth=1, label=f"ours, {words}")
    if not np.isfinite(half_width):
        return
    axes.fill_between(ends, (value - half_width) * ends, (value + half_width) * ends, color="tab:red", alpha=0.15,
                      linewidth=0)


def scatter(axes, x, y, **style):
    """Runs of equal counts lie on each other: they are drawn through each other. Last in its axes."""
    axes.plot(x, y, linestyle="", marker="o", markersize=4, color="tab:red", alpha=0.4, markeredgewidth=0, **style)
    axes.set_ylim(bottom=0)  # not before: it ends autoscaling


def pooled_slope(series):
    """Slope of counts against M over the frames of many runs, by least squares with weights 1/M as everywhere, with its
    95 % interval. Frames of one run depend on each other, so each run gives one slope, and the interval is that of
    their mean (Student's t)."""
    slopes = np.array([count.sum() / size.sum() for size, count in series])
    if len(slopes) < 2:
        return slopes.mean(), float("inf")
    return slopes.mean(), student_factor(len(slopes) - 1) * slopes.std(ddof=1) / np.sqrt(len(slopes))


def student_factor(freedom):
    """Quantile .975 of Student's t distribution: the printed table, and above it its expansion about the normal one."""
    return STUDENT[freedom - 1] if freedom <= len(STUDENT) else 1.960 + 2.37 / freedom
