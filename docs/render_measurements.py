#!/usr/bin/env python3
"""Writes the pages of measured figures, and the bibliography, in docs/ from their data.

Each JSON file holds one measurement or a list of them. A measurement is an object with these keys.

    `measures`  Quantity that the rows contain.
    `unit`      Unit of the measured values whose keys name none; sizes, settings and counts are pure numbers. An
                object has the unit of each such key. "1" is the unit of pure numbers, and "see rows" means that a
                text of each row states its unit. It may be absent if each key of a number ends with a unit in
                parentheses, and for texts.
    `command`   Command that repeats the measurement, or an object of several.
    `commit`    Commit of the programs, or an object of several; rows may have one of their own.
    `machine`   Processor, cores, compiler and other load.
    `date`      Text with the date of the run, YYYY-MM-DD.
    `rows`      List of objects that map a column to a value. Columns are in order of first appearance.
    `note`      Remark for the reader, optional.
    `page`      Page that shows the measurement (PAGES). Without it no page does.

Other keys are refused. A value "not kept" states that the author did not record it. The pages name it "not recorded".

docs/measurements/experiments holds comparisons with published experiments: objects or lists of objects with these keys.

    `row`        Number of the experiment.
    `reference`  Publication that states the value.
    `quantity`   Name and unit of the compared quantity.
    `published`  Object of `value` (may be null), `interval` [low, high] (null: no bound) and `source`: "S" read in full,
                 "A" read in the abstract, "M" from memory.
    `expected`   Expectation, written before the run.
    `ours`       Object of `value`, `interval` and `runs`.
    `verdict`    "agrees" if both intervals have a common point, else "disagrees".
    `reason`     Assumption that decides. It may be empty if the row agrees.
    `command`, `commit`, `machine`, `date`, `seconds`  Conditions of the run.

The script writes these pages, docs/experiments.md, and docs/bibliography.md from docs/bibliography.bib. With --check it exits with 1 if a
measurement lacks a key, or if a page differs from the data.
"""

import argparse
import json
import math
import re
import sys
import textwrap
import unicodedata
from pathlib import Path

HERE = Path(__file__).resolve().parent
DATA = HERE / "measurements"
REQUIRED = {"measures": str, "command": (str, dict), "commit": (str, dict), "machine": (str, dict), "date": str,
            "rows": list}
OPTIONAL = {"unit": (str, dict), "note": str, "page": str}
IN_ROWS = "see rows"

# Page -> (title, introduction).
PAGES = {
    "performance": ("Performance", "Times next to those of other programs, times of whole runs, of solves and of steps "
                    "on processors. Ratios are more reliable than times, which depend on the machine. "
                    "[Devices](performance-device.md) and [numerical parameters](performance-parameters.md) have pages "
                    "of their own. [Negative results](measurements/negative-results-benchmarks.md) lists variants "
                    "that were measured and rejected."),
    "performance-device": ("Performance on a CUDA device", "Times on an NVIDIA H200. Repeated runs on a device give "
                           "bitwise identical results."),
    "performance-scaling": ("Several devices and processes", "Data that devices and processes exchange, measured and expected gains, and "
                "limits of larger numbers. [Determinism](numerics/determinism.md) states which results "
                "have identical bits."),
    "performance-parameters": ("Cost and error by numerical parameter", "Iterations, solves and errors as functions of "
                               "tolerances and scene parameters. Counts of iterations do not depend on the machine."),
    "performance-history": ("Work by commit", "Instructions, cache misses and memory of fixed pieces of work, newest "
                            "first. CI fails if a piece takes 5 % more instructions or 10 % more memory than in the "
                            "first table (`validation/gate.py`)."),
    "validation": ("Validation", "`build/validation NAME` exits with 1 if an error exceeds its bound; "
                   "`ctest -L validation` runs the quick part of each program."),
    "long-validation": ("Long checks", "Checks that take too long for every change. `validation/long.sh` runs them in "
                        "slices of at most an hour, and `validation/long/checks.toml` lists them."),
    "coverage": ("Executed source code", "Parts of `src/` and `solvers/` that the quick tests execute, by gcovr: without branches that "
                 "only exceptions take or that no program can reach. Instances of a template are one function. CUDA files "
                 "are left out. `validation/long/coverage.py` fails below 92 % of the lines or 80 % of the branches."),
    "figures": ("Published figures", "Published values and the values of this program, with a verdict each. D is the "
                "dissertation on conductors, G the source on grains ([bibliography](bibliography.md)). "
                "`paper-figures/make.sh` prints this comparison for new runs."),
    "measurements/fields": ("Measurements of cut cells and relaxation", "Errors, iterations and times that the manuals "
                            "cite."),
    "measurements/multipoles": ("Measurements of multipoles and spheres", "Errors, iterations and times that the "
                                "manuals cite."),
    "measurements/motion": ("Measurements of motion and estimates", "Counts, errors and times that the manuals cite."),
    "measurements/grains": ("Measurements of grains and sums over charges", "Errors and times that the manuals cite."),
    "measurements/negative-results": ("Negative results", "Each row states a method, its measured or estimated effect, "
                                      "and the reason; \"-\" means that no reason is known."),
    "measurements/negative-results-benchmarks": ("Negative results of the benchmarks", "The numbers compare the variant "
                                                 "with the version in use at that time: \"5.4 for 4.2 s\" is the time "
                                                 "of the variant and of the version in use. `us` is microseconds, "
                                                 "`H200` a CUDA device."),
}
LARGEST_TABLE = 8  # columns; of a sparse table with more, each row has its values in one cell


def measurements(path):
    """Returns the measurements of a file as a list of objects."""
    data = json.loads(path.read_text(encoding="utf-8"))
    return data if isinstance(data, list) else [data]


def faults(measurement):
    """Yields one message for each missing, unknown or misused key of a measurement."""
    for key, kind in REQUIRED.items():
        if not isinstance(measurement.get(key), kind):
            yield f"'{key}' is missing or of a wrong type"
    for key, value in measurement.items():
        if key not in REQUIRED | OPTIONAL:
            yield f"'{key}' is unknown; allowed are {', '.join(REQUIRED | OPTIONAL)}"
        elif not isinstance(value, (REQUIRED | OPTIONAL)[key]):
            yield f"'{key}' is of a wrong type"
    if not re.search(r"\b\d{4}-\d{2}-\d{2}\b", str(measurement.get("date"))):
        yield "'date' contains no date YYYY-MM-DD"
    rows = measurement.get("rows")
    if not rows or not all(isinstance(row, dict) and row for row in rows):
        yield "'rows' is not a list of non-empty objects"
    else:
        yield from unit_faults(measurement.get("unit"), rows)
    if measurement.get("page", "validation") not in PAGES:
        yield f"'page' is none of {', '.join(PAGES)}"


def has_number(value):
    """Returns true for a number, and for a list or an object with one."""
    if isinstance(value, (list, dict)):
        return any(map(has_number, value.values() if isinstance(value, dict) else value))
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def unit_faults(unit, rows):
    """Yields one message for each key of numbers without a unit, and for a unit that is empty or belongs to no key."""
    bare = dict.fromkeys(key for row in rows for key, value in row.items() if has_number(value) and "(" not in key)
    if unit is None and bare:
        yield f"'unit' is missing, and these keys of 'rows' name none in parentheses: {', '.join(bare)}"
    elif unit == IN_ROWS:
        if not all(any(isinstance(value, str) for value in row.values()) for row in rows):
            yield f"'unit' is \"{IN_ROWS}\", and a row has no text"
    elif isinstance(unit, dict):
        columns = {key for row in rows for key in row}
        yield from (f"'unit' lacks {key}" for key in bare if not unit.get(key))
        yield from (f"'unit' has {key}, which is no key of 'rows'" for key in unit if key not in columns)
    elif unit is not None and not unit:
        yield "'unit' is empty: the unit of pure numbers is \"1\""


def text(value):
    """Returns a value as the text of a table cell."""
    if isinstance(value, list):
        return ", ".join(map(text, value))
    if isinstance(value, dict):
        return "; ".join(f"{key}: {text(part)}" for key, part in value.items())
    return str(value).replace("|", "\\|").replace("\n", " ")


def wrapped(line):
    """Returns prose or an item of a list in lines of at most 100 columns, any other line unchanged."""
    if line.startswith(("|", "#")) or not line:
        return line
    indent = "  " if line.startswith("- ") else ""
    return textwrap.fill(line, 100, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def is_kept(value):
    """Returns true for a condition that was recorded."""
    return bool(value) and "not kept" not in str(value)


def commit_of(measurement):
    """Returns the commit of the programs as text, and the number of rows with a commit of their own."""
    rows, commit = measurement["rows"], measurement["commit"]
    own = sum(is_kept(row.get("commit")) for row in rows)
    parts = [text(commit).replace("not kept", "not recorded")] if is_kept(commit) and commit != IN_ROWS else []
    parts += [f"in the rows, for {own} of {len(rows)}" if own < len(rows) else "in the rows"] if own else []
    return "; ".join(parts) or "not recorded"


def table_of(rows):
    """Returns the columns and the rows of cells of a table. Many different keys share one cell as "key: value"."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    filled = sum(map(len, rows)) / (len(columns) * len(rows))
    if len(columns) <= LARGEST_TABLE or filled > 0.5:
        return columns, [[row.get(column, "") for column in columns] for row in rows]
    first = [next(iter(row)) for row in rows]
    return ["case", "values"], [[row[key], {other: value for other, value in row.items() if other != key}]
                                for key, row in zip(first, rows)]


def titled(column, unit):
    """Returns the title of a column: its key, with its unit from an object of units."""
    own = unit.get(column, "1") if isinstance(unit, dict) else "1"
    return column if own == "1" else f"{column} ({own})"


def section(measurement, file=""):
    """Returns the lines of one measurement: heading, table and conditions."""
    columns, cells = table_of(measurement["rows"])
    unit = measurement.get("unit")
    columns = [titled(column, unit) for column in columns]
    unit = f" ({unit})" if isinstance(unit, str) and unit not in ("1", IN_ROWS) else ""
    yield from (f"## {measurement['measures'][0].upper()}{measurement['measures'][1:]}{unit}", "")
    yield "|" + "|".join(text(column) for column in columns) + "|"
    yield "|" + "-|" * len(columns)
    for row in cells:
        yield "|" + "|".join(map(text, row)) + "|"
    yield ""
    if "note" in measurement:
        yield from (text(measurement["note"]), "")
    command = measurement["command"]
    named = command.items() if isinstance(command, dict) else [("", command)]
    yield from (f"- Command{name and f' ({name})'}: " + (f"`{part}`" if is_kept(part) else text(part).replace(
        "not kept", "not recorded")) for name, part in named)
    yield f"- Machine: {text(measurement['machine']).replace('not kept', 'not recorded')}"
    yield f"- Date: {measurement['date'].replace('not kept', 'not recorded')}"
    yield f"- Commit: {commit_of(measurement)}"
    yield from ([f"- Data: `{file}`"] if file else [])
    yield ""


def page(name):
    """Returns the text of a page: its introduction and all measurements that name it, in the order of the files."""
    title, introduction = PAGES[name]
    lines = [f"# {title}", "", f"{introduction} `docs/render_measurements.py` writes this page from its data.", ""]
    for path in sorted(DATA.glob("*.json")):
        for measurement in measurements(path):
            if measurement.get("page") == name:
                lines += section(measurement, path.name)
    return "\n".join(map(wrapped, lines)).rstrip() + "\n"


MACHINE = "Intel(R) Xeon(R) Processor, 2 cores"  # of most experiments
CONDITIONS = {"command": str, "commit": str, "machine": str, "date": str, "seconds": (int, float)}
EXPERIMENT = {"row": int, "reference": str, "quantity": str, "published": dict, "expected": str, "ours": dict,
              "verdict": str, "reason": str, **CONDITIONS}
CHANGE = {"assumption": str, "change": str, "expected": str, "ours": dict, "verdict": str, **CONDITIONS}


def interval_of(part, name):
    """Returns the bounds of an interval [low, high], infinite for null. Raises ValueError for anything else."""
    bounds = part.get("interval")
    if not (isinstance(bounds, list) and len(bounds) == 2 and
            all(bound is None or has_number(bound) for bound in bounds)):
        raise ValueError(f"'{name}' has no 'interval' of two numbers or null")
    low, high = (end if bound is None else bound for bound, end in zip(bounds, (-math.inf, math.inf)))
    if low > high:
        raise ValueError(f"the interval of '{name}' is empty")
    return low, high


def key_faults(part, kinds, optional=()):
    """Yields one message for each missing or unknown key of a part of a comparison."""
    yield from (f"'{key}' is missing or of a wrong type" for key, kind in kinds.items() if not isinstance(part.get(key), kind))
    yield from (f"'{key}' is unknown; allowed are {', '.join(kinds)}" for key in part if key not in kinds and key not in optional)


def verdict_faults(published, part):
    """Yields one message for each fault of the value, verdict and expectation of a row or of a change."""
    if not has_number(part["ours"].get("value")) or not isinstance(part["ours"].get("runs"), int):
        yield "'ours' has no number 'value' or no integer 'runs'"
    try:
        theirs, ours = interval_of(published, "published"), interval_of(part["ours"], "ours")
    except ValueError as error:
        yield str(error)
        return
    verdict = "agrees" if theirs[0] <= ours[1] and ours[0] <= theirs[1] else "disagrees"
    if part["verdict"] != verdict:
        yield f"'verdict' is \"{part['verdict']}\", but by the intervals it is \"{verdict}\""
    if not part["expected"]:
        yield "'expected' is empty"


def experiment_faults(row):
    """Yields one message for each missing, unknown or contradictory key of a comparison with an experiment."""
    found = list(key_faults(row, EXPERIMENT, ["changes"]))
    if found:
        yield from found
        return
    if row["published"].get("source") not in ("A", "S", "M"):
        yield "'published' has no 'source' A, S or M"
    yield from verdict_faults(row["published"], row)
    if row["verdict"] == "disagrees" and not row["reason"]:
        yield "'reason' is empty, and the row disagrees"
    changes = row.get("changes", [])
    if (row["verdict"] == "disagrees") != bool(changes):
        yield "'changes' must have entries exactly if the row disagrees"
    for change in changes:
        found = list(key_faults(change, CHANGE, ["against"]))
        if change.get("against") not in [None, *(each.get("change") for each in changes)]:
            found = ["'against' names no change of the row"]
        yield from (f"change \"{change.get('change')}\": {fault}" for fault in
                    found or verdict_faults(row["published"], change))


def half_width(part):
    return (part["interval"][1] - part["interval"][0]) / 2


def moves(one, other):
    """Returns true if two values differ by more than both intervals together (the root of the sum of their squares)."""
    return abs(one["value"] - other["value"]) > math.hypot(half_width(one), half_width(other))


def deciding(row):
    """Returns the assumptions that decide: their change moves the value, and the row agrees with it."""
    before = {None: row["ours"], **{change["change"]: change["ours"] for change in row["changes"]}}
    return list(dict.fromkeys(change["assumption"] for change in row["changes"] if change["verdict"] == "agrees" and
                              moves(change["ours"], before[change.get("against")])))


def with_interval(part, digits=6):
    """Returns a value and its interval as text, with these digits: value ± half width, if the value is its middle."""
    value, bounds = part.get("value"), part["interval"]
    if value is not None and None not in bounds and math.isclose(2 * value, sum(bounds), rel_tol=1e-8, abs_tol=1e-8):
        return f"{value:.{digits}g}" + (f"±{half_width(part):.2g}" if bounds[1] > bounds[0] else "")
    low, high = ("" if bound is None else f"{bound:.{digits}g}" for bound in bounds)
    return ("" if value is None else f"{value:.{digits}g} ") + f"[{low}, {high}]"


def grouped(rows):
    """Returns pairs of the changes in their order, and of the rows that share some of them with their expectations."""
    groups = []
    for row in rows:
        changes = {(change["change"], change["expected"]): change for change in row.get("changes", [])}
        for shared, group in groups:
            if shared.keys() & changes.keys():
                shared.update({key: change for key, change in changes.items() if key not in shared})
                group.append(row)
                break
        else:
            groups += [(changes, [row])] if changes else []
    return groups


def change_tables(rows):
    """Yields the lines of tables of changes, and of the assumptions that decide."""
    for changes, group in grouped(rows):
        yield from ("|changed|expected|" + "|".join(text(row["quantity"]) for row in group) + "|", "|-|-|" + "-|" * len(group))
        yield "|nothing||" + "|".join(with_interval(row["ours"], 3) for row in group) + "|"
        for (name, expected), change in changes.items():
            cells = [next((with_interval(each["ours"], 3) + (" agrees" if each["verdict"] == "agrees" else "")
                           for each in row["changes"] if (each["change"], each["expected"]) == (name, expected)), "")
                     for row in group]
            yield "|" + "|".join(map(text, (f"{change['assumption']}: {name}", expected, *cells))) + "|"
        yield from ("|decides||" + "|".join(", ".join(deciding(row)) or "none of those tried" for row in group) + "|", "")


def condition_lines(rows):
    """Yields one line for each command of rows and of changes: its seconds, dates, commits and machines other than MACHINE."""
    parts = [*rows, *(change for row in rows for change in row.get("changes", []))]
    lines = {}
    for part in parts:
        command = re.sub(" --changes .*", " --changes", part["command"])
        found = lines.setdefault(command, ({}, {}))
        found[0][part.get("change"), part["command"]] = part["seconds"]
        found[1].update(dict.fromkeys((part["date"], re.sub(r".*\((.*)\)", r"\1", part["commit"]))))
        found[1].update({} if part["machine"] == MACHINE else {part["machine"]: None})
    for command, (seconds, words) in lines.items():
        yield f"- `{command}` ({sum(seconds.values()):.3g} s), {', '.join(words)}"


def experiments():
    """Returns the text of docs/experiments.md."""
    rows = [row for path in sorted((DATA / "experiments").glob("*.json")) for row in measurements(path)]
    rows.sort(key=lambda row: row["row"])
    agreeing = sum(row["verdict"] == "agrees" for row in rows)
    lines = ["# Published experiments", "", "Published values and those of this program, with intervals: of 95 % over "
             "several runs, of the numerical error for one (± half of it). A row agrees if both intervals have a common point. "
             f"{agreeing} of {len(rows)} rows of {len({row['row'] for row in rows})} experiments agree. Published "
             "values are from the paper (S), its abstract (A) or from memory (M), to be checked. Where a publication "
             "states no interval, it is that of the last digit, or the row says that it is assumed. "
             "`docs/render_measurements.py` writes this page from `docs/measurements/experiments`.", "",
             "Rows that disagree have a table of changes, one assumption at a time. An assumption decides if its change "
             "moves the value by more than the intervals allow, and the row then agrees. A line names command, duration, "
             f"date, commit, and the machine if it is not {MACHINE}.", "",
             "|row|quantity|published|ours|verdict|", "|-|-|-|-|-|"]
    for row in rows:
        theirs = f"{with_interval(row['published'])} {row['published']['source']}"
        lines.append("|" + "|".join(map(text, (row["row"], row["quantity"], theirs, with_interval(row["ours"]),
                                               row["verdict"]))) + "|")
    for number in dict.fromkeys(row["row"] for row in rows):
        group = [row for row in rows if row["row"] == number]
        references = "; ".join(dict.fromkeys(row["reference"] for row in group))
        lines += ["", f"## Row {number}: {text(references)}", ""]
        lines += [f"- Expected: {text(expected)}" for expected in dict.fromkeys(row["expected"] for row in group)]
        lines += [f"- Found: {text(reason)}" for reason in dict.fromkeys(row["reason"] for row in group if row["reason"])]
        lines += condition_lines(group)
        lines += ["", *change_tables(group)][:-1]  # their last line is empty
    return "\n".join(map(wrapped, lines)).rstrip() + "\n"


LETTERS = {'"': "\u0308", "`": "\u0300", "'": "\u0301"}  # combining accents of LaTeX


def plain(value):
    """Returns a value of BibTeX as text."""
    value = re.sub(r"{\\([\"`'])(\w)}", lambda found: found[2] + LETTERS[found[1]], value).replace("{\\o}", "ø")
    return unicodedata.normalize("NFC", value.replace("--", "-").replace("{", "").replace("}", ""))


def source(fields):
    """Returns one item of the bibliography: key, authors, where it was published. Articles have no title."""
    authors = [name.partition(",")[0] for name in fields.get("author", "").split(" and ") if name]
    names = ", ".join(authors) if len(authors) < 4 else f"{authors[0]} and others"
    published = [f"*{fields['journal']}*" if "journal" in fields else f"*{fields['title']}*"]
    published += [f"**{fields['volume']}**"] if "volume" in fields else []
    published += [f"number {fields['number']}"] if "number" in fields and "volume" not in fields else []
    others = [fields[key] for key in ("pages", "booktitle", "publisher", "school", "howpublished") if key in fields]
    published = [" ".join(published), *others]
    key = fields.get("key") or f"{authors[0] if authors else ''} {fields.get('year', '')}"
    return f"- **{key}**: {names and names + ', '}{', '.join(published)}."


def bibliography():
    """Returns the text of docs/bibliography.md."""
    entries = re.findall(r"^@\w+{\w+,\n(.*?)^}", (HERE / "bibliography.bib").read_text(encoding="utf-8"),
                         re.MULTILINE | re.DOTALL)
    items = [source({name: plain(value) for name, value in re.findall(r"^  (\w+) = {(.*)},$", entry, re.MULTILINE)})
             for entry in entries]
    lines = ["# Bibliography", "", "Pages of the manuals cite these sources by first author and year. "
             "[bibliography.bib](bibliography.bib) also has the titles. `docs/render_measurements.py` writes this page "
             "from it.", "", *sorted(items, key=str.casefold)]
    return "\n".join(map(wrapped, lines)).rstrip() + "\n"


def written_pages():
    """Returns the text of each page that this script writes, by the page's name. A page without data is left out."""
    named = {measurement.get("page") for path in DATA.glob("*.json") for measurement in measurements(path)}
    return {name: page(name) for name in PAGES if name in named} | {"bibliography": bibliography(), "experiments": experiments()}


def check():
    """Returns messages for faulty measurements and for pages that differ from the data."""
    messages = [f"{path.name}, measurement {number}: {fault}" for path in sorted(DATA.glob("*.json"))
                for number, measurement in enumerate(measurements(path), 1) for fault in faults(measurement)]
    messages += [f"experiments/{path.name}, row {number}: {fault}" for path in
                 sorted((DATA / "experiments").glob("*.json"))
                 for number, row in enumerate(measurements(path), 1) for fault in experiment_faults(row)]
    if not messages:
        for name, content in written_pages().items():
            path = HERE / f"{name}.md"
            if not path.exists() or path.read_text(encoding="utf-8") != content:
                messages.append(f"docs/{name}.md differs from the data: run docs/render_measurements.py")
    return messages


def main():
    """Writes or checks the pages."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare only; exit status 1 if anything is wrong")
    if parser.parse_args().check:
        messages = check()
        print("\n".join(messages) or "all pages agree with the data")
        return 1 if messages else 0
    for name, content in written_pages().items():
        (HERE / f"{name}.md").write_text(content, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
