"""Formats of other programs for exported results: one module for each, named like the format.

A module of a format defines:

    ENDING          End of the default output's name, after that of the result: ".xyz", or "-vtk" for a folder.
    IS_FOLDER       True if the output is a folder.
    write(result, frames, out)
                    Function. Writes the frames (ascending indices) of a Result to the file or the empty folder `out`.
    earlier_files(folder)
                    Function, only if the output is a folder. Returns the set of names of files in it that an earlier export to the
                    format wrote.

A format from outside is a module, or any object with these names, that is added to `formats`.
"""
import importlib
import pkgutil

import numpy as np


def columns_of(frame):
    """Returns the columns of a frame by name, without positions."""
    return {name: np.asarray(frame[name]) for name in frame.result.columns if name != "position"}


formats = {module.name: importlib.import_module(f"{__name__}.{module.name}") for module in pkgutil.iter_modules(__path__)}
