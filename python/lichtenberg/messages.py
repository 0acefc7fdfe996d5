"""What is printed: a stream that takes nothing (a full disk, a closed pipe, a closed descriptor) is no reason to end."""
import os
import signal
import sys

from .errors import Failure


def open_closed_descriptors():
    """Before any file is opened, so that none gets the descriptor of a standard stream and with it what is printed."""
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
        tell(f"lichtenberg: the output could not be written ({error.strerror}), but the files that it tells of stand")


def put(words):
    """Prints on standard output what was asked for in place of anything else. Throws Failure if that cannot be; a pipe that its
    reader has closed ends this process as it does others."""
    error = written(sys.stdout, words, "")
    if isinstance(error, BrokenPipeError):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGPIPE)
    if error:
        raise Failure(f"the output could not be written ({error.strerror})")


def escaped(words):
    """Control characters but line ends as \\x1b: they would do something to a terminal."""
    return "".join(c if c.isprintable() or c == "\n" else f"\\x{ord(c):02x}" for c in str(words))


def printable(sentence):
    """In one line, without characters that do something to a terminal: files of strangers have names of their own."""
    return "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in " ".join(sentence.split()))


def tell(words, end="\n"):
    """Prints on standard error, if that can be."""
    written(sys.stderr, words, end)


def written(stream, words, end):
    """Returns the OSError that kept the words from being written, or None. After one the stream leads to /dev/null: what it
    holds back would be written again, and fail again, when Python ends."""
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
    """How long something takes, for people: "4.2 s", "3 min 20 s", "2 h 5 min"."""
    if seconds < 60:
        return f"{seconds:.2g} s"
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"
