"""Results of lichtenberg as numpy arrays, and its field solver with numpy in and out. README.md beside has examples."""
from .program import conductors, run, solve
from .result import Array, Failure, Frame, InputError, Result, load

__all__ = ["Array", "Failure", "Frame", "InputError", "Result", "conductors", "load", "run", "solve"]
