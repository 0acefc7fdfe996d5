"""Output files: checks before the work, and writing that leaves a whole file or none."""
import os
from pathlib import Path

from .errors import Failure, InputError


def default_output(path, suffix):
    return str(Path(path).with_suffix("")) + suffix


def check_output(path, overwrite, folder=False, otherwise="give --out another name", option="--overwrite"):
    """Throws InputError if the file (or folder) exists and must not be replaced, or if its parent folder is missing
    or not writable. `option`: the command's option that allows a file to be replaced; empty if there is none."""
    parent = os.path.dirname(os.path.abspath(path))
    if not os.path.isdir(parent):
        raise InputError(f"{path} cannot be written: there is no folder {parent}")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise InputError(f"{path} cannot be written: folder {parent} may not be written")
    if not os.path.lexists(path):
        return
    kind, right_kind = ("folder", os.path.isdir) if folder else ("file", os.path.isfile)
    if os.path.islink(path) or not right_kind(path):
        raise InputError(f"{path} is no plain {kind} and is not overwritten: {otherwise}")
    refuse_scene(path, otherwise)
    if not folder and holds_hdf5(path):
        raise InputError(f"{path} is an HDF5 file, as results are, and is not overwritten: {otherwise}")
    if not overwrite:
        raise InputError(f"{path} exists: {otherwise}" + (f", or give {option}" if option else ""))


def refuse_scene(path, otherwise):
    """Throws InputError if an existing file is a scene by its name."""
    if os.path.lexists(path) and str(path).lower().endswith(".toml"):
        raise InputError(f"{path} ends in .toml as scenes do and is not overwritten: {otherwise}")


def holds_hdf5(path):
    import h5py  # the check takes time, and most files are new

    return h5py.is_hdf5(path)


def created(path):
    """Returns a descriptor of a new, empty file. A file or link of this name, which an earlier process with the same
    number left, is removed; the target of a link stays. Throws OSError."""
    Path(path).unlink(missing_ok=True)
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)


def write_whole(path, parts):
    """Writes a file completely or not at all. `parts`: a text, or several that are written in sequence. Throws
    Failure."""
    partial = f"{path}.partial-{os.getpid()}"
    try:
        with open(created(partial), "w", encoding="utf-8", newline="") as file:
            file.writelines([parts] if isinstance(parts, str) else parts)
        os.replace(partial, path)
    except OSError as error:
        raise Failure(f"{path} cannot be written ({error.strerror})") from None
    finally:
        Path(partial).unlink(missing_ok=True)
