"""Tables of growth_study.py: means over seeds by time, exponents by interval and by definition, with 95 % intervals."""

import csv
import json
from pathlib import Path

import numpy as np

from gases import mean

FOLDER = Path(__file__).resolve().parent
COURSE, EXPONENTS = FOLDER / "growth_course.csv", FOLDER / "growth_exponents.csv"
COUPLINGS = {"neutral": 0, "5e-6": 5e-6, "2e-5": 2e-5, "1e-4": 1e-4, "5e-4": 5e-4}
QUANTITIES = ("density_cluster_size", "mean_aggregate", "mean_bound_aggregate", "largest_cluster", "fractal_dimension",
              "bound_fractal_dimension", "bound_bjerrum", "bjerrum", "density_cluster_exponent", "local_temperature",
              "temperature", "mach_number_of_flow", "mean_square_displacement")
WINDOWS = ((20, 40), (50, 100), (70, 140), (100, 150), (100, 200), (150, 290), (200, 400))
FEWEST = 5  # minimum number of seeds per row

# Quantities for the gases of --conditions. The first is the time when the number mean of bound aggregates reaches ONSET.
# The others are its exponent between the sizes STAGE, and the fractal dimension at the end of STAGE. Gases are compared at
# equal sizes, not at equal times.
CONDITIONS = FOLDER / "growth_conditions.csv"
ONSET, STAGE = 4, (3, 6)


def runs(folder):
    """Returns {point: [run of each seed]} for runs with more than the first frames."""
    found = {}
    for path in sorted(folder.glob("*.json")):
        run = json.loads(path.read_text())
        if len(run["frames"]["time"]) > 2:
            found.setdefault(run["point"], []).append(run)
    return dict(sorted(found.items(), key=lambda pair: COUPLINGS[pair[0]]))


def series(run, quantity):
    """Returns (times since the warm-up, values). A quantity may be S by one of the definitions, given by its index."""
    values = run["frames"][quantity] if isinstance(quantity, str) else run["definitions"]["definitions"][quantity]["size"]
    return np.array(run["frames"]["time"]) - run["warm"], np.array(values, dtype=float)


def mean_series(members, quantity, times):
    """Returns (mean, half width, seeds) at each time."""
    rows = []
    for run in members:
        time, values = series(run, quantity)
        near = np.abs(time[:, None] - times).argmin(axis=0)
        rows.append(np.where(np.abs(time[near] - times) < 1e-6 * times + 1e-9, values[near], np.nan))
    rows = np.array(rows)
    return (*mean(rows), np.isfinite(rows).sum(axis=0))


def exponent(members, quantity, first, last):
    """Returns the exponent of time between two times by least squares of logarithms: (mean, half width, seeds)."""
    slopes = []
    for run in members:
        time, values = series(run, quantity)
        chosen = (time > 0.999 * first) & (time < 1.001 * last) & (np.nan_to_num(values) > 0)
        if chosen.sum() >= 3 and time.max() > 0.999 * last and time[chosen].max() > last - 11:
            slopes.append(np.polyfit(np.log(time[chosen]), np.log(values[chosen]), 1)[0])
    if len(slopes) < FEWEST:
        return None
    middle, half = mean(np.array(slopes)[:, None])
    return float(middle[0]), float(half[0]), len(slopes)


def write(path, head, rows):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        writer.writerows([format(cell, ".4g") if isinstance(cell, float) else cell for cell in row] for row in rows)


def report(folder):
    found = runs(folder)
    rows = []
    for point, members in found.items():
        longest = max(series(run, "time")[0].max() for run in members)
        times = np.arange(10, longest + 1e-6, 10)
        columns = [mean_series(members, quantity, times) for quantity in QUANTITIES]
        for k, time in enumerate(times):
            if columns[0][2][k] >= FEWEST:
                cells = [value for middle, half, seeds in columns
                         for value in ((float(middle[k]), float(half[k])) if seeds[k] >= FEWEST else ("", ""))]
                rows.append([point, int(time), int(columns[0][2][k]), *cells])
    head = ["point", "time", "seeds"] + [name for quantity in QUANTITIES for name in (quantity, quantity + "_half")]
    write(COURSE, head, rows)
    write(EXPONENTS, ["point", "quantity", "edge", "least", "from", "to", "exponent", "half", "seeds"], exponents(found))
    print(COURSE, EXPONENTS, sep="\n")
    print_exponents()


def exponents(found):
    for point, members in found.items():
        for first, last in WINDOWS:
            for quantity in ("density_cluster_size", "mean_aggregate", "mean_bound_aggregate", "temperature",
                             "local_temperature"):
                fitted = exponent(members, quantity, first, last)
                if fitted:
                    yield [point, quantity, "", "", first, last, *fitted]
            for index, definition in enumerate(members[0]["definitions"]["definitions"]):
                fitted = exponent(members, index, first, last)
                if fitted:
                    yield [point, "S", float(definition["edge"]), definition["least"], first, last, *fitted]


def stored_exponents():
    """Returns {(point, quantity, from, to): (exponent, half width, seeds)} of growth_exponents.csv; S by definition
    under (point, edge, least, from, to)."""
    with open(EXPONENTS) as file:
        rows = list(csv.DictReader(file))
    found = {}
    for row in rows:
        what = (round(float(row["edge"]), 1), int(row["least"])) if row["quantity"] == "S" else (row["quantity"],)
        key = (row["point"], *what, int(row["from"]), int(row["to"]))
        found[key] = float(row["exponent"]), float(row["half"]), int(row["seeds"])
    return found


def stored_series(point, quantity):
    """Returns (times, means, half widths) of growth_course.csv."""
    with open(COURSE) as file:
        rows = [row for row in csv.DictReader(file) if row["point"] == point and row[quantity]]
    return tuple(np.array([float(row[name]) for row in rows]) for name in ("time", quantity, quantity + "_half"))


def condition_exponents():
    """Returns {condition: (exponent of the number mean of bound aggregates during STAGE, half width)} of
    growth_conditions.csv."""
    with open(CONDITIONS) as file:
        return {row["point"]: (float(row["exponent"]), float(row["exponent_half"])) for row in csv.DictReader(file)}


def print_exponents():
    for key, (value, half, seeds) in stored_exponents().items():
        print(*key, f"{value:.2f} ± {half:.2f} ({seeds} seeds)")


def reached(run, size):
    """Returns (time, index of the preceding frame, fraction to the next) at which the number mean of bound aggregates
    reaches this size, interpolated as a power of time. None if it never does."""
    time, mean_size = series(run, "mean_bound_aggregate")
    for n in range(len(time) - 1):
        if time[n] > 0 and mean_size[n] < size <= mean_size[n + 1]:
            part = np.log(size / mean_size[n]) / np.log(mean_size[n + 1] / mean_size[n])
            return time[n] * (time[n + 1] / time[n]) ** part, n, part
    return None


def condition_values(run):
    """Returns {quantity: value} of one run; NaN if the run ended earlier."""
    onset, *stage = (reached(run, size) for size in (ONSET, *STAGE))
    found = {"onset": onset[0] if onset else np.nan, "exponent": np.nan, "dimension": np.nan}
    if all(stage):
        found["exponent"] = np.log(STAGE[1] / STAGE[0]) / np.log(stage[1][0] / stage[0][0])
        _, dimension = series(run, "bound_fractal_dimension")
        _, n, part = stage[1]
        found["dimension"] = (1 - part) * dimension[n] + part * dimension[n + 1]
    for name, quantity, first, last in (("exponent_of_S", "density_cluster_size", 50, 100),
                                        ("exponent_of_T", "local_temperature", 20, 100)):
        time, values = series(run, quantity)
        chosen = (time > 0.999 * first) & (time < 1.001 * last) & (np.nan_to_num(values) > 0)
        whole = time.max() > 0.999 * last and chosen.sum() >= 3
        found[name] = np.polyfit(np.log(time[chosen]), np.log(values[chosen]), 1)[0] if whole else np.nan
    return found


def report_conditions(folder):
    found = {}
    for path in sorted(folder.glob("*.json")):
        run = json.loads(path.read_text())
        if len(run["frames"]["time"]) > 2:
            found.setdefault(run["point"], []).append(condition_values(run))
    rows = []
    for point, members in found.items():
        cells = []
        for name in members[0]:
            values = np.array([[one[name]] for one in members])
            middle, half = mean(values)
            cells += [float(middle[0]), float(half[0]), int(np.isfinite(values).sum())]
        rows.append([point, *cells])
    names = list(next(iter(found.values()))[0])
    write(CONDITIONS, ["point"] + [name + suffix for name in names for suffix in ("", "_half", "_seeds")],
          sorted(rows, key=lambda row: (row[0] != "base", row[0])))
    print(CONDITIONS)
    print(CONDITIONS.read_text())
