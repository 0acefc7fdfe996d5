#!/usr/bin/python3
"""Row 3: Jungmann, Steinpilz, Teiser and Wurm 2018, charged glass grains of 450 um that hit a metal wall.

The image of a grain in a conducting plane is a grain of the opposite charge that moves as its mirror image. So a
collision with the wall is that of two grains with opposite charges, for uniform charges. The threshold speed is found
by bisection: below it the pair stays bound after one collision.
"""

import math
import tempfile
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from experiments import Change, bounds, open_experiment, periodic_box, picture, published, record, row, run, try_changes

EXPECTED_SLOPE = ("The threshold is proportional to the charge: v = q sqrt(k (1/e^2 - 1) / (m d)), because a constant part "
                  "of the kinetic energy at contact is lost.")
EXPECTED_SPEED = "The image force of a uniform charge of 1e7 e is too weak for the published threshold of 0.15 m/s."
RESTITUTION, DENSITY, DIAMETER, SPEED = 0.9, 2500, 450e-6, 0.01  # kg/m^3, m; reference speed, m/s
MASS = DENSITY * math.pi / 6 * DIAMETER**3
CHARGES = [1e6, 3e6, 1e7]  # elementary charges
BOX = 60.0  # d0, edge
SPEED_AT_1E7 = "sticking threshold (m/s) at 1e7 e, restitution 0.9 (interval assumed)"

PAIR = """
[[conductor]]
position = [{left!r}, 30, 30]
velocity = [{speed!r}, 0, 0]
radius = 0.5
charge = 1
[[conductor]]
position = [{right!r}, 30, 30]
velocity = [{backward!r}, 0, 0]
radius = 0.5
charge = -1
{contact}
[effects.coulomb]
coupling_constant = {coupling!r}
sum = "minimum-image"
[stop]
time = {time!r}
[output]
every = {time!r}
picture = false
"""


class Grain(NamedTuple):
    """Grain and its collision. The image force depends on the distance of the charge from the wall only. So a charge
    closer to the wall is a pair of smaller spheres with the mass of the grain."""

    charge: float = 1e7  # e
    restitution: float = RESTITUTION
    mass: float = MASS
    distance: float = DIAMETER / 2  # m, of the charge from the wall at contact
    start: float = 3.0  # d0, distance of the centres at the start
    contact: str = "[effects.linear_contact]\nstiffness = 1e6\nrestitution = {restitution}"
    at_contact: bool = False  # the speed is that just before contact, not far away

    def coupling(self):
        """Returns K = k q^2 / (m v0^2 d0) with d0 = 2 distance."""
        return 8.98755e9 * (self.charge * 1.602177e-19) ** 2 / (self.mass * SPEED**2 * 2 * self.distance)


# Glass in the law of Singh 2019, with a viscous time for a restitution of 0.9 at 0.01 m/s. The energy of adhesion is
# proportional to w^(5/3) R_eff^(4/3) (JKR). A wall doubles R_eff, and a pair shares its loss: 2.64 w has the loss at a wall.
ADHESION = f"""[effects.viscoelastic_contact]
young = 64e9
poisson = 0.2
viscosity = 8.9e-8
[effects.adhesion]
surface_energy = {2.64 * 0.025}
[mechanics]
contact_substeps = 400"""
CHANGES = [
    Change("place of the charge", "10 um from the wall at contact, not 225", "0.048, by d^(-1/2)", Grain(distance=10e-6)),
    Change("place of the charge", "1 um from the wall at contact", "0.151, agrees", Grain(distance=1e-6)),
    Change("charge", "3e7 e", "0.030, by proportion", Grain(charge=3e7)),
    Change("law", "restitution 0.5", "0.036, by sqrt(1/e^2 - 1)", Grain(restitution=0.5)),
    Change("law", "JKR adhesion, 0.025 J/m^2", "0.010: neutral grains stick below 0.001", Grain(contact=ADHESION)),
    Change("density", "1000 kg/m^3, not 2500", "0.016, by m^(-1/2)", Grain(mass=MASS / 2.5)),
    Change("definition", "speed just before contact, not far away", "0.023, by 1 / sqrt(1 - e^2)", Grain(at_contact=True)),
    Change("resolution", "contacts 100 times stiffer", "same", Grain(
        contact=Grain().contact.replace("1e6", "1e8"))),
    Change("system size", "start at 10 diameters, not 3", "same", Grain(start=10.0)),
]


def sticks(program, grain, speed):
    """Returns true if a pair with this speed (v0) of each grain far apart is bound after one collision."""
    strength = grain.coupling()
    start = math.sqrt(speed**2 + strength / grain.start)  # each grain gains half of the energy K/r
    units = f"[units]\nlength = {2 * grain.distance}\nmass = {grain.mass}\nvelocity = {SPEED}"
    scene_text = periodic_box(BOX).replace("[units]", units) + PAIR.format(
        left=(BOX - grain.start) / 2, right=(BOX + grain.start) / 2, speed=start, backward=-start, coupling=strength,
        contact=grain.contact.format(restitution=grain.restitution), time=1.02 * (grain.start - 1) / 2 / start)
    with tempfile.TemporaryDirectory() as folder:
        scene, result = Path(folder) / "wall.toml", Path(folder) / "wall.h5"
        scene.write_text(scene_text)
        run(program, "run", scene, "--quiet", "--out", result)
        with h5py.File(result) as file:
            energies = {name: file[f"observables/{name}/value"][-1]
                        for name in ("kinetic_energy", "potential_energy", "contact_energy")}
            if file["observables/collisions/value"][-1] < 1:
                raise SystemExit("the grains have not met")
    return sum(energies.values()) < 0


def threshold(program, grain, steps):
    """Returns the threshold (m/s) and its half width."""
    strength = grain.coupling()
    low, high = 0.0, 2 * math.sqrt(strength * (1 / grain.restitution**2 - 1))
    for _ in range(steps):
        middle = (low + high) / 2
        low, high = (middle, high) if sticks(program, grain, middle) else (low, middle)
    if grain.at_contact:
        low, high = (math.sqrt(speed**2 + strength) for speed in (low, high))
    return SPEED * (low + high) / 2, SPEED * (high - low) / 2


def main():
    request = open_experiment(3, "Jungmann, Steinpilz, Teiser, Wurm 2018", __doc__)
    charges, steps = (CHARGES[:2], 5) if request.quick else (CHARGES, 9)
    if request.changes is not None:
        try_changes(request, CHANGES, lambda grain: {SPEED_AT_1E7: bounds(*threshold(request.program, grain, steps))})
        return
    found = [threshold(request.program, Grain(charge), steps) for charge in charges]
    speeds, errors = np.array(found).T
    slope = np.polyfit(np.log(charges), np.log(speeds), 1)[0]
    uncertain = 2 * max(errors / speeds) / math.log(charges[-1] / charges[0])
    rows = [row("exponent of the sticking threshold by charge (interval assumed)", EXPECTED_SLOPE, published(1, 0.9, 1.1, "A"),
                bounds(slope, uncertain))]
    if not request.quick:
        rows.append(row(SPEED_AT_1E7, EXPECTED_SPEED,
                        published(0.15, 0.1, 0.2, "A"), bounds(speeds[-1], errors[-1]),
                        "The place of the charge decides: 1e7 e at 1 um from the wall give the published speed. One patch of "
                        "this charge would have a field of 3e10 V/m at the wall, which no surface holds. So patches of "
                        "both signs, which the authors name, must hold more charge than the grain. The program has none."))

    def draw(axes):
        axes.errorbar(charges, speeds, errors, fmt="o", label="uniform charge")
        axes.plot([1e5, 1e7], [0.0015, 0.15], label="published, linear")
        axes.set(xscale="log", yscale="log", xlabel="charge (e)", ylabel="threshold (m/s)")

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
