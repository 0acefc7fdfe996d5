"""Writes a result in the formats of other programs (formats/)."""
import contextlib
import errno
import json
import os
import shutil
from pathlib import Path

from .formats import formats
from .formats.csv import write_table
from .errors import Failure, InputError
from .files import check_output, default_output, write_whole
from .result import chosen_frames, load


def export(source, to, out=None, frames=None, overwrite=False):
    """Writes a Result in the format `to` (formats/). `source` may also be the path of a result file or of an ensemble's folder.
    Returns the path of the file or folder that was written. Throws InputError and Failure."""
    if to not in formats:
        raise InputError(f"there is no format {to}: it is one of {', '.join(formats)}")
    if isinstance(source, (str, os.PathLike)):
        if os.path.isdir(source):
            return export_ensemble(source, to, out, frames, overwrite)
        with load(source) as result:
            return export(result, to, out, frames, overwrite)
    chosen = chosen_frames(source, frames)
    kind = formats[to]
    out = out or default_output(source.path, kind.ENDING)
    check_output(out, overwrite, folder=kind.IS_FOLDER)
    if kind.IS_FOLDER:
        write_folder(out, to, lambda folder: kind.write(source, chosen, folder))
    else:
        kind.write(source, chosen, out)
    return out


def write_folder(out, to, write):
    """Writes a folder completely or not at all. In an existing folder it replaces the files that it writes and those
    that an earlier export listed. Throws InputError for a folder with any other contents."""
    out = Path(out)  # without a slash at the end
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
    """Throws InputError unless the folder contains only plain files."""
    try:
        entries = list(os.scandir(folder))
    except FileNotFoundError:
        return
    for entry in entries:
        if not entry.is_file(follow_symlinks=False):
            raise InputError(f"{folder} holds {entry.name}, which is no plain file and no part of an export: give --out another name")


def check_replaced(folder, to, written):
    """Throws InputError if the folder contains a file that is neither among those `written` nor listed there by an
    earlier export."""
    check_plain(folder)
    known = written | (formats[to].earlier_files(folder) if folder.is_dir() else set())
    strange = sorted(set(os.listdir(folder)) - known) if folder.is_dir() else []
    if strange:
        raise InputError(f"{folder} holds {strange[0]}, which this export to {to} does not write: give --out another name")


def replace_folder(out, partial, before):
    """Replaces the folder `out` by `partial` and removes the old files. Files that others added in the meantime stay in
    `before`. Throws Failure if another export puts its folder there first; that folder stays."""
    try:
        names = os.listdir(out)
        os.rename(out, before)
    except FileNotFoundError:  # there is no such folder, or another export is replacing it
        names = None
    try:
        os.rename(partial, out)
    except BaseException as error:
        if isinstance(error, OSError) and error.errno in (errno.EEXIST, errno.ENOTEMPTY):
            remove_files(before, names)
            raise Failure(f"{out} was written by another export at the same time, whose files stay") from None
        if names is not None:
            os.rename(before, out)
        raise
    remove_files(before, names)


def remove_files(folder, names):
    """Removes these files of the folder, and the folder if it is then empty. None: there is no folder."""
    if names is None:
        return
    for name in names:
        (folder / name).unlink(missing_ok=True)
    with contextlib.suppress(OSError):
        os.rmdir(folder)


def make_folder(path):
    """Creates a folder. Throws Failure, also if it exists."""
    try:
        if os.path.islink(path):  # files would go to where it leads
            os.unlink(path)
        path.mkdir()
    except OSError as error:
        raise Failure(f"{path} cannot be made ({error.strerror})") from None


# ---- Ensembles ----


def export_ensemble(source, to, out, frames, overwrite):
    """Writes members.csv (one row per run) and points.csv (one row per setting, with means and half widths of the 95
    % confidence intervals). Files of further sweeps in the folder have names with -2 and so on."""
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
        ensemble = json.loads(path.read_text(encoding="utf-8"))
        for rows in ("members", "points"):
            write_records(folder / f"{rows}{path.stem.removeprefix('ensemble')}.csv", [flat(entry) for entry in ensemble[rows]])


def flat(entry, before=""):
    """Flattens nested tables into one; the names of their keys are joined by dots."""
    record = {}
    for key, value in entry.items():
        record.update(flat(value, f"{before}{key}.") if isinstance(value, dict) else {before + key: value})
    return record


def write_records(path, records):
    titles = list(dict.fromkeys(key for record in records for key in record))
    write_table(path, {title: [record.get(title, "") for record in records] for title in titles})
