"""Files that are written: before the work, whether they may be, and then whole or not at all."""
import os
from pathlib import Path

from .errors import Failure, InputError


def default_output(path, suffix):
    return str(Path(path).with_suffix("")) + suffix


def check_output(path, overwrite, folder=False, otherwise="give --out another name", option="--overwrite"):
    """Before the work: throws InputError if the file (or folder) is there and is not to be replaced, or never may be, or if
    the folder that it is in is not there or cannot be written. `option`: of the command that allows to replace a file; empty
    without one."""
    parent = os.path.dirname(os.path.abspath(path))
    if not os.path.isdir(parent):
        raise InputError(f"{path} cannot be written: there is no folder {parent}")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise InputError(f"{path} cannot be written: folder {parent} may not be written")
    if not os.path.lexists(path):
        return
    kind, right_kind = ("folder", os.path.isdir) if folder else ("file", os.path.isfile)
    if os.path.islink(path) or not right_kind(path):
        raise InputError(f"{path} is no plain {kind}, and is left as it is: {otherwise}")
    if str(path).lower().endswith(".toml"):
        raise InputError(f"{path} is a scene, and is left as it is: {otherwise}")
    if not folder and holds_hdf5(path):
        raise InputError(f"{path} is a result, and is left as it is: {otherwise}")
    if not overwrite:
        raise InputError(f"{path} exists: {otherwise}" + (f", or allow {option}" if option else ""))


def holds_hdf5(path):
    import h5py  # which takes a while, and most files are new

    return h5py.is_hdf5(path)


def created(path):
    """A descriptor of a new, empty file. What has the name is left of a process of the same number, or somebody put a link
    there: it goes, and what it may lead to stays. Throws OSError."""
    Path(path).unlink(missing_ok=True)
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)


def write_whole(path, parts):
    """The file is there whole or not at all. Text, or texts one after the other. Throws Failure."""
    partial = f"{path}.partial-{os.getpid()}"
    try:
        with open(created(partial), "w", encoding="utf-8", newline="") as file:
            file.writelines([parts] if isinstance(parts, str) else parts)
        os.replace(partial, path)
    except OSError as error:
        raise Failure(f"{path} cannot be written ({error.strerror})") from None
    finally:
        Path(partial).unlink(missing_ok=True)
