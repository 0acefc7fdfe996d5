"""Imported before all else by each script, since what follows takes a second to import: an interruption ends a script by
its signal, as it ends the program, and without Python's list of calls; and one that a program waits for ends with it."""
import os
import signal
import sys


def hook(kind, error, trace):
    if not issubclass(kind, KeyboardInterrupt):
        sys.__excepthook__(kind, error, trace)


sys.excepthook = hook

os.environ.pop("MPLBACKEND", None)  # pictures are drawn into files, and a name that matplotlib does not know ends its import


def end_with(parent):
    """However that process ends, this one does. Elsewhere than on Linux it draws on."""
    import ctypes
    try:
        prctl = ctypes.CDLL(None).prctl
    except (AttributeError, OSError, TypeError):
        return
    prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG of linux/prctl.h
    if os.getppid() != parent:  # it has ended before
        os.kill(os.getpid(), signal.SIGTERM)


if os.environ.get("LICHTENBERG_WAITS"):  # src/commands/python.cpp
    end_with(int(os.environ["LICHTENBERG_WAITS"]))


class Interruption:
    """From now on SIGINT, SIGTERM and SIGHUP are noted as `signal`; the same once more ends the process. A SIGHUP that whoever
    started it (nohup) has it ignore stays ignored."""

    def __init__(self):
        self.signal = None
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self.note)

    def note(self, number, _):
        self.signal = number
        signal.signal(number, signal.SIG_DFL)

    def obey(self):
        """Ends by the signal that was noted, so that whoever started this process sees that."""
        signal.signal(self.signal, signal.SIG_DFL)
        os.kill(os.getpid(), self.signal)
