"""Printed messages. A stream that cannot be written (full disk, closed pipe or descriptor) does not end the process."""
import os
import signal
import sys

from .errors import Failure


def open_closed_descriptors():
    """Opens closed standard streams on /dev/null. Otherwise a file could get such a descriptor, and with it printed text."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)


def say(words, end="\n"):
    """Prints on standard output that a file has been written; if that cannot be, standard error says so. Control characters
    of file names are escaped."""
    error = written(sys.stdout, escaped(words), end)
    if error and not isinstance(error, BrokenPipeError):
        write_error(f"lichtenberg: the output could not be written ({error.strerror}), but the files that it names are complete")


def put(words):
    """Prints the command's main output on standard output. Throws Failure if it cannot be written. A pipe that its reader has
    closed ends this process by SIGPIPE."""
    error = written(sys.stdout, words, "")
    if isinstance(error, BrokenPipeError):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGPIPE)
    if error:
        raise Failure(f"the output could not be written ({error.strerror})")


def escaped(words):
    """Returns the text with control characters except line ends escaped as \\x1b, because they would act on a terminal."""
    return "".join(c if c.isprintable() or c == "\n" else f"\\x{ord(c):02x}" for c in str(words))


def printable(sentence):
    """Returns the text in one line with control characters escaped, because file names may contain any."""
    return "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in " ".join(sentence.split()))


def write_error(words, end="\n"):
    """Prints on standard error; a write error is ignored."""
    written(sys.stderr, words, end)


def written(stream, words, end):
    """Writes the words. Returns the OSError of a failure, else None. After a failure the stream leads to /dev/null; otherwise
    Python would write its buffer again, and fail again, at its end."""
    if stream is None:
        return None
    try:
        print(words, end=end, file=stream, flush=True)
    except OSError as error:
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, stream.fileno())
        os.close(nothing)
        return error
    return None


def duration(seconds):
    """Returns a duration in words: "4.2 s", "3 min 20 s", "2 h 5 min"."""
    if seconds < 60:
        return f"{seconds:.2g} s"
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"
