"""Draws the frames of a result file on all cores and has ffmpeg make an mp4 of them."""
import multiprocessing
import os
import signal
import subprocess
import time

from ..errors import Failure
from ..result import listed_frames
from . import drawing, frames
from .drawing import InputError, messages
from .fields import Fields

DPI = 170
CRF = "20"  # quality of ffmpeg's x264: hardly visible loss


class FigureContext:
    """Data that each process needs to draw frames."""

    def __init__(self, run, colour, scale):
        self.pictures = frames.Pictures([run], scale, colour)
        self.fields = None
        self.figure = self.pictures.layout.figure
        self.figure.set_dpi(DPI)
        # x264 needs even numbers of pixels.
        even = [2 * round(inches * DPI / 2) / DPI + 1e-6 for inches in self.figure.get_size_inches()]
        self.figure.set_size_inches(even)
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        self.canvas = FigureCanvasAgg(self.figure)

    @property
    def pixels(self):
        return self.canvas.get_width_height()

    def draw(self, index, frame):
        """Returns the pixels of a frame, RGBA. `index`: its index among the chosen frames."""
        self.pictures.draw([frame], None if self.fields is None else [self.fields[index]])
        self.canvas.draw()
        return bytes(self.canvas.buffer_rgba())


context = None  # one per process


def draw(task):
    """Returns the frame or an error message, because exceptions of other processes lose their text."""
    try:
        return context.draw(*task)
    except InputError as error:
        return str(error)


class Ffmpeg:
    """Passes frames to ffmpeg and writes a film completely or not at all."""

    def __init__(self, path, pixels, rate):
        self.path, self.partial = path, f"{path}.partial-{os.getpid()}"
        size = f"{pixels[0]}x{pixels[1]}"
        frames = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", size, "-r", f"{rate:g}", "-i", "-"]
        film = ["-c:v", "libx264", "-crf", CRF, "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4"]
        # With file:, because a name may contain a colon, which would denote a protocol.
        command = ["ffmpeg", "-y", "-loglevel", "error", *frames, *film, f"file:{self.partial}"]
        try:
            os.close(drawing.created(self.partial))
        except OSError as error:
            raise Failure(f"{path} cannot be written ({error.strerror})") from None
        try:
            self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        except FileNotFoundError:
            raise Failure("there is no ffmpeg, which makes films of pictures: install Debian's package ffmpeg") from None

    def add(self, picture):
        try:
            self.process.stdin.write(picture)
        except BrokenPipeError:
            self.finish()

    def finish(self):
        _, words = self.process.communicate()
        if self.process.returncode != 0:
            self.drop()
            raise Failure(f"{self.path} cannot be made: ffmpeg says {words.decode(errors='replace').strip()[-300:]}")
        os.replace(self.partial, self.path)

    def drop(self):
        self.process.kill()
        self.process.wait()
        if os.path.exists(self.partial):
            os.remove(self.partial)


class Progress:
    """Progress line on standard error: rewritten on a terminal, else printed every ten seconds."""

    def __init__(self, count, quiet):
        self.count, self.quiet = count, quiet
        self.terminal = os.isatty(2)
        self.began = self.shown = time.monotonic()

    def show(self, done):
        now = time.monotonic()
        if self.quiet or now - self.shown < (0.1 if self.terminal else 10):
            return
        self.shown = now
        line = f"frame {done} of {self.count} drawn"
        if 10 * done >= self.count:  # earlier estimates are too inaccurate
            line += f", about {(now - self.began) * (self.count - done) / done:.0f} s left"
        messages.write_error(f"\r{line}\033[K" if self.terminal else f"{line}\n", end="")

    def end(self):
        if self.terminal and not self.quiet:
            messages.write_error("\r\033[K", end="")


def undisturbed_pool(jobs):
    """Returns a pool of processes that ignore interruptions; this process handles them and ends the pool."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return multiprocessing.get_context("fork").Pool(jobs)
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def make(request):
    """Makes the film of a request of `lichtenberg film`. Throws InputError and Failure."""
    global context
    run = frames.read_run(request.result)
    chosen = listed_frames(request.frames or ":", run.path, len(run.times))
    frames.set_cut([run], request.cut)
    colour = request.colour or frames.default_colour([run], [chosen[len(chosen) // 2]])
    scale = frames.common_scale([run], colour, request.range, request.cmap)
    fields = Fields(run.path, chosen, request.quiet or not os.isatty(2)) if colour == "potential" else None
    context = FigureContext(run, colour, scale)
    context.fields = fields and fields.values()
    film = Ffmpeg(request.out, context.pixels, request.rate)
    write(film, chosen, Progress(len(chosen), request.quiet))
    if not request.quiet:
        words = f"{len(chosen)} frame{'s' * (len(chosen) > 1)}{' by ' + colour if colour else ''}"
        messages.say(f"{request.out} shows {words} in {len(chosen) / request.rate:.3g} s")


def write(film, chosen, progress):
    """Writes the film completely or not at all."""
    try:
        with undisturbed_pool(min(len(os.sched_getaffinity(0)), len(chosen))) as pool:
            for done, picture in enumerate(pool.imap(draw, enumerate(chosen)), 1):
                if isinstance(picture, str):
                    raise InputError(picture)
                film.add(picture)
                progress.show(done)
    except BaseException:
        film.drop()
        raise
    finally:
        progress.end()
    film.finish()
