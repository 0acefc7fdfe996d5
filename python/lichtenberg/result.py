"""Contents of a result file as numpy arrays with units (docs/reference/result-file.md describes the file)."""
import os
import re
import warnings
from functools import cached_property, wraps

import h5py
import numpy as np

from .array import Array
from .errors import InputError
from .ranges import colour_range
from .seal import check_seal

TO_GROUND, UNCONNECTED = -1, -2  # value in the column of successors
WITHOUT_CHECKSUMS = 1  # the format of the oldest results
GROUPS = ("gas", "relaxation", "packing", "analysis", "network/particle", "network/contact", "summary")  # groups of tables


def text_of(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def unit_of(dataset):
    return text_of(dataset.attrs.get("unit", "1"))


def value_of(element):
    """Returns the dataset of an H5MD element: `value` if it depends on time, else the element itself."""
    return element["value"] if isinstance(element, h5py.Group) else element


def warnings_of(file):
    """Returns the warnings of the run in an open file: a list of messages. Each states the problem up to the first ": ", then
    the limit and the remedy."""
    return [text_of(words) for words in file["summary"].attrs.get("warnings", [])] if "summary" in file else []


def field_of(file):
    """The potential of the last frame, [ny, nx]; None if the file has none."""
    if "VTKHDF/CellData/potential" in file:
        potential, (nx, ny) = file["VTKHDF/CellData/potential"], file["VTKHDF/cells"]
        return Array(potential[()].reshape(ny, nx), unit_of(potential))
    field = file.get("VTKHDF/PointData/potential")  # older files have it twice
    return None if field is None else Array(field[0], unit_of(field))


# Exceptions of h5py, numpy and Python that a damaged file can cause
DAMAGE = (ArithmeticError, AttributeError, LookupError, MemoryError, OSError, RuntimeError, TypeError, ValueError)


def names_damage(read):
    """Wraps `read` so that it throws InputError if the file is damaged."""

    @wraps(read)
    def checked(self, *arguments, **named):
        try:
            return read(self, *arguments, **named)
        except DAMAGE as error:
            raise InputError(f"{self.path} is damaged or incomplete ({damage(error)})") from None

    return checked


WRITERS = ("close", "plot", "view", "export", "_repr_png_", "__enter__", "__exit__")


def all_name_damage(kind):
    """Makes methods and properties of a class throw InputError if the file is damaged. WRITERS are excluded because
    they read nothing themselves."""
    for name, member in vars(kind).copy().items():
        if isinstance(member, property):
            setattr(kind, name, property(names_damage(member.fget)))
        elif isinstance(member, cached_property):
            member.func = names_damage(member.func)
        elif callable(member) and name not in WRITERS:
            setattr(kind, name, names_damage(member))
    return kind


class Frame:
    """One frame of a result: `frame["position"]` and so on are the arrays of this frame."""

    def __init__(self, result, index):
        self.result, self.index = result, index

    @property
    def time(self):
        """In units of result.time.unit; for a packing, the number of the iteration or load."""
        return float(self.result.time[self.index])

    @property
    def size(self):
        """[2] or [3] size of the domain in this frame: that of the load, if a packing has loads."""
        loads = [self.result.observables.get(f"size_{axis}") for axis in "xyz"[: self.result.dimension]]
        if loads[0] is None:
            return self.result.size
        return Array([sizes[self.index] for sizes in loads], loads[0].unit)

    def __getitem__(self, name):
        """[N] or [N, 3] values of a column of the particles. Throws InputError if the result has no such column."""
        return self.result.read_column(name, self.index)

    @property
    def contacts(self):
        """[E, 2] pairs of a particle and one of larger index, or of a particle and -1, the ground (for a packing, a
        wall from N on)."""
        return self.result.read_contacts(self.index)

    @property
    def tree(self):
        """[M, 2] each connected particle and the next one on its path to the ground, or -1 if that is the ground
        itself."""
        successor = np.asarray(self["successor"])
        connected = np.flatnonzero(successor != UNCONNECTED)
        return np.column_stack([connected, successor[connected]])

    def plot(self, **options):
        """Returns the picture of this frame, as Result.plot does."""
        return self.result.plot(frame=self.index, **options)

    def _repr_png_(self):
        return self.plot()._repr_png_()

    def __repr__(self):
        return f"<frame {self.index} of {self.result.path}: {self.time:.6g} {self.result.time.unit}>"


@all_name_damage
class Result:
    """Result file, open until `close()` or the end of its `with`. Data are read on access and no lock is taken, so that
    its run may continue. The frames are those present when the file was opened."""

    run = None  # the Run whose temporary file this is, so that the file exists as long as this object

    def __init__(self, path):
        self.path = str(path)
        self._identity = identity(self.path)
        self.sealed = check_seal(self.path)
        self._file = opened(self.path)
        check_result(self.file, self.path)
        self._ranges = {}

    @property
    def file(self):
        """The file as an h5py object. Throws InputError after close()."""
        if not self._file:
            raise InputError(f"{self.path} has been closed: load it again")
        return self._file

    def close(self):
        """Closes the file."""
        self._file.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __len__(self):
        """Returns the number of frames."""
        return len(self.file["particles/conductors/position/time"])

    def __iter__(self):
        return (self.frame(index) for index in range(len(self)))

    def __repr__(self):
        until = f"{self.time[-1]:.6g} {self.time.unit}"
        return f"<{self.path}: {self.title or 'untitled'}, {self.count} particles, {len(self)} frames until {until}>"

    def frame(self, index=-1):
        """Returns the frame of this index; a negative one counts from the end. Throws InputError if there is no such
        frame."""
        return Frame(self, checked_index(index, len(self), self.path))

    # Particles

    @property
    def columns(self):
        """Names of the columns of particles, time-dependent or constant."""
        return [name for name in self.file["particles/conductors"] if name != "box"]

    def colour_range(self, name):
        """Returns the lowest and highest value of the colour scale of the whole run (ranges.py)."""
        if name not in self._ranges:
            self._ranges[name] = colour_range(name, np.asarray(self[name]))
        return self._ranges[name]

    def changes(self, name):
        """Returns true if a column has one row per frame."""
        return isinstance(self._column(name), h5py.Group)

    def __getitem__(self, name):
        """[T, N] or [T, N, 3] values of a column in all frames, or [N] of a constant column; with the index of a
        frame, only that frame. Throws InputError."""
        if isinstance(name, (int, np.integer)):
            return self.frame(name)
        return self._read(value_of(self._column(name)))

    def read_column(self, name, index):
        """Returns the values of a column in the frame of this index, [N] or [N, 3]."""
        column = self._column(name)
        return self._read(value_of(column), index if self.changes(name) else ())

    def _column(self, name):
        if name not in self.columns:
            raise InputError(f"{self.path} has no {name} of particles; it has {', '.join(self.columns)}")
        return self.file["particles/conductors"][name]

    def _read(self, dataset, selection=()):
        stored = dataset.id.get_storage_size()
        # The compression ratio of Deflate is at most 1032; a larger size in a damaged file would fill the memory.
        if selection == () and not dataset.is_virtual and dataset.nbytes > 1032 * stored + 2**20:
            raise InputError(f"{self.path} is damaged ({dataset.name} claims {dataset.nbytes} bytes, and {stored} are stored)")
        values = Array(dataset[selection], unit_of(dataset))
        # The rows of an index of segments are gone, and read as fill values, once its run has made one file of them.
        if "segments" in self.file and identity(self.path) != self._identity:
            raise InputError(f"{self.path} was replaced by its run: load it again")
        return values

    @cached_property
    def time(self):
        """[T] times of the frames."""
        times = self.file["particles/conductors/position/time"]
        return Array(times[()], unit_of(times))

    @cached_property
    def scales(self):
        """Reduced units of a scene of grains in SI: d0 (m), m0 (kg), v0 (m/s), q0 (C) and t0 (s), by name. For other
        results it is empty. Array.in_si takes it."""
        return {name: float(scale[()].item()) for name, scale in self.file.get("reference", {}).items()}

    @cached_property
    def count(self):
        """Number of particles."""
        return len(self.file["particles/conductors/radius"])

    @property
    def dimension(self):
        """2 for a plane scene, 3 for one in space."""
        domain = self.file["scene/domain"]
        return 3 if "height" in domain else len(domain["size"])

    @cached_property
    def size(self):
        """[2] or [3] size of the domain of the scene, whose lower corner is the origin. Loads change it: Frame.size."""
        domain = self.file["scene/domain"]
        lengths = [*domain["size"][()]]
        if len(lengths) < self.dimension:  # older files store the third component separately
            lengths.append(domain["height"][()])
        return Array(lengths, unit_of(domain["size"]))

    @cached_property
    def periodic(self):
        """[3] True for periodic axes."""
        return [text_of(kind) == "periodic" for kind in self.file["particles/conductors/box"].attrs["boundary"]]

    @property
    def down(self):
        """[3] Unit vector of gravity's direction; None without gravity, and for older files."""
        return self.file["scene"].attrs.get("down")

    def read_contacts(self, index):
        """Returns [E, 2] contacts of the frame of this index (Frame.contacts). Throws InputError if it has none."""
        if index not in self.frames_with_contacts:
            raise InputError(f"{self.path} has no contacts of frame {index}")
        network = self.file.get("network", {})
        if "contacts_of_all_frames" in network:
            end = network["contacts_end"][()]
            begin = end[index - 1] if index > 0 else 0
            return np.asarray(self._read(network["contacts_of_all_frames"], slice(begin, end[index])))
        return network["contacts"][()] if "contacts" in network else self.file["packing/contacts"][()]

    @property
    def frames_with_contacts(self):
        """Indices of the frames with contacts: all, for a packing the last only, or none."""
        if "network/contacts_of_all_frames" in self.file:
            return range(len(self))
        has_last = "network/contacts" in self.file or "packing/contacts" in self.file
        return range(len(self) - 1, len(self)) if has_last else range(0)

    # Other contents

    @cached_property
    def observables(self):
        """Observables by name, [T] or [T, K], one row per frame."""
        return {name: self._read(value_of(data)) for name, data in self.file.get("observables", {}).items()}

    @cached_property
    def terminals(self):
        """For each observable with K values per frame, their names."""
        named = self.file.get("observables", {}).items()
        return {name: [text_of(word) for word in data.attrs["terminals"]] for name, data in named if "terminals" in data.attrs}

    @cached_property
    def tables(self):
        """Tables by name, each with its columns by name: gas, relaxation, packing, analysis, summary, networks."""
        return {name: self._table(self.file[name]) for name in GROUPS if name in self.file}

    def _table(self, group):
        return {name: self._read(data) for name, data in group.items() if isinstance(data, h5py.Dataset)}

    @property
    def summary(self):
        """Results of the whole run by name; empty until the run has ended."""
        return {name: float(value) for name, value in self.tables.get("summary", {}).items()}

    @property
    def warnings(self):
        """Warnings of the run against use of the result: a list of messages."""
        return warnings_of(self.file)

    @property
    def field(self):
        """The potential of the last frame, [ny, nx] at the centres of square cells from the domain's lower left
        corner on; None if the file has none."""
        return field_of(self.file)

    @property
    def field_cell(self):
        """Edge length of a cell of the field (m)."""
        grid = self.file["VTKHDF"]
        return float(grid["cell_edge"][()] if "cell_edge" in grid else grid.attrs["Spacing"][0])

    @property
    def changed(self):
        """True if another program has changed the file after its run."""
        return not self.sealed and bool(self.file.attrs["lichtenberg_result"] != WITHOUT_CHECKSUMS)

    @property
    def title(self):
        """Title of the scene."""
        return text_of(self.file["scene"].attrs["title"])

    @property
    def scene(self):
        """The scene's text, as the run read it."""
        return text_of(self.file["scene/text"][()])

    @property
    def provenance(self):
        """A list with one entry for the start and for each `--resume`: version, commit, machine, command line and so
        on."""
        sessions = self.file["provenance"]
        ordered = sorted(sessions, key=lambda name: int(name.split("-")[1]))
        return [{key: plain(value) for key, value in sessions[name].attrs.items()} for name in ordered]

    # Pictures, pages and exports

    def plot(self, frame=None, **options):
        """Returns the picture that `lichtenberg plot` draws, for display in Jupyter. The options are those of the
        command, as colour="charge"."""
        from .program import plot

        return plot(self.path, frame, options)

    def _repr_png_(self):
        return self.plot()._repr_png_()

    def view(self, out=None, frames=None, overwrite=False, **options):
        """Writes an HTML page that shows the run (`lichtenberg view`). The options are those of the command, as
        colour="charge". Returns its path."""
        from .files import default_output
        from .program import call, options_of

        self._check_out(out)
        out = out or default_output(self.path, ".html")
        call("view", *options_of({"out": out, "frames": frames, "overwrite": overwrite, **options}), "--", self.path)
        return out

    def export(self, to, out=None, frames=None, overwrite=False):
        """Writes the formats "vtk", "xyz" or "csv" (export.py). Returns the path of the file or folder."""
        from .export import export

        self._check_out(out)
        return export(self, to, out, frames, overwrite)

    def _check_out(self, out):
        if out is None and self.run is not None and self.run.path_is_temporary:
            raise InputError("the result is in a temporary file: name the output by out=PATH")


def load(path):
    """Returns the Result in the file. Throws InputError. Warns if another program has changed the file."""
    if not isinstance(path, (str, os.PathLike)):
        raise InputError(f"{path!r} is no path of a result file")
    result = Result(path)
    if result.changed:
        warnings.warn(f"{path} was changed by another program after its run: no checksum vouches for it", stacklevel=2)
    return result


def plain(value):
    return value.item() if isinstance(value, np.generic) else text_of(value)


def identity(path):
    try:
        status = os.stat(path)
    except OSError as error:
        reason = "does not exist" if isinstance(error, FileNotFoundError) else f"cannot be read ({error.strerror})"
        raise InputError(f"{path} {reason}") from None
    return status.st_ino, status.st_mtime_ns


def opened(path):
    """Opens a result file without a lock. If this process has it open with a lock, HDF5 requires a lock again. Throws
    InputError."""
    if os.path.exists(path) and not os.path.isfile(path):
        raise InputError(f"{path} is no file: name a result file")
    for options in ({"locking": False}, {}):
        try:
            return h5py.File(path, "r", **options)
        except OSError as error:
            reason = error
            if "locking flag" not in str(error):
                break
    raise InputError(f"{path} cannot be read as an HDF5 file ({reason})")


def check_result(file, path):
    """Throws InputError if a file lacks an entry that all results have."""
    if "lichtenberg_result" not in file.attrs:
        raise InputError(f"{path} was not written by `lichtenberg run`")
    times = "particles/conductors/position/time"
    if times not in file or len(file[times]) == 0:
        raise InputError(f"{path} holds no frames")
    for name in ("scene", "scene/text", "scene/domain/size", "particles/conductors/radius"):
        if name not in file:
            raise InputError(f"{path} is damaged or incomplete: /{name} is missing")
    rows = file["particles/conductors/radius"].shape
    for name, column in file["particles/conductors"].items():
        dataset = column.get("value") if isinstance(column, h5py.Group) else column
        expected = file[times].shape + rows if isinstance(column, h5py.Group) else rows
        if name != "box" and dataset is not None and dataset.shape[: len(expected)] != expected:
            raise InputError(f"{path} is damaged: {name} has not one row for each particle")


def damage(error):
    """Returns the cause of an exception in words."""
    missing = re.search(r"object '([^']*)' doesn't exist|component not found", str(error))
    return f"{missing[1] or 'a part of it'} is missing" if missing else str(error) or type(error).__name__


def checked_index(index, count, path):
    if isinstance(index, bool) or not hasattr(index, "__index__"):
        raise InputError(f"frame {index!r} is no whole number: {path} has frames 0 to {count - 1}")
    if not -count <= index < count:
        raise InputError(f"frame {index} is not in {path}: it has frames 0 to {count - 1}")
    return index % count


def chosen_frames(result, written):
    """Returns the ascending indices of the frames in a list such as "0,5,10:20,30:90:10"; all frames for None.
    Throws InputError."""
    if written is None:
        return range(len(result))
    return sorted(set(listed_frames(str(written), result.path, len(result))))


def listed_frames(written, path, count):
    """Returns the indices of a list in the order in which they are written. The list has single frames, and
    FIRST:LAST:STEP with LAST included, where FIRST and LAST default to the first and last frame. Throws InputError
    unless all are frames of `path`, which has `count`."""

    def number(word, default=None):
        if word == "" and default is not None:
            return default
        if not re.fullmatch("-?[0-9]+", word):
            raise InputError(f"`{word}` is not a frame: give indices and ranges, as in --frames 0,5,10:20,30:90:10")
        if not 0 <= int(word) < count:
            raise InputError(f"frame {word} is not in {path}: it has frames 0 to {count - 1}")
        return int(word)

    def part_of(part):
        words = part.split(":")
        if len(words) > 3:
            raise InputError(f"--frames {written}: `{part}` has more than FIRST:LAST:STEP")
        first = number(words[0], 0 if len(words) > 1 else None)
        last = number(words[1], count - 1) if len(words) > 1 else first
        if last < first:
            raise InputError(f"--frames {written}: {part} is reversed: the first frame must come first")
        step = words[2] if len(words) > 2 else "1"
        if not re.fullmatch("0*[1-9][0-9]*", step):
            raise InputError(f"--frames {written}: the step `{step}` must be a whole number from 1 on")
        return range(first, last + 1, int(step))

    return [frame for part in written.split(",") for frame in part_of(part)]
