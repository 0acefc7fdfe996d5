"""Methods that `lichtenberg work-precision` compares with the program's own; the package has those of other programs."""


class Method:
    """One method, for the sweeps of its `kind`: field (of conductors in a plane), spheres, or charges. A sweep has the scene's
    path as `sweep.request.scene`, its changed keys as `sweep.request.set`, and the problem as `sweep.subject` (None for a
    field)."""

    name = description = kind = ""

    def candidates(self, sweep):
        """Returns pairs of settings (name: number) and cost (any unit), in ascending order of cost: [({"edge": 0.5}, 8.0)]."""
        raise NotImplementedError

    def prepare(self, sweep, settings):
        """Returns a function that is called several times and solves from the start each time. It returns an answer in SI units
        and its time (s); None: the elapsed time is measured. For a field the answer is a dictionary of lists: potential, charge
        and force of each conductor. For spheres the potential is that of each group, and an unknown charge is None. For charges
        it has force, [3 N]. Throws InputError if the method cannot solve the problem, Failure if it does not succeed."""
        raise NotImplementedError


def joined():
    """Returns the methods of the package."""
    from .freefem import Freefem
    from .lammps import Lammps

    return [Freefem(), Lammps()]
