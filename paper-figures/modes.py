"""Growth rates of the modes of a homogeneous charged gas (G chapter 6), for the figures 6.1 and 6.2."""

import matplotlib.pyplot as plt

from figures import save
from gases import theory

WAVES = r"wave number $k l_0$"
NEUTRAL, CHARGED, SHEAR = "#1a1a1a", "#d55e00", "#8c8c8c"


def modes(program, restitution, charge_number):
    """Returns the tables of `lichtenberg theory stability`."""
    return theory(program, "stability", "--restitution", restitution, "--charge-number", charge_number)


def largest_critical(program, restitution, charge_number):
    """Returns the largest wave number at which a mode begins or ceases to grow; 0 if there is none."""
    return max(modes(program, restitution, charge_number)[1].get("critical", [0.0]))


def grows_at(table, kind, wave):
    """Returns whether modes of a kind, oscillating (sound) or not (heat), grow at this wave number."""
    n = int(abs(table["wave_number"] - wave).argmin())
    return any(table[f"growth{m}"][n] > 0 and (abs(table[f"frequency{m}"][n]) > 1e-9) == (kind == "sound")
               for m in (1, 2, 3))


def draw_panel(axes, table, title):
    k = table["wave_number"]
    axes.axhline(0, color=SHEAR, linewidth=0.6)
    for suffix, colour, style in (("_neutral", NEUTRAL, "-"), ("", CHARGED, "--")):
        for n in (1, 2, 3):
            if f"growth{n}{suffix}" in table:
                axes.plot(k, table[f"growth{n}{suffix}"], style, color=colour, linewidth=1.2)
    axes.plot(k, table["shear"], ":", color=SHEAR, linewidth=1)
    axes.set(xlim=(0, 0.3), ylim=(-0.2, 0.11))
    axes.set_title(title, fontsize=9)


def draw(name, panels):
    """Draws six panels (title, table)."""
    figure, grid = plt.subplots(2, 3, figsize=(9, 5.2), sharex=True, sharey=True, layout="constrained")
    for axes, letter, (title, table) in zip(grid.flat, "abcdef", panels):
        draw_panel(axes, table, f"({letter}) {title}")
    for axes in grid[1]:
        axes.set_xlabel(WAVES)
    for axes in grid[:, 0]:
        axes.set_ylabel(r"growth rate Re $\lambda\,t_0$")
    shown = [plt.Line2D([], [], color=NEUTRAL, label="neutral"),
             plt.Line2D([], [], color=CHARGED, linestyle="--", label="charged"),
             plt.Line2D([], [], color=SHEAR, linestyle=":", label="shear")]
    grid[0, 2].legend(handles=shown, frameon=False, fontsize=8, loc="lower left")
    save(figure, name)
