"""Colours of pictures: quantities, their ranges in a whole run, and colour bars."""
from dataclasses import dataclass, replace

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import AsinhNorm, BoundaryNorm, LogNorm, Normalize, to_rgba
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MaxNLocator

from ..ranges import colour_range, range_ends, set_colours
from ..result import unit_of, value_of
from .drawing import INK, InputError, prefixed, with_unit

PALE = "#ededed"  # particles without a value: unconnected conductors, isolated grains


@dataclass
class Quantity:
    """A quantity that colours particles. Kinds: signed (white is 0), amount, decades (logarithmic), order (integers from
    1), category (names without an order)."""

    name: str
    label: str  # with "{}" in place of the prefix of an SI unit
    kind: str
    column: str  # name of the column in the result file
    pale: str = "without a value"  # name of particles that have none, or one that is no number


NOT_DRAWN = {"position", "image", "successor", "species", "box"}  # columns of particles that are not coloured


def quantities_in(file, known):
    """Returns the quantities by name: those of `known` whose column the result has, then all its other columns of particles."""
    particles = file["particles/conductors"]
    shape = particles["position/value"].shape[:2]
    found = {quantity.name: quantity for quantity in known if quantity.column in particles}
    drawn = NOT_DRAWN | {quantity.column for quantity in known}
    for name, data in particles.items():
        values = value_of(data) if name not in drawn and (not hasattr(data, "keys") or "value" in data) else None
        if values is not None and (values.shape[:2] == shape or values.shape == shape[1:]):
            found[name] = plain_quantity(name, values)
    return found


def plain_quantity(name, values):
    """Describes a column that has no description: integers are categories, other numbers amounts; of vectors the
    magnitude."""
    unit = unit_of(values)
    label = with_unit(name.replace("_", " "), "{}" + unit if unit in ("A", "C", "J", "N", "V", "W", "m", "s") else unit)
    return Quantity(name, label, "category" if values.dtype.kind in "iu" else "amount", name)


def read_column(file, quantity, index):
    """[..., N] values of a quantity's column in these frames; of vectors the magnitudes; of a constant column [N]."""
    particles = file["particles/conductors"]
    values = value_of(particles[quantity.column])
    if values.ndim == 1:
        return values[()]
    return np.linalg.norm(values[index], axis=-1) if values.ndim == 3 else values[index]


@dataclass
class Scale:
    """Colour scale of a quantity, shared by everything that is drawn with it."""

    quantity: Quantity
    low: float
    high: float
    norm: Normalize | None  # None for categories
    cmap: object
    beyond: str = "neither"  # which ends of the range have values outside

    def has_colour(self, values):
        """[N] True where a value has a colour: a logarithmic scale has none for 0."""
        return np.isfinite(values) & ((values > 0) | (self.quantity.kind != "decades"))

    @property
    def factor_and_label(self):
        """Returns the factor from the file's unit to the unit of the colour bar, and the label with that unit."""
        label = self.quantity.label
        factor, prefix = prefixed(max(abs(self.low), abs(self.high))) if "{}" in label else (1.0, "")
        return factor, label.replace("{}", prefix)

    def colours(self, values):
        """[N, 4] colours; pale where there is no value."""
        if self.norm is None:
            return category_colours(values)
        coloured = self.has_colour(values)
        faces = self.cmap(self.norm(np.where(coloured, np.clip(values, self.low, self.high), self.low)))
        faces[~coloured] = to_rgba(PALE)
        return faces

    def legend(self, values):
        """Returns the legend's marks of particles without a value, if there are any."""
        if self.has_colour(values).all():
            return []
        return [disk_mark(PALE, self.quantity.pale)]


def disk_mark(colour, label):
    style = {"linestyle": "", "marker": "o", "markersize": 6, "markeredgecolor": INK, "markeredgewidth": 0.6}
    return Line2D([], [], markerfacecolor=colour, label=label, **style)


def draw_legend(axes, marks):
    """Draws the legend below the panel, on the right."""
    if marks:
        where = {"loc": "upper right", "bbox_to_anchor": (1.01, 0), "borderaxespad": 0.35, "handletextpad": 0.4}
        axes.legend(handles=marks, frameon=False, fontsize=8, ncols=len(marks), columnspacing=1.2, **where)


def category_colours(numbers):
    """Returns one colour per number, the same in all frames."""
    known = np.isfinite(numbers)
    faces = np.tile(to_rgba(PALE), (len(numbers), 1))
    faces[known, :3] = set_colours(numbers[known])
    return faces


@dataclass
class Range:
    """Range of a quantity in a run."""

    low: float
    high: float
    typical: float = 0.0  # median magnitude of the non-zero values of a signed quantity
    least: float = np.inf  # minimum with outliers
    largest: float = -np.inf

    def joined(self, other):
        low, high = min(self.low, other.low), max(self.high, other.high)
        typical = max(self.typical, other.typical)
        return Range(low, high, typical, min(self.least, other.least), max(self.largest, other.largest))


def run_range(quantity, values, always=()):
    """Returns the range of all values of a run by the rule of lichtenberg/ranges.py; it includes `always`."""
    values = np.asarray(values[np.isfinite(values)], float)
    always = np.asarray(always, float)
    if quantity.kind == "order":
        return Range(1, max(values.max(initial=1), 2))
    if quantity.kind == "decades":
        positive = values[values > 0]
        if len(positive) == 0:
            return Range(0.1, 1)
        high = positive.max()
        low = min(max(positive.min(), 1e-4 * high), high / 2)
        return Range(low, high, 0, positive.min(), positive.max())
    low_reach, high_reach = range_ends(values)
    low, high = min(-low_reach, always.min(initial=0)), max(high_reach, always.max(initial=0))
    if quantity.kind == "amount" and not low < 0 < high:
        low, high = colour_range(quantity.name, values)
    magnitude = np.abs(values[np.abs(values) > 1e-3 * max(high, -low)])
    typical = np.median(magnitude) if len(magnitude) else 0
    least, largest = values.min(initial=np.inf), values.max(initial=-np.inf)
    return Range(low, high, typical, least, largest)


def scale_of(quantity, own_range, found, cmap=None):
    """Returns the colour scale of a quantity. `own_range`: [low, high] of the user, or None for `found`, the run's range."""
    if quantity.kind == "category":
        if own_range or cmap:
            raise InputError(f"--range and --cmap do not apply to the colour {quantity.name}, which has no order")
        return Scale(quantity, 0, 1, None, None)
    if quantity.kind == "amount" and found.low < 0 < found.high:
        quantity = replace(quantity, kind="signed")
    low, high = own_range or (found.low, found.high)
    if low == high:  # all values are equal: the range begins or ends at 0
        low, high = min(low, 0.0), max(high, float(low == 0))
    if quantity.kind == "decades" and low <= 0:
        raise InputError(f"--range from {low:g} is not allowed: {quantity.name} is drawn by decades, from above 0")
    slack = 1e-9 * (high - low)
    outside = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}
    beyond = outside[int(min(found.low, found.least) < low - slack), int(max(found.high, found.largest) > high + slack)]
    norm = norm_of(quantity, low, high, cmap, 0 if own_range else found.typical)
    return Scale(quantity, low, high, norm, map_of(quantity, cmap), beyond)


def norm_of(quantity, low, high, cmap, typical):
    if quantity.kind == "decades":
        return LogNorm(low, high)
    if quantity.kind == "order":
        return BoundaryNorm(np.arange(np.floor(low), np.floor(high) + 2) - 0.5, 256)
    if quantity.kind != "signed":
        return Normalize(low, high)
    reach = max(-low, high)
    ends = (low, high) if cmap else (-reach, reach)  # white is 0, and both signs have equal weight
    if 0 < typical < reach / 8:  # otherwise most of the run would be white: linear up to the typical value, then logarithmic
        return AsinhNorm(typical, *ends)
    return Normalize(*ends)


def map_of(quantity, cmap):
    if cmap:
        if cmap not in colormaps:
            raise InputError(f"--cmap {cmap} is no colour map of matplotlib: try viridis, plasma, magma, RdBu_r or gray")
        return colormaps[cmap]
    return colormaps[{"signed": "RdBu_r", "order": "YlGnBu"}.get(quantity.kind, "viridis_r")]


def draw_bar(figure, rectangle, scale):
    """Draws the colour bar at `rectangle`, [left, bottom, width, height] in the figure, and returns its axis; for
    categories, draws a text that explains them."""
    quantity = scale.quantity
    axes = figure.add_axes(rectangle)
    if scale.norm is None:
        axes.axis("off")
        axes.text(0.5, 0.5, f"colour: {quantity.label}", rotation=90, ha="center", va="center", transform=axes.transAxes)
        return None
    factor, label = scale.factor_and_label
    bar = figure.colorbar(ScalarMappable(bar_norm(scale, factor), scale.cmap), cax=axes, extend=scale.beyond)
    if quantity.kind == "order":
        bar.set_ticks(np.arange(int(scale.low), int(scale.high) + 1))
        bar.minorticks_off()
    else:
        bar.ax.set_ylim(scale.low * factor, scale.high * factor)
        if quantity.kind == "decades":
            set_decades(bar, scale)
        elif isinstance(scale.norm, AsinhNorm):
            bar.set_ticks(signed_decades(scale, factor))
            bar.ax.yaxis.set_major_formatter(lambda x, _: f"{x:g}".replace("-", "\N{MINUS SIGN}"))
            bar.minorticks_off()
        else:
            bar.locator = MaxNLocator(7)
            bar.update_ticks()
    bar.set_label(label, color=INK)
    bar.ax.tick_params(labelsize=8)
    bar.outline.set_linewidth(0.6)
    return bar.ax.yaxis


def set_decades(bar, scale):
    """Returns readable ticks: powers of ten, and with few of them also their multiples by 2 and 5."""
    few = scale.high < 1000 * scale.low
    bar.ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if few else (1,)))
    if few:
        bar.ax.yaxis.set_major_formatter("{x:g}")
    bar.ax.yaxis.set_minor_formatter("")


def signed_decades(scale, factor):
    """Returns 0 and powers of ten of both signs outside of the linear part; with few of them also their multiples by
    2 and 5."""
    first = np.floor(np.log10(scale.norm.linear_width * factor))
    powers = 10.0 ** np.arange(first, np.log10(max(-scale.low, scale.high) * factor) + 1e-9)
    if len(powers) < 4:
        powers = np.outer(powers, (1, 2, 5)).ravel()
    powers = powers[powers >= 0.9 * scale.norm.linear_width * factor]
    ticks = np.concatenate([-powers[::-1], [0], powers])
    return ticks[(ticks >= scale.low * factor) & (ticks <= scale.high * factor)]


def bar_norm(scale, factor):
    """Returns the norm in the unit that the colour bar shows."""
    norm = scale.norm
    if isinstance(norm, BoundaryNorm):
        return norm
    ends = norm.vmin * factor, norm.vmax * factor
    return AsinhNorm(norm.linear_width * factor, *ends) if isinstance(norm, AsinhNorm) else type(norm)(*ends)
