"""Arrays with units."""
import numpy as np


class Array(np.ndarray):
    """An array with a unit (text; "1" for pure numbers). Parts of the array have the unit too; results of arithmetic
    do not."""

    def __new__(cls, values, unit):
        array = np.asarray(values).view(cls)
        array.unit = unit
        return array

    def __array_finalize__(self, origin):
        self.unit = getattr(origin, "unit", "1")

    def __array_ufunc__(self, function, method, *inputs, out=None, **options):
        def plain(values):
            return tuple(value.view(np.ndarray) if isinstance(value, Array) else value for value in values)

        if out is not None:
            options["out"] = plain(out)
        return getattr(function, method)(*plain(inputs), **options)

    def __reduce__(self):
        return Array, (np.asarray(self), self.unit)

    def __repr__(self):
        return f"{self.view(np.ndarray)!r} {self.unit}"
