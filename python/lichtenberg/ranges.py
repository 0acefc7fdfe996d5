"""Ranges of colours: one rule for pictures, pages and files of other programs.

A range is that of the whole run, whichever frames are shown, so a colour means the same in all. It ends at the largest value.
If a few values are outliers, it ends at the 99.5 % quantile, and larger values have the colour of the end. Where values have a
sign, white is 0 and both signs have equal weight.
"""
import colorsys

import numpy as np

SIGNED = {"potential", "charge"}  # quantities whose range has both signs, even if all values have one


def range_end(magnitudes):
    """Returns the range of [N] values of one sign."""
    largest = magnitudes.max(initial=0)
    typical = np.quantile(magnitudes, 0.995) if len(magnitudes) else 0
    return typical if 0 < 2 * typical < largest else largest


def range_ends(values):
    """Returns how far values are below 0 and above 0: two numbers >= 0."""
    values = values[np.isfinite(values)]
    return range_end(-values[values < 0]), range_end(values[values > 0])


def colour_range(name, values):
    """Returns the lowest and highest colour value of a column of this name."""
    values = np.asarray(values, float)
    values = values[np.isfinite(values)]
    below, above = range_ends(values)
    if name in SIGNED or (below > 0 and above > 0):
        both = max(below, above) or 1.0
        return -both, both
    if len(values) == 0:
        return 0.0, 1.0
    return max(values.min(), -below), min(values.max(), above)


def set_colours(numbers):
    """[N, 3] colours of sets by their numbers, distinct for hundreds of sets. Hues of successive numbers are a
    golden section of the circle apart; sets whose numbers are close, or whose hues nearly coincide, also differ in
    lightness."""
    numbers = np.asarray(numbers, int)
    colours = {n: colorsys.hls_to_rgb(0.6 + n * 0.6180339887 % 1, (0.5, 0.68, 0.34)[n % 3], 0.6) for n in set(numbers.tolist())}
    return np.array([colours[n] for n in numbers.tolist()]).reshape(-1, 3)
