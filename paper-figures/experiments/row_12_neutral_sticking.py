#!/usr/bin/python3
"""Row 12: Jungmann and Wurm 2021, grains below a millimetre that stick in microgravity.

Their charged grains stick at about 10 cm/s. Surface forces of neutral grains let them stick below about 1 mm/s. This script
finds the threshold of neutral glass grains of 434 um with the contact of Johnson, Kendall and Roberts. The threshold of
charged grains needs the charge, which the abstract does not state, and patches of charge, which the program lacks.
"""

import math

from experiments import Change, bounds, open_experiment, published, record, row, try_changes
from row_03_metal_wall import ADHESION, SPEED, Grain, sticks

DIAMETER, DENSITY = 434e-6, 2500  # m, kg/m^3
ENERGIES = (0.025, 0.1)  # J/m^2, bounds for silica, from memory
QUANTITY = "relative speed (m/s) below which neutral grains stick, surface energy {} J/m^2 (interval assumed)"
REASON = "Surface energy and size decide. The abstract states neither; silica has 0.025 to 0.1 J/m^2 (from memory)."
CHANGES = [Change("surface energy", "0.025 J/m^2, not 0.1", "0.0013, by the row above", {"energy": 0.025}),
           Change("law", "viscous loss 100 times less", "0.0025, the loss of adhesion alone", {"viscosity": 8.9e-10}),
           Change("size", "diameter 868 um, not 434", "0.0024, by d^(-5/6)", {"diameter": 2 * DIAMETER})]
EXPECTED = ("The relative speed is near 0.001 m/s: the energy of adhesion of two grains, w^(5/3) (R_eff^4 / E*^2)^(1/3), is "
            "that of 0.0008 m/s at 0.025 J/m^2 and of 0.0025 m/s at 0.1 J/m^2.")


def threshold(program, steps, energy=ENERGIES[-1], viscosity=8.9e-8, diameter=DIAMETER):
    """Returns the relative speed (m/s) below which two neutral grains stick, and its half width."""
    contact = ADHESION.replace(str(2.64 * 0.025), str(energy)).replace("8.9e-8", str(viscosity))
    grain = Grain(charge=1e-3, mass=DENSITY * math.pi / 6 * diameter**3, distance=diameter / 2, contact=contact)
    low, high = 0.0, 0.5
    for _ in range(steps):
        middle = (low + high) / 2
        low, high = (middle, high) if sticks(program, grain, middle) else (low, middle)
    return SPEED * (low + high), SPEED * (high - low)


def main():
    request = open_experiment(12, "Jungmann, Wurm 2021", __doc__)
    if request.changes is not None:
        try_changes(request, CHANGES, lambda other: {QUANTITY.format(ENERGIES[-1]): bounds(*threshold(request.program, 8, **other))})
        return
    rows = [row(QUANTITY.format(energy), EXPECTED, published(0.001, 0.0003, 0.003, "A"),
                bounds(*threshold(request.program, 8, energy)), REASON)
            for energy in (ENERGIES[:1] if request.quick else ENERGIES)]
    record(request, rows)


if __name__ == "__main__":
    main()
