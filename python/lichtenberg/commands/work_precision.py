"""`lichtenberg work-precision`: error against time, for every method that can solve a scene.

The program has methods of its own and measures them (src/commands/work_precision.hpp); those of methods/ join.
"""
import json
import math
import os
import statistics
import time
from pathlib import Path

from .. import messages, methods
from ..errors import Failure, InputError
from ..files import check_output, write_whole
from ..questions import Program
from ..work_precision_report import in_words, printed, to_json
from . import argument
from .ensemble import SET

HELP = "Sweeps the accuracy of every method that can solve a scene: error against time, as a table and as a picture"
ARGUMENTS = [
    argument("SCENE", "scene file (.toml)", required=True),
    SET,
    argument(
        "--time",
        "compare integrators over the scene's motion until stop.time instead of field solvers at its start",
        "flag",
    ),
    argument("--methods", "only these, as in cut-cell,multipole (default: all)", "texts", comma_separated=True),
    argument("--sizes", "cells along the longer side (default: 128,256,512,1024,2048)", "ints", comma_separated=True),
    argument("--seconds", "leave out candidates that are expected to take longer", "float", positive=True, default=10),
    argument(
        "--json",
        "print JSON instead of the table, or write it to a FILE in addition to the table: all figures",
        value_optional=True,
    ),
    argument(
        "--out",
        "picture to write: .png, .pdf or .svg (default: the scene's name with -work-precision.png, or "
        "-time-precision.png)",
    ),
    argument("--overwrite", "replace files that exist", "flag"),
]
MOST_RUNS, ENOUGH = 5, 2.0  # maximum number of timed runs of a candidate, and their maximum total time (s)


class Sweep:
    """Methods with their candidates, and the points that were measured."""

    def __init__(self, request, joined):
        words = [f"--others={method.kind}/{method.name}" for method in joined]
        words += [f"--set={each}" for each in request.set] + ["--time"] * request.time
        words += [f"--methods={name}" for name in request.methods] + [f"--sizes={cells}" for cells in request.sizes]
        self.request = request
        self.program = Program("work-precision-methods", *words, "--", request.scene)
        self.program.read()
        show_progress(0, 0, "reference", {})
        self.about = self.program.read()
        kind, self.subject = self.about.pop("kind"), self.about.pop("subject", None)
        self.joined = [m for m in joined if m.kind == kind and (not request.methods or m.name in request.methods)]
        self.points, self.left_out = [], []
        self.methods = [
            (each["name"], each["description"], [(dict(settings), cost) for settings, cost in each["candidates"]], None)
            for each in self.about.pop("methods")
        ] + [(method.name, method.description, self.candidates_of(method), method) for method in self.joined]

    def candidates_of(self, method):
        """Returns the candidates of a joined method. If the method's code has an error, or a cost is not above 0, it
        returns none and adds a reason to left_out."""
        try:
            candidates = method.candidates(self)
            if all(cost > 0 for _, cost in candidates):
                return candidates
            reason = "a candidate has a cost that is not above 0"
        except Exception as error:  # an error of one method must not end the sweep of the others
            reason = f"{type(error).__name__} in the method ({error})"
        self.left_out.append({"method": method.name, "settings": {}, "reason": reason})
        return []

    def measure(self, number, candidate_index, settings, method):
        """Returns the measured point of a candidate. Throws InputError and Failure."""
        if method:
            return self.measure_joined(method, settings)
        return self.query(method=number, candidate=candidate_index)

    def query(self, **question):
        """Returns the program's answer. Throws InputError and Failure with its error message."""
        answer = self.program.ask(**question)
        if "refused" in answer:
            raise InputError(answer["refused"])
        if "failed" in answer:
            raise Failure(answer["failed"])
        return answer

    def measure_joined(self, method, settings):
        """Returns a point whose time is the median of up to five runs, or of fewer long ones, after a first run that
        is not timed. Throws InputError, and Failure also for an error in the method's code or a wrong answer."""
        try:
            run = method.prepare(self, settings)
            answer, first = timed(run)
            count = max(1, min(MOST_RUNS, int(ENOUGH / max(first, 1e-6))))
            runs = [first] if first >= ENOUGH else [timed(run)[1] for _ in range(count)]
        except (InputError, Failure):
            raise
        except Exception as error:  # an error of one method must not end the sweep of the others
            raise Failure(f"{type(error).__name__} in the method ({error})") from None
        try:
            json.dumps(answer, allow_nan=False)
        except ValueError:
            raise Failure("unstable") from None
        except TypeError as error:
            raise Failure(f"its answer does not have the form that methods/__init__.py describes ({error})") from None
        return {**self.query(errors=answer), "seconds": statistics.median(runs), "cores": 1.0, "work": 0}


def timed(run):
    start = time.monotonic()
    answer, seconds = run()
    return answer, time.monotonic() - start if seconds is None else seconds


def show_progress(done, count, method, settings):
    """Prints on standard error which candidate is measured next. On a terminal the line is rewritten; a file gets
    one line per method."""
    where = f"{done} of {count}: " if done else ""
    if os.isatty(2):
        line = f"{where}{method}{', ' if settings else ''}{in_words(settings)}"
        messages.write_error(f"\r\033[K{line if done < count or count == 0 else ''}", end="")
    elif method != show_progress.last:
        messages.write_error(f"{where}{method}")
    show_progress.last = method


show_progress.last = None


def measure_all(sweep, seconds, progress=show_progress):
    """Measures all candidates into sweep.points and sweep.left_out. The expected time of a candidate is that of the last one of
    its method, times the ratio of their costs. Candidates that are expected to take longer than `seconds` are left out."""
    count, done = sum(len(candidates) for _, _, candidates, _ in sweep.methods), 0
    for number, (name, _, candidates, method) in enumerate(sweep.methods):
        pace = 0.0  # seconds per unit of cost
        for candidate_index, (settings, cost) in enumerate(candidates):
            done += 1
            progress(done, count, name, settings)
            reason, start = None, time.monotonic()
            if pace * cost > seconds:
                reason = f"expected to take longer than {seconds:g} s"
            else:
                try:
                    point = sweep.measure(number, candidate_index, settings, method)
                    pace = point["seconds"] / cost
                    if all(error is not None and math.isfinite(error) for error in point["errors"]):
                        sweep.points.append({"method": name, "settings": settings, **point})
                    else:
                        reason = "unstable"
                except InputError as error:
                    reason = str(error)
                except Failure as error:
                    pace, reason = (time.monotonic() - start) / cost, str(error)
            if reason:
                sweep.left_out.append({"method": name, "settings": settings, "reason": reason})


def check(request):
    if request.time and request.sizes:
        raise InputError("--sizes is for the field, not for --time, which uses the scene's field.cells")
    if not request.out.endswith((".png", ".pdf", ".svg")):
        raise InputError(f"--out {request.out}: the picture's name must end in .png, .pdf or .svg")
    written = {"--out": request.out}
    if request.json not in (None, "true"):
        written["--json"] = request.json
        if os.path.abspath(request.json) == os.path.abspath(request.out):
            words = f"the picture is written to {request.json}; give one of them another name"
            raise InputError(f"--json {request.json}: {words}")
    for option, path in written.items():
        if os.path.realpath(path) == os.path.realpath(request.scene):
            raise InputError(f"{path} is an input file and is not overwritten: name another file to write")
        check_output(path, request.overwrite, otherwise=f"give {option} another name")


def draw(data, picture):
    """Writes the picture. Throws Failure."""
    from ..pictures import drawing, work_precision

    drawing.save(work_precision.draw(data), picture)


def act(request, more=()):
    """Runs the command. `more`: joined methods."""
    kind = "-time-precision.png" if request.time else "-work-precision.png"
    request.out = request.out or Path(request.scene).stem + kind
    check(request)
    sweep = Sweep(request, methods.joined() + list(more))
    measure_all(sweep, request.seconds)
    data = to_json(sweep)
    text = json.dumps(data, indent=1, ensure_ascii=False) + "\n"
    if request.json == "true":
        messages.put(text)
    else:
        messages.put(printed(sweep))
        if request.json:
            write_whole(request.json, text)
    if sweep.points:
        draw(data, request.out)
        if request.json != "true":
            messages.put(f"\n{messages.printable(request.out)} shows it\n")
