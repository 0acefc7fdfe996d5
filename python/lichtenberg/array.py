"""Arrays with units."""
import re

import numpy as np

SI = ("m", "kg", "s", "C")
# Exponents of the SI units in the reduced units of grains
REDUCED = {"d0": (1, 0, 0, 0), "m0": (0, 1, 0, 0), "v0": (1, 0, -1, 0), "t0": (0, 0, 1, 0), "q0": (0, 0, 0, 1)}


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

    def in_si(self, scales):
        """Returns an array in reduced units of grains with its values in SI. `scales`: values of d0, m0, v0, t0 and q0 in
        SI, by name (Result.scales); without any the array is in SI."""
        if not scales:
            return self
        factor, exponents = 1.0, np.zeros(len(SI), int)
        for part, sign in zip(self.unit.split("/"), (1, -1)):
            for symbol, exponent in re.findall(r"([dmvtq]0)(?:\^(\d+))?", part):
                power = sign * int(exponent or 1)
                factor *= scales[symbol] ** power
                exponents += power * np.array(REDUCED[symbol])
        unit = " ".join(name if n == 1 else f"{name}{n}" for name, n in zip(SI, exponents) if n)
        return Array(factor * np.asarray(self), unit or "1")

    def __reduce__(self):
        return Array, (np.asarray(self), self.unit)

    def __repr__(self):
        return f"{self.view(np.ndarray)!r} {self.unit}"
