"""Pictures coloured by a particle column added from outside: plot takes its name and shows its unit."""
import shutil
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
import runs
from lichtenberg.pictures import frames


def with_columns(source, path):
    """Copies a result and adds a kinetic energy, a momentum and a colour number to its particles."""
    shutil.copy(source, path)
    with h5py.File(path, "a") as file:
        particles = file["particles/conductors"]
        velocity = particles["velocity"]
        mass = particles["mass"][()]
        add(particles, "kinetic_energy", 0.5 * mass * (velocity["value"][()] ** 2).sum(axis=-1), "m0 v0^2")
        add(particles, "momentum", mass[:, None] * velocity["value"][()], "m0 v0")
        add(particles, "batch", np.tile(np.arange(len(mass), dtype=np.int32) % 3, (len(velocity["time"]), 1)), "1")
    return path


def add(particles, name, values, unit):
    group = particles.create_group(name)
    group.create_dataset("value", data=values).attrs["unit"] = unit
    for each in ("step", "time"):
        group[each] = particles["velocity"][each]


class ColumnAsColour(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.path = str(with_columns(runs.gas(), runs.FOLDER / "columns.h5"))

    def test_its_values_and_unit_are_shown(self):
        run = frames.read_run(self.path)
        with h5py.File(self.path) as file:
            energy = file["particles/conductors/kinetic_energy/value"][()]
            momentum = file["particles/conductors/momentum/value"][()]
            np.testing.assert_array_equal(run.values(file, "kinetic_energy", 2), energy[2])
            np.testing.assert_array_equal(run.values(file, "momentum", 2), np.linalg.norm(momentum[2], axis=1))
            found = run.range(file, "kinetic_energy")
            self.assertEqual(found.largest, energy.max())
        self.assertEqual(run.quantities["kinetic_energy"].label, "kinetic energy (m₀ v₀²)")
        self.assertEqual(run.quantities["batch"].kind, "category")
        self.assertNotIn("position", run.quantities)
        scale = frames.common_scale([run], "kinetic_energy")
        shades = scale.colours(np.array([found.low, found.high]))
        self.assertGreater(np.abs(shades[0] - shades[1]).max(), 0.5)  # The ends of a colour map differ clearly.

    def test_plot_draws_it_by_name(self):
        for colour in ("kinetic_energy", "momentum", "batch"):
            status, said, complaint = runs.command("plot", self.path, "--colour", colour, "--frame", "1")
            self.assertEqual(status, 0, complaint)
            self.assertIn(f"by {colour}", said)
            self.assertTrue((runs.FOLDER / f"columns-frame-1-{colour}.png").stat().st_size > 0)

    def test_a_column_that_is_not_there_is_refused(self):
        status, _, complaint = runs.command("plot", self.path, "--colour", "temperature")
        self.assertEqual(status, 2)
        self.assertIn("has no temperature to colour by: it has charge, cluster", complaint)
        self.assertIn("kinetic_energy", complaint)


if __name__ == "__main__":
    unittest.main()
