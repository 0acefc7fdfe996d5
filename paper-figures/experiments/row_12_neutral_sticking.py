#!/usr/bin/python3
"""Row 12: Jungmann and Wurm 2021, grains below a millimetre that stick in microgravity.

Their charged grains stick at about 10 cm/s. Surface forces of neutral grains let them stick below about 1 mm/s. This script
finds the threshold of neutral glass grains of 434 um with the contact of Johnson, Kendall and Roberts. The threshold of
charged grains needs the charge, which the abstract does not state, and patches of charge, which the program lacks.
"""

import math

from experiments import bounds, open_experiment, published, record, row
from row_03_metal_wall import ADHESION, SPEED, Grain, sticks

DIAMETER, DENSITY = 434e-6, 2500  # m, kg/m^3
ENERGIES = (0.025, 0.1)  # J/m^2, of dry and of clean glass
EXPECTED = ("The relative speed is near 0.001 m/s: the energy of adhesion of two grains, w^(5/3) (R_eff^4 / E*^2)^(1/3), is "
            "that of 0.0008 m/s at 0.025 J/m^2 and of 0.0025 m/s at 0.1 J/m^2.")


def threshold(program, energy, steps):
    """Returns the relative speed (m/s) below which two neutral grains stick, and its half width."""
    contact = ADHESION.replace(str(2.64 * 0.025), str(energy))
    grain = Grain(charge=1e-3, mass=DENSITY * math.pi / 6 * DIAMETER**3, distance=DIAMETER / 2, contact=contact)
    low, high = 0.0, 0.5
    for _ in range(steps):
        middle = (low + high) / 2
        low, high = (middle, high) if sticks(program, grain, middle) else (low, middle)
    return SPEED * (low + high), SPEED * (high - low)


def main():
    request = open_experiment(12, "Jungmann, Wurm 2021", __doc__)
    rows = [row(f"relative speed (m/s) below which neutral grains stick, surface energy {energy} J/m^2 (interval assumed)",
                EXPECTED, published(0.001, 0.0003, 0.003, "A"), bounds(*threshold(request.program, energy, 8)))
            for energy in (ENERGIES[:1] if request.quick else ENERGIES)]
    record(request, rows)


if __name__ == "__main__":
    main()
