"""CSV, for spreadsheets: a folder with one file per table."""
import csv
import io
import os
import re

import numpy as np

from ..files import write_whole
from ..result import GROUPS

ENDING, IS_FOLDER = "-csv", True


def write(result, frames, folder):
    """Writes particles.csv, contacts.csv and observables.csv of the frames, and one file per table."""
    chosen = list(frames)
    write_table(folder / "particles.csv", (particle_rows(result.frame(index)) for index in chosen))
    contacts = [index for index in chosen if index in result.frames_with_contacts]
    if contacts:
        write_table(folder / "contacts.csv", (contact_rows(result.frame(index)) for index in contacts))
    elif result.frames_with_contacts:  # contacts of other frames only: the set of files does not depend on the chosen frames
        write_table(folder / "contacts.csv", {"frame": [], "particle": [], "other": []})
    observables = {"time": result.time[chosen], **{name: values[chosen] for name, values in result.observables.items()}}
    write_table(folder / "observables.csv", {"frame": np.array(chosen), **spread(observables, result.terminals)})
    for name, table in result.tables.items():
        write_by_length(folder, name.replace("/", "-"), table)


def particle_rows(frame):
    """Returns the columns of a table with one row per particle."""
    count = frame.result.count
    columns = {name: frame[name] for name in frame.result.columns}
    return {"frame": np.full(count, frame.index), "particle": np.arange(count), **spread(columns, {})}


def contact_rows(frame):
    """Returns the columns of a table with one row per contact."""
    first, other = frame.contacts.T
    return {"frame": np.full(len(first), frame.index), "particle": first, "other": other}


def titled(name, values):
    return name if values.unit == "1" else f"{name} ({values.unit})"


def spread(table, labels):
    """Splits each array [R] or [R, K] into K columns, whose titles state the unit. The titles of several end in x,
    y, z if there are three, else in their labels."""
    columns = {}
    for name, values in table.items():
        if values.ndim == 1:
            columns[titled(name, values)] = np.asarray(values)
            continue
        parts = np.asarray(values).T
        words = labels.get(name) or (["x", "y", "z"] if len(parts) == 3 else range(len(parts)))
        columns.update({titled(f"{name} {word}", values): part for word, part in zip(words, parts)})
    return columns


def write_by_length(folder, name, table):
    """Columns of the same length in one file; the others in one each, single numbers as name and value."""
    lengths = [len(values) for values in table.values() if values.ndim > 0]
    usual = max(set(lengths), key=lengths.count) if lengths else 0
    together = {key: values for key, values in table.items() if values.ndim > 0 and len(values) == usual}
    if together:
        write_table(folder / f"{name}.csv", spread(together, {}))
    for key, values in table.items():
        if values.ndim > 0 and len(values) != usual:
            write_table(folder / f"{name}-{key}.csv", spread({key: values}, {}))
    single = {titled(key, values): values for key, values in table.items() if values.ndim == 0}
    if single:
        rows = {"name": list(single), "value": [value[()].item() for value in single.values()]}
        write_table(folder / (f"{name}-numbers.csv" if together else f"{name}.csv"), rows)


def write_table(path, tables):
    """Columns by their titles; of many tables with the same columns, one below the other."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")

    def lines():
        for k, columns in enumerate([tables] if isinstance(tables, dict) else tables):
            if k == 0:
                writer.writerow(columns)
            writer.writerows(zip(*(as_list(values) for values in columns.values())))
            yield text.getvalue()
            text.seek(0), text.truncate()

    write_whole(path, lines())


def as_list(values):
    """Returns the values as a list, in which an undefined number (NaN) is an empty cell."""
    values = values.tolist() if isinstance(values, np.ndarray) else values
    return ["" if isinstance(value, float) and value != value else value for value in values]


def earlier_files(folder):
    """Returns the names of the tables of an earlier export to csv, of any kind of run or of an ensemble."""
    names = set(os.listdir(folder)) if folder.is_dir() else set()
    if {"particles.csv", "observables.csv"} <= names:
        return {name for name in names if is_table(folder / name)}
    if {"members.csv", "points.csv"} <= names:
        return {name for name in names if re.fullmatch(r"(members|points)(-\d+)?\.csv", name)}
    return set()


def is_table(path):
    """Returns true if write() uses this file name. A file for one column of a table begins with the title of that
    column."""
    groups = [name.replace("/", "-") for name in GROUPS]
    if path.name in {f"{name}.csv" for name in ("particles", "contacts", "observables", *groups)}:
        return True
    if path.name in {f"{name}-numbers.csv" for name in groups}:
        return True
    column = next((path.stem.removeprefix(f"{name}-") for name in groups if path.stem.startswith(f"{name}-")), None)
    if column is None or path.suffix != ".csv":
        return False
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.readline().startswith(column)
