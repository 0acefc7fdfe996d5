"""Smoluchowski's coagulation equation with a kernel of one's own."""
from types import SimpleNamespace

from . import core
from .errors import InputError


def coagulate(kernel, times, *, tolerance=1e-4, largest=1e6, stiff=False):
    """Solves Smoluchowski's coagulation equation from single grains.

    kernel: function of two sizes (numbers of grains) that returns K >= 0.

    times: ascending, in units of the kernel.

    tolerance: relative error of the mean size by the width of the size classes.

    largest: largest size. stiff=True is for kernels that differ by many orders of magnitude.

    Returns an object with the arrays time, size, number and width. They end when mass is lost beyond `largest`. size is
    sum s^2 f / sum s f, number is that of aggregates by initial grain. width is the standard deviation of the sizes over
    their mean. It has the numbers error (estimated, of size) and lost (share of the mass).

    The command `lichtenberg theory smoluchowski --kernel` has common kernels. Throws InputError and Failure."""
    if not callable(kernel):
        raise InputError(f"a kernel is a function of two sizes, and {kernel!r} is none")
    return SimpleNamespace(**core.load().coagulate(kernel, list(map(float, times)), tolerance, largest, stiff))
