"""The field of a scene's initial state."""
import html
from types import SimpleNamespace

from . import core
from .array import Array
from .errors import InputError
from .scene import check_device, scene_of


class Answer(SimpleNamespace):
    """Solution of a field: arrays with units by name (position, radius, group, potential, charge, force), energy,
    electrodes, and the entries of `lichtenberg solve --json`."""

    def __repr__(self):
        return f"<field of {len(self.radius)} bodies by {self.method}: energy {self.energy:.6g} {self.units['energy']}>"

    def _repr_html_(self):
        names = [name for name in ("position", "radius", "charge", "potential", "force") if hasattr(self, name)]
        head = "".join(f"<th>{name} ({self.units[name]})</th>" for name in names)
        shown = range(min(len(self.radius), 20))
        rows = "".join("<tr>" + "".join(f"<td>{cell(getattr(self, name)[i])}</td>" for name in names) + "</tr>" for i in shown)
        more = f"<p>{len(self.radius) - 20} more bodies</p>" if len(self.radius) > 20 else ""
        return f"<p>{html.escape(repr(self))}</p><table><tr>{head}</tr>{rows}</table>{more}"


def cell(value):
    return ", ".join(f"{number:.6g}" for number in value) if value.ndim else f"{value:.6g}"


def solve(scene, settings=None, *, capacitance=False, potential_field=False, device=""):
    """Solves the field of a scene once, in this process.

    scene: a Scene, a path, or a dictionary with the keys of a scene file. Arrays are allowed.

    The settings replace keys of the scene.

    With capacitance, compute the capacitance matrix also. With potential_field, return the potential on the grid also.

    device: "cpu" or "cuda", in place of the scene's.

    Returns an Answer with the arrays potential, charge, radius, group [N], force, position [N, 2] or [N, 3], in SI units. It
    has all other entries of `solve --json` by their names there. With capacitance=True it has capacitance.matrix, whose rows
    `group` counts, and capacitance.groups, their names. With potential_field=True it has potential_field [ny, nx] and cell,
    the edge of a cell (m). Charged grains have no group, and dipole [N, 3] if they are polarized; their units are the
    scene's reduced ones. Units are the attribute `unit` of arrays, and units[name].
    Ctrl-C ends the solve with KeyboardInterrupt. Throws InputError and Failure."""
    check_device(device)
    given = scene_of(scene, settings)
    if device == "cuda" and given.is_granular:
        raise InputError("the charges of grains are solved on the CPU: leave device = \"cuda\" out")
    core_scene = given._core.on_device(device) if device else given._core
    entries = core.load().solve(core_scene, capacitance, potential_field)
    units = {**entries["units"], "potential_field": "V", "group": "1"}
    for name in ("position", "radius", "group", "potential", "charge", "force", "dipole", "potential_field"):
        if name in entries:
            entries[name] = Array(entries[name], units[name])
    if "capacitance" in entries:
        groups, matrix = entries["capacitance"]["groups"], Array(entries["capacitance"]["matrix"], units["capacitance"])
        entries["capacitance"] = SimpleNamespace(groups=groups, matrix=matrix)
    return Answer(**entries)
