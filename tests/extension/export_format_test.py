"""Format of export added from outside: PDB, for molecular viewers."""
import sys
import unittest
from pathlib import Path
from types import SimpleNamespace

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
import runs
from lichtenberg import InputError, load
from lichtenberg.export import export
from lichtenberg.formats import formats


def write_pdb(result, frames, out):
    """Writes one MODEL per frame with an ATOM per grain; coordinates have three decimals."""
    with open(out, "w", encoding="ascii") as file:
        for index in frames:
            file.write(f"MODEL     {index + 1:4d}\n")
            for n, (x, y, z) in enumerate(np.asarray(result.frame(index)["position"]), start=1):
                file.write(f"ATOM  {n:5d}  X   GRN A   1    {x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00\n")
            file.write("ENDMDL\n")


class FormatFromOutside(unittest.TestCase):
    def test_its_file_holds_the_positions_of_every_frame(self):
        formats["pdb"] = SimpleNamespace(ENDING=".pdb", IS_FOLDER=False, write=write_pdb)
        self.addCleanup(formats.pop, "pdb")
        out = export(runs.gas(), "pdb", runs.FOLDER / "gas.pdb")
        lines = Path(out).read_text().splitlines()
        positions = [[float(line[k : k + 8]) for k in (30, 38, 46)] for line in lines if line.startswith("ATOM")]
        with load(runs.gas()) as result:
            expected = np.asarray(result["position"]).reshape(-1, 3)
            self.assertEqual(sum(line.startswith("MODEL") for line in lines), len(result))
        np.testing.assert_allclose(positions, expected, atol=0.5e-3 + 1e-12)  # Half of the last decimal.
        with self.assertRaisesRegex(InputError, "exists"):
            export(runs.gas(), "pdb", out)

    def test_a_format_that_is_not_there_is_refused(self):
        with self.assertRaisesRegex(InputError, "no format pdb: it is one of"):
            export(runs.gas(), "pdb", runs.FOLDER / "gas.pdb")
        status, _, complaint = runs.command("export", runs.gas(), "--to", "pdb")
        self.assertEqual(status, 2)
        self.assertIn("no format pdb", complaint)


if __name__ == "__main__":
    unittest.main()
