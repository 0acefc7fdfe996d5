"""What is printed: a stream that takes nothing (a full disk, a closed pipe, a closed descriptor) is no reason to end."""
import os
import sys


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
