"""Smoluchowski's coagulation equation with a kernel of one's own."""
from types import SimpleNamespace

from . import core
from .errors import InputError


def coagulate(kernel, times, *, tolerance=1e-4, largest=1e6, stiff=False):
    """Solves Smoluchowski's coagulation equation from single grains.

    The kernel is a symmetric function of two sizes (numbers of grains) that returns K >= 0. The times are ascending, in
    units of the kernel. The tolerance is the relative error of the mean size by the width of the size classes. No size
    exceeds `largest`. With stiff=True kernels may differ by many orders of magnitude, as those that grow with size.

    Returns an object with the arrays time, size, number and width. They end when mass is lost beyond `largest`. The size is
    sum s^2 f / sum s f, the number that of aggregates by initial grain. The width is the standard deviation of the sizes
    over their mean. The number `error` is estimated, of the size, and `lost` is the share of the mass.

    The command `lichtenberg theory smoluchowski --kernel` has common kernels. Throws InputError and Failure."""
    if not callable(kernel):
        raise InputError(f"a kernel is a function of two sizes, and {kernel!r} is none")
    return SimpleNamespace(**core.load().coagulate(kernel, list(map(float, times)), tolerance, largest, stiff))
