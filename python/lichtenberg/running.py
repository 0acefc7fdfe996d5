"""Runs of scenes in this process, frame by frame."""
import os
import shutil
import tempfile
import warnings
import weakref
from pathlib import Path

from . import core
from .array import Array
from .errors import Failure, InputError
from .files import created, refuse_scene
from .scene import check_device, scene_of


class RunFrame:
    """State of a run at one instant: frame.position, frame["charge"] and so on are arrays with units. They are made when the
    first of them is read. A frame that is not read before the run continues or fails has no arrays: to keep frames, read
    them, or use the run's result."""

    def __init__(self, run):
        self._run, self._number, self._arrays = run, run.count, None
        self.time, self.time_unit = run.time, run.time_unit

    @property
    def _columns(self):
        if self._arrays is None:
            if self._run.count != self._number:
                raise InputError(f"the run has left the frame at {in_words(self)}: read its arrays before the next frame")
            self._arrays = self._run.frame()
        return self._arrays

    @property
    def columns(self):
        """Names of the columns."""
        return list(self._columns)

    def __contains__(self, name):
        return name in self._columns

    def __iter__(self):
        return iter(self._columns)

    def __getstate__(self):
        return {**self.__dict__, "_run": None, "_arrays": self._columns}

    def __getitem__(self, name):
        if name not in self._columns:
            raise InputError(f"the frame has no {name}; it has {', '.join(self._columns)}")
        values, unit = self._columns[name]
        return Array(values, unit) if values.ndim else float(values)

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except (InputError, Failure) as error:
            raise AttributeError(str(error)) from None

    def __repr__(self):
        return f"<frame at {in_words(self)}>"


class Run:
    """A run of a scene in this process. It gives the same results as `lichtenberg run`, bit by bit.

    The first two arguments are those of Scene.

    out: result file that is written while the run goes on, as by the command, which can resume it. Without it the frames are
        in a temporary file, which is deleted with this object; save() copies it.

    record: False writes no file. Then save(), plot() and view() are refused.

    device: "cpu" or "cuda", in place of the scene's.

    A run is used by one thread at a time. Runs and solves of several threads compute one after another."""

    def __init__(self, scene, settings=None, *, out=None, record=True, overwrite=False, device=""):
        check_device(device)
        if out is not None and not record:
            raise InputError("record=False writes no file, so that out has no meaning")
        if overwrite and out is None:
            raise InputError("overwrite=True belongs to out")
        self.scene = scene_of(scene, settings)
        self._device, self._overwrite, self._functions, self._exchanges = device, overwrite, [], []
        self._run = self._every = self._process = None
        self._ended = False
        self._path = os.path.abspath(out) if out is not None else temporary_file(self) if record else None
        self.path_is_temporary = out is None

    def add_force(self, function):
        """Adds a force on the bodies. function(state) is called with time, position [N, d], momentum [N, d], mass [N],
        radius [N] and charge [N] (None without charges), in the scene's units. The arrays are copies. It returns forces
        [N, d], or a pair of the forces and their potential energy, which enters the energy balance. It is called several
        times in a step.

        Returns the function. Throws InputError after the first frame. A packing takes no further force: its run throws
        InputError. `lichtenberg run --resume` refuses a result of a run with Python forces."""
        if not callable(function):
            raise InputError(f"a force is a function, and {function!r} is none")
        if self._run:
            raise InputError("the run has begun: add forces before its first frame")
        self._functions.append(function)
        return function

    def add_charge_exchange(self, function, unit=1e-3):
        """Adds a law by which grains exchange charge at the beginning of a contact. function(contacts) is called after each
        step with new contacts. It gets time, pair [n, 2] (indices), impact_speed [n], direction [n, d] (unit vectors from
        the second grain to the first), and charge, radius and mass [n, 2], in the scene's units. It returns the charges [n]
        that the first grains receive from the second ones.

        unit: order of magnitude of such a charge. Charges are rounded to about 1e-9 of it, so that their sum is exact.

        Returns the function. Throws InputError after the first frame. A run of conductors or a packing throws InputError."""
        if not callable(function):
            raise InputError(f"a charge exchange is a function, and {function!r} is none")
        if self._run:
            raise InputError("the run has begun: add charge exchange before its first frame")
        self._exchanges.append((function, float(unit)))
        return function

    def frames(self, every=None):
        """Returns an iterator over the frame of the start, and one after each interval `every` (in the scene's unit of time;
        default: output.every), until the run ends. The scene's output.every becomes `every`. A further call continues the
        run. Throws InputError after the end, and in the iteration if the run was ended by save(), plot() or view()."""
        self._check_not_ended()
        if self._run and every is not None and every != self._every:
            raise InputError("the run has begun with another interval: give `every` at the first call of frames()")
        return self._frames(every)

    def _frames(self, every):
        if self._run is None:
            self._begin(every)
            yield self._frame()
        while not self._run.finished:
            self._check_not_ended()
            if not self._run.next():
                break
            yield self._frame()
        self._end()

    def finish(self, progress=False):
        """Runs to the end, without frames for Python. progress: show a bar, which needs the package tqdm. Returns the
        run."""
        self._check_not_ended()
        bar = progress_bar() if progress else None
        if self._run is None:
            self._begin(None)
        while self._run.next():
            if bar is not None:
                bar.total = self._run.end_time
                bar.update(self._run.time - bar.n)
        if bar is not None:
            bar.close()
        self._end()
        return self

    def save(self, path, overwrite=False):
        """Copies the result to a file and ends the run. `lichtenberg run --resume` can continue a run without Python forces
        that had not reached its end. Returns the path. Throws InputError if the file exists or cannot be written, before
        the first frame, and for a run with record=False."""
        path = os.path.abspath(path)
        if os.path.lexists(path) and not overwrite:
            raise InputError(f"{path} exists: give another name, or allow overwrite=True")
        refuse_scene(path, "give another name")
        recorded = self._recorded()
        if not self._run.is_in_one_file:
            raise InputError("the frames of this long run are in several files until its end: make the run with out=PATH")
        part = f"{path}.partial-{os.getpid()}"
        try:
            with open(recorded, "rb") as source, open(created(part), "wb") as copy:
                shutil.copyfileobj(source, copy)
            os.replace(part, path)
        except OSError as error:
            raise InputError(f"{path} cannot be written ({error.strerror})") from None
        finally:
            Path(part).unlink(missing_ok=True)
        return path

    @property
    def result(self):
        """The Result of the run so far, which ends the run."""
        from .result import load

        result = load(self._recorded())
        result.run = self  # keeps the temporary file
        return result

    def plot(self, **options):
        """Returns the picture of the last frame, as `lichtenberg plot`, whose options these are. Ends the run."""
        return self.result.plot(**options)

    def view(self, out, **options):
        """Writes the page of the run to the file `out`. Ends the run."""
        return self.result.view(out, **options)

    @property
    def time(self):
        """Time of the last frame; for a packing, the number of the iteration."""
        return self._run.time if self._run else 0.0

    @property
    def finished(self):
        """True if the run has reached its end."""
        return bool(self._run) and self._run.finished

    @property
    def summary(self):
        """Results of the whole run by name: pairs of value and unit. Empty until the run has reached its end."""
        return self._run.summary if self._run else {}

    @property
    def warnings(self):
        """Warnings of the run against use of the result."""
        return self._run.warnings if self._run else []

    def _begin(self, every):
        self._every, self._process = every, os.getpid()
        scene = self.scene if every is None else self.scene.changed({"output.every": every})
        prepared = scene._core
        for function in self._functions:
            prepared = prepared.with_force(function)
        for function, unit in self._exchanges:
            prepared = prepared.with_charge_exchange(function, unit)
        if self._device:
            prepared = prepared.on_device(self._device)
        self._run = core.load().Run(prepared, self._path or "", self._overwrite, warn)

    def _recorded(self):
        """Ends the run and returns its file."""
        if self._path is None:
            raise InputError("the run was made with record=False, so it has no file")
        if self._run is None:
            raise InputError("the run has not begun: call frames() or finish()")
        self._end()
        return self._path

    def _frame(self):
        return RunFrame(self._run)

    def _check_not_ended(self):
        if self._ended:
            raise InputError("the run has ended at its end, or by save(), plot(), view() or result: make another Run")
        if self._run and self._process != os.getpid():
            raise InputError("the run belongs to another process: make another Run in this one")

    def _end(self):
        if self._ended:
            return
        self._check_not_ended()
        if self._path is not None:
            self._run.end()
        self._ended = True

    def __repr__(self):
        state = "not begun" if self._run is None else f"at {in_words(self._run)}"
        return f"<run of {self.scene!r}, {state}>"

    def _repr_png_(self):
        return self.plot()._repr_png_() if self._path and self._ended else None


def run(scene, out, settings=None, *, overwrite=False, device=""):
    """Runs a scene as `lichtenberg run --out` does. Returns its Result."""
    from .result import load

    Run(scene, settings, out=out, overwrite=overwrite, device=device).finish()
    return load(out)


def temporary_file(owner):
    """Returns the path of a file in a new folder, which is deleted with its owner, but not by a forked process."""
    folder = tempfile.mkdtemp(prefix="lichtenberg-")
    weakref.finalize(owner, remove_in_process, folder, os.getpid())
    return str(Path(folder) / "run.h5")


def remove_in_process(folder, process):
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)


def in_words(state):
    """Returns the time of a frame or run as a text. The time of a packing is the number of its iteration, of unit 1."""
    return f"t = {state.time:.6g}{'' if state.time_unit == '1' else ' ' + state.time_unit}"


def warn(text):
    warnings.warn(text, stacklevel=4)


def progress_bar():
    try:
        from tqdm.auto import tqdm
    except ImportError:
        warnings.warn("there is no progress bar without the package tqdm", stacklevel=3)
        return None
    return tqdm(bar_format="{percentage:3.0f}% {bar} t = {n:.3g} of {total:.3g}")
