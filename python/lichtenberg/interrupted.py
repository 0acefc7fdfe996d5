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


if os.environ.get("LICHTENBERG_WAITS"):  # draw.cpp
    end_with(int(os.environ["LICHTENBERG_WAITS"]))
