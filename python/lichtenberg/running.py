"""Runs of scenes in this process, frame by frame."""
import shutil
import tempfile
import warnings
import weakref
from pathlib import Path

from . import core
from .array import Array
from .errors import InputError
from .scene import scene_of


class RunFrame:
    """State of a run at one instant: frame.position, frame["charge"] and so on are arrays with units."""

    def __init__(self, time, time_unit, columns):
        self.time, self.time_unit = time, time_unit
        self._columns = columns

    @property
    def columns(self):
        """Names of the columns."""
        return list(self._columns)

    def __getitem__(self, name):
        if name not in self._columns:
            raise InputError(f"the frame has no {name}; it has {', '.join(self._columns)}")
        values, unit = self._columns[name]
        return Array(values, unit) if values.ndim else float(values)

    def __getattr__(self, name):
        if name.startswith("_") or name not in self._columns:
            raise AttributeError(f"the frame has no {name!r}; it has {', '.join(self.__dict__.get('_columns', {}))}")
        return self[name]

    def __repr__(self):
        return f"<frame at t = {self.time:.6g} {self.time_unit}: {', '.join(self._columns)}>"


class Run:
    """A run of a scene in this process. It gives the same results, bit by bit, as `lichtenberg run`.

    scene, settings: as for Scene. record: keep the frames, for save(), plot() and view(). They are written to a temporary
    file meanwhile. device: "cpu" or "cuda", in place of the scene's. A run is used by one thread at a time."""

    def __init__(self, scene, settings=None, *, record=True, device=""):
        self.scene = scene_of(scene, settings)
        self._record, self._device, self._functions = record, device, []
        self._run = self._folder = self._every = None
        self._saved = False
        self.path = None

    def add_force(self, function):
        """Adds a force on the bodies. function(state) is called with time, position [N, d], momentum [N, d], mass [N],
        radius [N] and charge [N] (None without charges), in the scene's units. It returns forces [N, d], or a pair of the
        forces and their potential energy, which enters the energy balance. It may be called several times in a step.
        Returns the function. Throws InputError after the run has begun."""
        if not callable(function):
            raise InputError(f"a force is a function, and {function!r} is none")
        if self._run:
            raise InputError("the run has begun: add forces before its first frame")
        self._functions.append(function)
        return function

    def frames(self, every=None):
        """Yields the frame of the start, and one after each interval `every` (in the scene's unit of time; default:
        output.every), until the run ends. The scene's output.every becomes `every`. A further call continues the run."""
        if self._saved:
            raise InputError("the run has ended: make another Run from its scene")
        if self._run is None:
            self._begin(every)
            yield self._frame()
        elif every is not None and every != self._every:
            raise InputError("the run has begun with another interval: give `every` at the first call of frames()")
        while not self._saved and self._run.next():
            yield self._frame()
        self._finish()

    def finish(self, progress=False):
        """Runs to the end. progress: show a bar, if tqdm is installed. Returns the run."""
        bar = progress_bar() if progress else None
        for frame in self.frames():
            if bar is not None:
                bar.total = self._run.end_time
                bar.update(frame.time - bar.n)
        if bar is not None:
            bar.close()
        return self

    def save(self, path, overwrite=False):
        """Writes the result file and ends the run. `lichtenberg run --resume` can continue a run that had not reached its
        end. Returns the path. Throws InputError if the file exists, or if the run was made with record=False."""
        if not self._record:
            raise InputError("the run was made with record=False, so it has no frames to save")
        path = Path(path)
        if path.exists() and not overwrite:
            raise InputError(f"{path} exists: give another name, or give overwrite=True")
        if self._run is None:
            self._begin(None)
        self._finish()
        try:
            shutil.copyfile(self._file(), path)
        except OSError as error:
            raise InputError(f"{path} cannot be written ({error.strerror})") from None
        self.path = str(path)
        return self.path

    @property
    def result(self):
        """The Result of the run so far, which ends the run."""
        from .result import load

        if self.path:
            return load(self.path)
        if not self._record:
            raise InputError("the run was made with record=False, so it has no result")
        if self._run is None:
            self._begin(None)
        self._finish()
        return load(self._file())

    def plot(self, **options):
        """Returns the picture of the last frame, as `lichtenberg plot`, whose options these are. Ends the run."""
        return self.result.plot(**options)

    def view(self, out, **options):
        """Writes the page of the run to the file `out`. Ends the run."""
        return self.result.view(out, **options)

    @property
    def time(self):
        """Time of the present instant; for a packing, the number of the iteration."""
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
        self._every = every
        scene = self.scene if every is None else self.scene.changed({"output.every": every})
        prepared = scene._core
        for function in self._functions:
            prepared = prepared.with_force(function)
        if self._device:
            prepared = prepared.on_device(self._device)
        if self._record:
            self._folder = tempfile.mkdtemp(prefix="lichtenberg-")
            weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
        self._run = core.load().Run(prepared, self._file() if self._record else "", False, warn)
        self._run.begin()

    def _file(self):
        return str(Path(self._folder) / "run.h5")

    def _frame(self):
        return RunFrame(self._run.time, self._run.time_unit, self._run.frame())

    def _finish(self):
        if self._saved:
            return
        self._saved = True
        if self._run.finished:
            self._run.end()
        elif self._record:
            self._run.stop()

    def __repr__(self):
        state = "not begun" if self._run is None else f"at t = {self.time:.6g} {self._run.time_unit}"
        return f"<run of {self.scene!r}, {state}>"

    def _repr_png_(self):
        return self.plot()._repr_png_() if self._record and self._saved else None


def warn(text):
    warnings.warn(text, stacklevel=4)


def progress_bar():
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm(bar_format="{percentage:3.0f}% {bar} t = {n:.3g} of {total:.3g}")
