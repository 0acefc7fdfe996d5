"""Methods that join the program's own in `lichtenberg work-precision`; here those of other programs."""


class Method:
    """One method, for the sweeps of its `kind`: field (of conductors in a plane), spheres, or charges. A sweep has the scene's path
    as `sweep.request.scene`, keys that are set otherwise as `sweep.request.set`, and `sweep.subject`, what is solved (None of a
    field)."""

    name = description = kind = ""

    def candidates(self, sweep):
        """Settings, name by number, in ascending order of the cost beside them, in any unit: [({"edge": 0.5}, 8.0)]."""
        raise NotImplementedError

    def prepare(self, sweep, settings):
        """A function to be called again and again, each time from nothing. It returns an answer in SI, and the seconds that it took;
        None: those of the clock. The answer has potential, charge and force of each conductor in a field; of spheres the potential
        is that of each group, and a charge that is not found is None; of charges it has force, [3 N]. Throws InputError if the
        method cannot do it, Failure if it does not succeed."""
        raise NotImplementedError


def joined():
    """All that come with the package."""
    from .freefem import Freefem
    from .lammps import Lammps

    return [Freefem(), Lammps()]
