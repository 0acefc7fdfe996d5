#!/usr/bin/python3
"""Row 3: Jungmann, Steinpilz, Teiser and Wurm 2018, charged glass grains of 450 um that hit a metal wall.

The image of a grain in a conducting plane is a grain of the opposite charge that moves as its mirror image. So a
collision with the wall is that of two grains with opposite charges, for uniform charges. The threshold speed is found
by bisection: below it the pair stays bound after one collision.
"""

import math
import tempfile
from pathlib import Path

import h5py
import numpy as np
from experiments import bounds, open_experiment, periodic_box, picture, published, record, row, run

EXPECTED_SLOPE = ("The threshold is proportional to the charge: v = q sqrt(k (1/e^2 - 1) / (m d)), because a constant part "
                  "of the kinetic energy at contact is lost.")
EXPECTED_SPEED = "The image force of a uniform charge of 1e7 e is too weak for the published threshold of 0.15 m/s."
RESTITUTION, DENSITY, DIAMETER, SPEED = 0.9, 2500, 450e-6, 0.01  # kg/m^3, m; reference speed, m/s
MASS = DENSITY * math.pi / 6 * DIAMETER**3
CHARGES = [1e6, 3e6, 1e7]  # elementary charges
START, BOX = 3.0, 60.0  # d0, distance of the centres at the start; edge of the box

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
[effects.linear_contact]
stiffness = 1e6
restitution = {restitution}
[effects.coulomb]
coupling_constant = {coupling!r}
sum = "minimum-image"
[stop]
time = {time!r}
[output]
every = {time!r}
picture = false
"""


def coupling(elementary_charges):
    """Returns K = k q^2 / (m v0^2 d)."""
    return 8.98755e9 * (elementary_charges * 1.602177e-19) ** 2 / (MASS * SPEED**2 * DIAMETER)


def sticks(program, strength, speed, restitution):
    """Returns true if a pair with this speed (v0) of each grain far apart is bound after one collision."""
    start = math.sqrt(speed**2 + strength / START)  # each grain gains half of the energy K/r
    scene_text = periodic_box(BOX) + PAIR.format(left=BOX / 2 - START / 2, right=BOX / 2 + START / 2, speed=start,
                                                 backward=-start, restitution=restitution, coupling=strength,
                                                 time=1.02 * (START - 1) / 2 / start)
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


def threshold(program, elementary_charges, steps, restitution=RESTITUTION):
    """Returns the threshold (m/s) and its half width."""
    strength = coupling(elementary_charges)
    low, high = 0.0, 2 * math.sqrt(strength * (1 / restitution**2 - 1))
    for _ in range(steps):
        middle = (low + high) / 2
        low, high = (middle, high) if sticks(program, strength, middle, restitution) else (low, middle)
    return SPEED * (low + high) / 2, SPEED * (high - low) / 2


def main():
    request = open_experiment(3, "Jungmann, Steinpilz, Teiser, Wurm 2018", __doc__)
    charges, steps = (CHARGES[:2], 5) if request.quick else (CHARGES, 9)
    found = [threshold(request.program, charge, steps) for charge in charges]
    speeds, errors = np.array(found).T
    slope = np.polyfit(np.log(charges), np.log(speeds), 1)[0]
    uncertain = 2 * max(errors / speeds) / math.log(charges[-1] / charges[0])
    rows = [row("exponent of the sticking threshold by charge (interval assumed)", EXPECTED_SLOPE, published(1, 0.9, 1.1, "A"),
                bounds(slope, uncertain))]
    if not request.quick:
        rows.append(row("sticking threshold (m/s) at 1e7 e, restitution 0.9 (interval assumed)", EXPECTED_SPEED,
                        published(0.15, 0.1, 0.2, "A"), bounds(speeds[-1], errors[-1]),
                        "The charge is uniform here, and restitution alone would have to be 0.14. The authors name "
                        "patches of charge and their images. At equal charge a patch close to the wall would multiply the "
                        "energy of the image, and patches may hold more charge than the net charge. This assumption "
                        "decides; patches are not in the program"))

    def draw(axes):
        axes.errorbar(charges, speeds, errors, fmt="o", label="uniform charge")
        axes.plot([1e5, 1e7], [0.0015, 0.15], label="published, linear")
        axes.set(xscale="log", yscale="log", xlabel="charge (e)", ylabel="threshold (m/s)")

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
