"""Measurements of `lichtenberg work-precision` as a table and as JSON."""
import math
from itertools import groupby

from .messages import printable

MOST_DECADES = 16  # limit of the loop if errors are 0


def in_words(settings):
    """Formats settings: S = 512, tolerance = 1e-06"""
    return ", ".join(f"{name} = {value:g}" for name, value in settings.items())


def cheapest_points(points, quantity, reference_error):
    """Returns (error, point or None): the cheapest point whose error is at most 1e-1, 1e-2, ... in the quantity of
    that index, down to the first error that no point reaches. Errors below the uncertainty of the reference count as
    equal to it."""
    prices = []
    for decade in range(1, MOST_DECADES + 1):
        good = [point for point in points if max(point["errors"][quantity], reference_error) <= 10.0**-decade]
        prices.append((10.0**-decade, min(good, key=lambda point: point["seconds"], default=None)))
        if not good:
            break
    return prices


def cheapest_by_quantity(sweep):
    """Returns the errors by quantity."""
    errors = zip(sweep.about["quantities"], sweep.about["reference_errors"])
    return {name: cheapest_points(sweep.points, k, error) for k, (name, error) in enumerate(errors)}


def shows_evaluations(sweep):
    return any("evaluations" in point for point in sweep.points)


def heading(sweep):
    about, load = sweep.about, sweep.about["load"]
    errors = "".join(f" {error:.1e}" for error in about["reference_errors"])
    busy = ": others were at work, and times may be too long" if load > 0.5 else ""
    cores = f"{about['cores']} core{'' if about['cores'] == 1 else 's'}"
    text = f"{printable(about['scene'])}: {about['title']}\n  errors      {about['errors']}\n"
    text += f"  reference   {about['reference']}; its own error is about{errors}\n"
    text += f"  time        {about['time']} of a run from nothing: the median of up to five after one that does not count\n"
    if shows_evaluations(sweep):
        text += "  evaluations of an operator, in residual evaluations on the whole grid\n"
    text += f"  machine     {about['processor']}, {cores}, load {load:.1f} before the start{busy}\n"
    return text + f"  versions    {about['versions']}\n\n"


def order(before, point):
    """Returns the order of the first quantity's error (error ~ work^-order) between two successive points of a method."""
    if before is None or before["method"] != point["method"] or before["work"] == point["work"]:
        return ""
    old, new = before["errors"][0], point["errors"][0]
    return f"{-math.log(new / old) / math.log(point['work'] / before['work']):.2f}" if old > 0 and new > 0 else ""


def lines_of_points(sweep):
    quantities, work = sweep.about["quantities"], sweep.about["work"]
    widths = [max(12, len(quantity) + 2) for quantity in quantities]
    work_width = max(14, len(work) + 2)
    shows_order, evaluations = len(quantities) == 1, shows_evaluations(sweep)
    text = f"{'method':<26}{'settings':<34}" + "".join(f"{name:>{width}}" for name, width in zip(quantities, widths))
    text += f"{'order':>8}" * shows_order + f"{'ms':>12}{'cores':>7}{work:>{work_width}}"
    text += f"{'evaluations':>13}" * evaluations + f"{'MiB':>9}\n"
    before = None
    for point in sweep.points:
        text += f"{point['method']:<26}{in_words(point['settings']):<34}"
        text += "".join(f"{error:>{width}.1e}" for error, width in zip(point["errors"], widths))
        text += f"{order(before, point):>8}" if shows_order else ""
        text += f"{1e3 * point['seconds']:>12.4g}{point['cores']:>7.2f}{point['work']:>{work_width}}"
        text += f"{format(point['evaluations'], '.1f') if 'evaluations' in point else '':>13}" if evaluations else ""
        text += f"{format(point['mebibytes'], '.0f') if 'mebibytes' in point else '':>9}\n"
        before = point
    return text


def lines_of_left_out(sweep):
    """Returns one line per method, with the reason."""
    text = "\nleft out\n" if sweep.left_out else ""
    measured = {point["method"] for point in sweep.points}
    for (method, reason), entries in groupby(sweep.left_out, lambda entry: (entry["method"], entry["reason"])):
        settings = "; ".join(in_words(entry["settings"]) for entry in entries)
        text += f"  {method:<26}{settings + ': ' if method in measured else ''}{reason}\n"
    return text


def lines_of_prices(sweep):
    text = "\nprice list: the cheapest point with an error of at most\n"
    for quantity, prices in cheapest_by_quantity(sweep).items():
        for error, point in prices:
            text += f"  {quantity:<16}1e{math.log10(error):<6.0f}"
            if point:
                text += f"{1e3 * point['seconds']:>10.4g} ms   {point['method']}, {in_words(point['settings'])}\n"
            else:
                text += "none is that good\n"
    return text


def printed(sweep):
    return heading(sweep) + lines_of_points(sweep) + lines_of_left_out(sweep) + lines_of_prices(sweep)


def to_json(sweep):
    quantities = sweep.about["quantities"]
    data = {key: value for key, value in sweep.about.items() if key not in ("quantities", "reference_errors")}
    data["reference_errors"] = dict(zip(quantities, sweep.about["reference_errors"]))
    data["methods"] = {name: description for name, description, _, _ in sweep.methods}
    data["points"] = [{**point, "errors": dict(zip(quantities, point["errors"]))} for point in sweep.points]
    data["left_out"] = sweep.left_out
    data["prices"] = {
        quantity: [
            {"error": error, **{key: point[key] for key in ("method", "settings", "seconds")}}
            for error, point in prices
            if point
        ]
        for quantity, prices in cheapest_by_quantity(sweep).items()
    }
    return data
