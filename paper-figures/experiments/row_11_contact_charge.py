#!/usr/bin/python3
"""Row 11: charge and force of a conducting sphere that touches a plate of a condenser.

Maxwell (1873) has the charge, 4 pi eps a^2 E pi^2/6; Lebedev and Skal'skaya (1962) have the force, 0.832 Q E. Drews and
others (2015) find that particles between plates have the charge of electrostatics.
"""

import json
import math
import tempfile
from pathlib import Path

import numpy as np
from experiments import bounds, open_experiment, picture, published, record, row, run

EXPECTED_CHARGE = "The sphere at the potential of the plate has Maxwell's charge in the limit of a narrow gap."
EXPECTED_FORCE = "The force is 0.832 Q E: the plate attracts the charge by its image and weakens the force of the field."
ACCURACY = 1e-4
RADIUS, HEIGHT, WIDTH = 1.0, 40.0, 60.0  # plates at a distance of 40 radii, mirror images at 60 radii

SCENE = """
[domain]
size = [{height}, {width}, {width}]
left = {{ potential = {height} }}
right = {{ potential = 0 }}
[medium]
permittivity = 1
[[group]]
name = "plate"
potential = {height}
[[conductor]]
position = [{position!r}, {middle}, {middle}]
radius = {radius}
group = "plate"
[effects.floating_conductors]
[field]
accuracy = {accuracy}
"""


def solution(program, gap):
    """Returns the charge over 4 pi eps a^2 E and the force over Q E. E = 1: the voltage is the height."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "plate.toml"
        scene.write_text(SCENE.format(height=HEIGHT, width=WIDTH, middle=WIDTH / 2, position=RADIUS * (1 + gap),
                                      radius=RADIUS, accuracy=ACCURACY))
        sphere = json.loads(run(program, "solve", scene, "--json"))["conductors"][0]
    return sphere["charge"] / (4 * math.pi), sphere["force"][0] / sphere["charge"]


def main():
    request = open_experiment(11, "Maxwell 1873; Lebedev, Skal'skaya 1962; Drews 2015", __doc__)
    gaps = [0.04, 0.02] if request.quick else [0.04, 0.02, 0.01, 0.005]
    charge, force = np.array([solution(request.program, gap) for gap in gaps]).T
    # The limit is linear in the gap; the far plate and the sides change the field by about (a / 40)^3 each.
    rows = []
    for quantity, expected, value, rounded, found in (
            ("charge of a sphere on a plate, over 4 pi eps a^2 E", EXPECTED_CHARGE, math.pi**2 / 6, 0, charge),
            ("force on a sphere that leaves a plate, over Q E", EXPECTED_FORCE, 0.832, 0.0005, force)):
        lines = [np.polyval(np.polyfit(gaps[-n:], found[-n:], 1), 0) for n in (2, len(gaps))]
        half = abs(lines[1] - lines[0]) + abs(found[-1] - lines[0]) / 3 + 3 * ACCURACY * abs(lines[0])
        rows.append(row(quantity, expected, published(value, value - rounded, value + rounded, "M"), bounds(lines[0], half)))

    def draw(axes):
        axes.plot(gaps, charge, "o-", label="charge")
        axes.plot(gaps, force, "s-", label="force")
        axes.set(xlabel="gap over radius", ylabel="reduced charge and force")

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
