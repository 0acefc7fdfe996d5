"""Handling of signals. Scripts import this module first, because the other imports take a second. An interruption ends a
script by its signal and without a traceback. A script that the program waits for ends with the program."""
import os
import signal
import sys


def hook(kind, error, trace):
    if not issubclass(kind, KeyboardInterrupt):
        sys.__excepthook__(kind, error, trace)


sys.excepthook = hook

os.environ.pop("MPLBACKEND", None)  # pictures are files, and an unknown name would end the import of matplotlib


def end_with(parent):
    """Makes the system end this process when the parent process ends. Has no effect except on Linux."""
    import ctypes
    try:
        prctl = ctypes.CDLL(None).prctl
    except (AttributeError, OSError, TypeError):
        return
    prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG of linux/prctl.h
    if os.getppid() != parent:  # the parent has already ended
        os.kill(os.getpid(), signal.SIGTERM)


if os.environ.get("LICHTENBERG_WAITS"):  # src/commands/python.cpp
    end_with(int(os.environ["LICHTENBERG_WAITS"]))


class Interruption:
    """Stores the number of a SIGINT, SIGTERM or SIGHUP as `signal`; a second signal, also of another kind, ends the process.
    SIGHUP stays ignored if it is ignored at the start (nohup)."""

    def __init__(self):
        self.signal = None
        self.handle(self.note)

    def handle(self, handler):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, handler)

    def note(self, number, _):
        self.signal = number
        self.handle(signal.SIG_DFL)

    def obey(self):
        """Ends this process by the stored signal, which its parent then sees."""
        signal.signal(self.signal, signal.SIG_DFL)
        os.kill(os.getpid(), self.signal)
