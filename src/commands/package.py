#!/usr/bin/python3
"""Finds the Python package lichtenberg, which does the work of `view` and `export`, and hands the words on to it."""
import interrupted  # before all else

import sys
import warnings
from pathlib import Path

here = Path(__file__).resolve().parent
sys.path[:0] = [str(here / "python"), str(here.parents[1] / "python")]  # as installed; in the source

from lichtenberg.__main__ import main

if __name__ == "__main__":
    warnings.simplefilter("ignore", UserWarning)  # the program has said what load() warns of
    sys.exit(main())
