"""Imported before all else by each script, since what follows takes a second to import: an interruption ends a script by
its signal, as it ends the program, and without Python's list of calls."""
import sys


def hook(kind, error, trace):
    if not issubclass(kind, KeyboardInterrupt):
        sys.__excepthook__(kind, error, trace)


sys.excepthook = hook
