#!/usr/bin/python3
"""Draws the frames of a result file on all cores and has ffmpeg make an mp4 of them.

    film.py FILE --out FILM.mp4 [--frames 0,5,10] [--rate 15] [--colour NAME] [--range LOW,HIGH] [--cmap NAME]
            [--cut z=0.01] [--fields FILE] [--overwrite] [--quiet]

Exit status 2 and one sentence for input that cannot be used.
"""
import interrupted  # before all else

import argparse
import multiprocessing
import os
import signal
import subprocess
import sys
import time

import drawing
import plot
from drawing import InputError, messages

DPI = 170
CRF = "20"  # ffmpeg's x264: hardly to be told from the frames


class Studio:
    """What each process draws with."""

    def __init__(self, request, colour, scale):
        run = plot.read_run(request.file)
        plot.set_cut([run], request.cut)
        self.pictures = plot.Pictures([run], scale, colour)
        self.fields = plot.read_fields(request.fields)
        self.figure = self.pictures.sheet.figure
        self.figure.set_dpi(DPI)
        even = [2 * round(inches * DPI / 2) / DPI + 1e-6 for inches in self.figure.get_size_inches()]  # as x264 wants
        self.figure.set_size_inches(even)
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        self.canvas = FigureCanvasAgg(self.figure)

    @property
    def pixels(self):
        return self.canvas.get_width_height()

    def draw(self, place, frame):
        """The pixels of a frame, RGBA. `place`: which of those that are drawn."""
        self.pictures.draw([frame], None if self.fields is None else [self.fields[place]])
        self.canvas.draw()
        return bytes(self.canvas.buffer_rgba())


studio = None  # of this process


def draw(task):
    """The frame, or a sentence why there is none: exceptions of other processes lose theirs."""
    try:
        return studio.draw(*task)
    except InputError as error:
        return str(error)


class Ffmpeg:
    """Takes frames and leaves a film, whole or not at all."""

    def __init__(self, path, pixels, rate):
        self.path, self.partial = path, f"{path}.partial-{os.getpid()}"
        size = f"{pixels[0]}x{pixels[1]}"
        frames = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", size, "-r", f"{rate:g}", "-i", "-"]
        film = ["-c:v", "libx264", "-crf", CRF, "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4"]
        command = ["ffmpeg", "-y", "-loglevel", "error", *frames, *film, f"file:{self.partial}"]  # a name with a colon is no protocol
        try:
            os.close(drawing.created(self.partial))
        except OSError as error:
            raise InputError(f"{path} cannot be written ({error.strerror})") from None
        try:
            self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        except FileNotFoundError:
            raise InputError("there is no ffmpeg, which makes films of pictures: install Debian's package ffmpeg") from None

    def add(self, picture):
        try:
            self.process.stdin.write(picture)
        except BrokenPipeError:
            self.finish()

    def finish(self):
        _, words = self.process.communicate()
        if self.process.returncode != 0:
            self.drop()
            raise InputError(f"{self.path} cannot be made: ffmpeg says {words.decode(errors='replace').strip()[-300:]}")
        os.replace(self.partial, self.path)

    def drop(self):
        self.process.kill()
        self.process.wait()
        if os.path.exists(self.partial):
            os.remove(self.partial)


class Progress:
    """A line on standard error, redrawn on a terminal, else every ten seconds."""

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
        if 10 * done >= self.count:  # before that nobody knows
            line += f", about {(now - self.began) * (self.count - done) / done:.0f} s left"
        messages.tell(f"\r{line}\033[K" if self.terminal else f"{line}\n", end="")

    def end(self):
        if self.terminal and not self.quiet:
            messages.tell("\r\033[K", end="")


def undisturbed_pool(jobs):
    """Processes that leave an interruption to this one, which ends them."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return multiprocessing.get_context("fork").Pool(jobs)
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def make(request):
    global studio
    drawing.check_output(request.out, request.overwrite)
    run = plot.read_run(request.file)
    last = len(run.times) - 1
    frames = [int(k) for k in request.frames.split(",")] if request.frames else list(range(last + 1))
    plot.set_cut([run], request.cut)
    middle = frames[len(frames) // 2]
    colour = request.colour or plot.default_colour([run], [middle])
    studio = Studio(request, colour, plot.common_scale([run], colour, request))
    jobs = min(len(os.sched_getaffinity(0)), len(frames))
    film = Ffmpeg(request.out, studio.pixels, request.rate)
    progress = Progress(len(frames), request.quiet)
    try:
        with undisturbed_pool(jobs) as pool:
            for done, picture in enumerate(pool.imap(draw, enumerate(frames)), 1):
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
    if not request.quiet:
        seconds = len(frames) / request.rate
        words = f"{len(frames)} frame{'s' * (len(frames) > 1)}{' by ' + colour if colour else ''}"
        messages.say(f"{request.out} shows {words} in {seconds:.3g} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="result file of a run (.h5)")
    parser.add_argument("--out", required=True, help="film to write, .mp4")
    parser.add_argument("--frames", help="indices, from 0, separated by commas (default: all)")
    parser.add_argument("--rate", type=float, default=15, help="frames a second")
    parser.add_argument("--colour", "--color", help="what particles are coloured by")
    parser.add_argument("--range", help="LOW,HIGH: of the colours")
    parser.add_argument("--cmap", help="matplotlib's name of a colour map")
    parser.add_argument("--cut", help="AXIS=PLACE: of a scene in space what lies behind")
    parser.add_argument("--fields", help="potentials of the frames")
    parser.add_argument("--overwrite", action="store_true", help="replace the film if it exists")
    parser.add_argument("--quiet", action="store_true", help="show no progress")
    request = parser.parse_args()
    return drawing.report(request.file, lambda: make(request))


if __name__ == "__main__":
    sys.exit(main())
