"""A result in the formats of other programs: VTK (ParaView), extended XYZ (OVITO, ASE), CSV (spreadsheets)."""
import csv
import io
import json
import os
import re
import shutil
from pathlib import Path

import numpy as np

from . import vtk
from .result import GROUPS, Failure, InputError, check_output, chosen_frames, default_output, load, write_whole

formats = ("vtk", "xyz", "csv")
# The names of OVITO's manual (XYZ file reader) where it has others; what it does not know keeps its own
OVITO = {"position": "pos", "velocity": "velo", "image": "map_shift", "dipole": "dipoles"}


def export(source, to, out=None, frames=None, overwrite=False):
    """Writes a Result, or the result file or folder of an ensemble of that path, and returns the path of what was written:
    xyz a file, vtk and csv a folder. Throws InputError and Failure."""
    if to not in formats:
        raise InputError(f"there is no format {to}: it is one of {', '.join(formats)}")
    if isinstance(source, (str, os.PathLike)):
        if os.path.isdir(source):
            return export_ensemble(source, to, out, frames, overwrite)
        with load(source) as result:
            return export(result, to, out, frames, overwrite)
    chosen = chosen_frames(source, frames)
    out = out or default_output(source.path, ".xyz" if to == "xyz" else f"-{to}")
    check_output(out, overwrite, folder=to != "xyz")
    if to == "xyz":
        write_xyz(source, chosen, out)
    else:
        write_folder(out, to, lambda folder: {"vtk": write_vtk, "csv": write_csv}[to](source, chosen, folder))
    return out


def write_folder(out, to, write):
    """Whole or not at all. Of a folder that is there it replaces the files that it writes and those that an earlier export
    listed. Throws InputError for a folder that holds anything else."""
    out = Path(out)  # which has no slash at its end
    check_plain(out)
    partial, before = Path(f"{out}.partial-{os.getpid()}"), Path(f"{out}.before-{os.getpid()}")
    make_folder(partial)
    try:
        write(partial)
        check_replaced(out, to, set(os.listdir(partial)))
        replace_folder(out, partial, before)
    except OSError as error:
        raise Failure(f"{out} cannot be written ({error.strerror})") from None
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def check_plain(folder):
    """Throws InputError unless all that it holds are plain files."""
    for entry in os.scandir(folder) if folder.is_dir() else []:
        if not entry.is_file(follow_symlinks=False):
            raise InputError(f"{folder} holds {entry.name}, which is no plain file and no part of an export: give --out another name")


def check_replaced(folder, to, written):
    """Throws InputError if it holds a file that is neither among those `written` nor listed there by an earlier export."""
    check_plain(folder)
    known = written | listed_files(folder) | tables_in(folder)
    strange = sorted(set(os.listdir(folder)) - known) if folder.is_dir() else []
    if strange:
        raise InputError(f"{folder} holds {strange[0]}, which this export to {to} does not write: give --out another name")


def listed_files(folder):
    """The collections of an earlier export to vtk, the files that they list, and its field."""
    found = set()
    for kind in KINDS:
        path = folder / f"{kind}.pvd"
        if path.is_file():
            names = re.findall(r'file="([^"]*)"', path.read_text(encoding="utf-8", errors="replace"))
            found |= {path.name, *(name for name in names if re.fullmatch(rf"{kind}-\d+\.vtp", name))}
    return found | {"field.vti"} if found else found


def tables_in(folder):
    """The tables of an earlier export to csv, of a run of any kind or of an ensemble."""
    names = set(os.listdir(folder)) if folder.is_dir() else set()
    if {"particles.csv", "observables.csv"} <= names:
        return {name for name in names if is_table(folder / name)}
    if {"members.csv", "points.csv"} <= names:
        return {name for name in names if re.fullmatch(r"(members|points)(-\d+)?\.csv", name)}
    return set()


def is_table(path):
    """Whether write_csv names a file so. A file for one column of a table begins with the title of that column."""
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


def replace_folder(out, partial, before):
    """Puts `partial` in the place of `out`, whose files go. What came there in the meantime stays in `before`."""
    names = os.listdir(out) if out.is_dir() else None
    if names is not None:
        os.rename(out, before)
    try:
        os.rename(partial, out)
    except BaseException:
        if names is not None:
            os.rename(before, out)
        raise
    if names is not None:
        for name in names:
            os.unlink(before / name)
        os.rmdir(before)


def make_folder(path):
    """Throws Failure, also where it is there."""
    try:
        if os.path.islink(path):  # files would go to where it leads
            os.unlink(path)
        path.mkdir()
    except OSError as error:
        raise Failure(f"{path} cannot be made ({error.strerror})") from None


# ---- VTK ----

KINDS = ("particles", "contacts", "tree")  # of collections and their files


def write_vtk(result, frames, folder):
    """particles.pvd, contacts.pvd and tree.pvd with a .vtp a frame, field.vti of the last frame."""
    write_steps(result, frames, folder, "particles", lambda frame: [])
    contacts = [index for index in frames if index in result.frames_with_contacts]
    write_steps(result, contacts, folder, "contacts", lambda frame: between_particles(frame.contacts, result.count))
    if "successor" in result.columns:
        write_steps(result, frames, folder, "tree", lambda frame: between_particles(frame.tree, result.count))
    if result.field is not None:
        write_whole(folder / "field.vti", vtk.image_data(result.field_cell, np.asarray(result.field), "potential"))


def write_steps(result, frames, folder, kind, lines_of):
    """A file a frame of particles, with the lines that `lines_of(frame)` returns, and one that lists them, if there are any."""
    listed = []
    for frame in map(result.frame, frames):
        name = f"{kind}-{frame.index:06}.vtp"
        write_whole(folder / name, vtk.poly_data(np.asarray(frame["position"]), columns_of(frame), lines_of(frame), frame.time))
        listed.append((frame.time, name))
    if listed:
        write_whole(folder / f"{kind}.pvd", vtk.collection(listed))


def between_particles(pairs, count):
    """Without those to the ground or to walls, which are no points of the file."""
    return pairs[(pairs >= 0).all(axis=1) & (pairs < count).all(axis=1)]


def columns_of(frame):
    return {name: np.asarray(frame[name]) for name in frame.result.columns if name != "position"}


# ---- Extended XYZ ----


def write_xyz(result, frames, out):
    """One line a particle, each frame with its box, time and units before it."""
    write_whole(out, (xyz_frame(result.frame(index)) for index in frames))


def xyz_frame(frame):
    result = frame.result
    columns = {"species": np.full(result.count, "X"), "position": np.asarray(frame["position"])}
    columns.update(columns_of(frame))
    columns.pop("species")  # a number of ours
    columns["color"] = colours(frame)
    kinds = {"f": "R", "i": "I", "U": "S"}
    named = {"species": np.full(result.count, "X"), **{OVITO.get(name, name): values for name, values in columns.items()}}
    properties = ":".join(
        f"{name}:{kinds[values.dtype.kind]}:{values.shape[1] if values.ndim > 1 else 1}" for name, values in named.items()
    )
    head = f'Lattice="{lattice(result)}" pbc="{" ".join("FT"[axis] for axis in result.periodic)}" Properties={properties}'
    units = f'Time={frame.time:.10g} length_unit="{result.size.unit}" time_unit="{result.time.unit}"'
    blocks = [values.reshape(len(values), -1) for values in named.values()]
    words = [as_words(block) for block in blocks]
    lines = "\n".join(map(" ".join, zip(*(column for block in words for column in block))))
    return f"{result.count}\n{head} {units}\n{lines}\n"


def as_words(block):
    """[K] lists of [N] words."""
    if block.dtype.kind == "f":
        return [[f"{value:.10g}" for value in column] for column in block.T.tolist()]
    return [[str(value) for value in column] for column in block.T.tolist()]


def lattice(result):
    """The box, a plane one as deep as the largest particle is thick."""
    lengths = [*np.asarray(result.size), 2 * float(result["radius"].max(initial=0))][:3]
    return " ".join(f"{lengths[i]:.10g}" if i == j else "0" for i in range(3) for j in range(3))


def colours(frame):
    """[N, 3] red for positive, blue for negative potential (or charge, where there is none), of one scale in the whole run;
    grey where there is neither."""
    result = frame.result
    shown = next((name for name in ("potential", "charge") if name in result.columns), None)
    if shown is None:
        return np.full((result.count, 3), 0.75)
    share = np.clip(np.asarray(frame[shown])[:, None] / result.colour_range(shown)[1], -1, 1)
    white, red, blue = np.ones(3), np.array([0.7, 0.09, 0.17]), np.array([0.13, 0.4, 0.67])
    return np.where(share > 0, white + share * (red - white), white - share * (blue - white))


# ---- CSV ----


def write_csv(result, frames, folder):
    """particles.csv, contacts.csv, observables.csv of the frames, and one file a table."""
    chosen = list(frames)
    write_table(folder / "particles.csv", (particle_rows(result.frame(index)) for index in chosen))
    contacts = [index for index in chosen if index in result.frames_with_contacts]
    if contacts:
        write_table(folder / "contacts.csv", (contact_rows(result.frame(index)) for index in contacts))
    elif result.frames_with_contacts:  # of other frames: the file is there whichever are chosen
        write_table(folder / "contacts.csv", {"frame": [], "particle": [], "other": []})
    observables = {"time": result.time[chosen], **{name: values[chosen] for name, values in result.observables.items()}}
    write_table(folder / "observables.csv", {"frame": np.array(chosen), **spread(observables, result.terminals)})
    for name, table in result.tables.items():
        write_by_length(folder, name.replace("/", "-"), table)


def particle_rows(frame):
    """A row a particle."""
    count = frame.result.count
    columns = {name: frame[name] for name in frame.result.columns}
    return {"frame": np.full(count, frame.index), "particle": np.arange(count), **spread(columns, {})}


def contact_rows(frame):
    """A row a contact."""
    first, other = frame.contacts.T
    return {"frame": np.full(len(first), frame.index), "particle": first, "other": other}


def titled(name, values):
    return name if values.unit == "1" else f"{name} ({values.unit})"


def spread(table, labels):
    """Each [R] or [R, K] as K columns with their unit, called x, y, z where there are three, or by their labels."""
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
    """A number that is not defined (NaN) is an empty cell."""
    values = values.tolist() if isinstance(values, np.ndarray) else values
    return ["" if isinstance(value, float) and value != value else value for value in values]


# ---- Ensembles ----


def export_ensemble(source, to, out, frames, overwrite):
    """members.csv, a row a run, and points.csv, a row a setting with means and half widths of 95 % confidence; with -2 and so
    on of further sweeps in the folder."""
    tables = [path for path in sorted(Path(source).glob("ensemble*.json")) if path.is_file()]
    if not tables:
        raise InputError(f"{source} is a folder without ensemble.json: give a result file, or the folder of an ensemble")
    if to != "csv" or frames is not None:
        raise InputError(f"{source} is an ensemble, which has csv alone and no frames; its members are result files")
    out = out or default_output(source, "-csv")
    check_output(out, overwrite, folder=True)
    write_folder(out, "csv", lambda folder: write_ensemble(tables, folder))
    return out


def write_ensemble(tables, folder):
    for path in tables:
        ensemble = json.loads(path.read_text())
        for rows in ("members", "points"):
            write_records(folder / f"{rows}{path.stem.removeprefix('ensemble')}.csv", [flat(entry) for entry in ensemble[rows]])


def flat(entry, before=""):
    """Nested tables as one, the names of their keys joined by points."""
    record = {}
    for key, value in entry.items():
        record.update(flat(value, f"{before}{key}.") if isinstance(value, dict) else {before + key: value})
    return record


def write_records(path, records):
    titles = list(dict.fromkeys(key for record in records for key in record))
    write_table(path, {title: [record.get(title, "") for record in records] for title in titles})
