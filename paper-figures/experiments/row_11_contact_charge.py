#!/usr/bin/python3
"""Row 11: charge and force of a conducting sphere that touches a plate (Drews 2015, Dou 2018).

A sphere shuttles between two plates and takes a new charge at each contact. The measured charge is that of electrostatics:
pi^2/6 times 4 pi eps R^2 E for a sphere on a plate in the field E (Maxwell 1891), and the force at contact is (zeta(3) +
1/6) 4 pi eps R^2 E^2 (Lebedev and Skalskaya 1962). Values at two small gaps are extrapolated to contact.
"""

import json
import math
import tempfile
from pathlib import Path

from experiments import bounds, open_experiment, published, record, row, run

EXPECTED = ("A sphere at the plate's potential has this charge and force at contact. Plates at a distance of 30 radii "
            "change them by less than 0.0003.")
GAPS = (0.001, 0.002)  # radii; both values are linear there
FAR = 30  # radii, distance of the plates
ERROR = 3e-4  # of the image in the other plate and the sides, of order 2 (R / FAR)^3, and of the extrapolation
ZETA_3 = 1.2020569

SCENE = """
[domain]
size = [40, 40, {far}]
front = {{ potential = 0 }}
back = {{ potential = -{far} }}
[medium]
permittivity = {permittivity!r}
[effects.floating_conductors]
[field]
tolerance = 1e-8
[[group]]
name = "sphere"
potential = 0
[[conductor]]
position = [20, 20, {height!r}]
radius = 1
group = "sphere"
"""


def at_gap(program, gap):
    """Returns charge over 4 pi eps R^2 E and force over 4 pi eps R^2 E^2 of a sphere at this gap (radii)."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "sphere.toml"
        scene.write_text(SCENE.format(far=FAR, height=1 + gap, permittivity=1 / (4 * math.pi)))
        sphere = json.loads(run(program, "solve", scene, "--json"))["conductors"][0]
    return sphere["charge"], sphere["force"][2]


def main():
    request = open_experiment(11, "Drews 2015; Dou 2018", __doc__)
    near, far = (at_gap(request.program, gap) for gap in GAPS)
    slope = GAPS[0] / (GAPS[1] - GAPS[0])
    charge, force = (one - (other - one) * slope for one, other in zip(near, far))
    rows = []
    for name, value, exact, source in (
            ("charge of a sphere on a plate over 4 pi eps R^2 E", charge, math.pi**2 / 6, "A"),
            ("force on a sphere on a plate over 4 pi eps R^2 E^2", force, ZETA_3 + 1 / 6, "M")):
        rows.append(row(name, EXPECTED, published(round(exact, 6), exact, exact, source), bounds(value, ERROR)))
    record(request, rows)


if __name__ == "__main__":
    main()
