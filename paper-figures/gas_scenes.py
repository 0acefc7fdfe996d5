"""Scenes of the gases of the figures of grains (G chapters 3 to 7), in a small size and in the source's size.

Uses the standard library only, for machines without other packages. K Q^2 determines when a charged gas begins to
cluster, and the source does not state Q. One Q for all gases, 4.5e-3, reproduces the onsets and clusters of its
figures.
"""

import math
from dataclasses import dataclass

FILLED = 0.07635  # volume fraction of 50016 grains in a cube of 70 (G table 5.2)
RATE = 4.5e-3  # Q
WARM = 10  # t0, of elastic collisions before the run's time begins
SIDES = ("left", "right", "bottom", "top", "front", "back")
VISCOELASTIC = "[effects.viscoelastic_contact]\nstiffness = 278.6\ndamping = 27.7"


@dataclass(frozen=True)
class Gas:
    """Gas, in units of its scene. Time is counted from the end of the warm-up."""

    name: str
    count: int
    until: float
    seeds: int
    filled: float = FILLED
    temperature: float = 10
    warm: float = WARM  # 0: none
    every: float = 10
    stiff: float = 0  # duration after the warm-up in which contacts are ten times as stiff
    contact: str = VISCOELASTIC
    effects: tuple = ()
    population: str = ""
    steps: int = 45  # contact substeps
    device: bool = True  # a CUDA device supports all effects
    pictured: bool = False  # keep the result of the first seed for pictures

    def scene(self, seed):
        """Returns the text of a scene file."""
        edge = (self.count * math.pi / (6 * self.filled)) ** (1 / 3)
        sides = "\n".join(f'{side} = "periodic"' for side in SIDES)
        parts = [
            f'title = "{self.name}"\nseed = {seed}\n\n[units]',
            f"[domain]\nsize = [{edge:.6g}, {edge:.6g}, {edge:.6g}]\n{sides}",
            f"[[population]]\ncount = {self.count}\ntemperature = {self.temperature:g}\n{self.population}".rstrip(),
            *self._stages(), self.contact, *self.effects,
            f"[mechanics]\nthreads = 1\ncontact_substeps = {self.steps}",
            f"[stop]\ntime = {self.warm + self.until:g}",
            f"[output]\nevery = {self.every:g}\npicture = false\ncheckpoint_every = 1000000"]
        return "\n\n".join(parts) + "\n"

    def _stages(self):
        if self.warm:
            yield f"[[equilibration]]\nduration = {self.warm:g}\nstiffness = 10\ntemperature = {self.temperature:g}"
        if self.stiff:
            yield f"[[equilibration]]\nduration = {self.stiff:g}\nelastic = false\nstiffness = 10"


def coulomb(strength, accuracy=1e-3):
    return f"[effects.coulomb]\ncoupling_constant = {strength:g}\naccuracy = {accuracy:g}"


def impacts(exponent=0.83, strength=RATE):
    return f"[effects.charge_exchange]\ntransfer_prefactor = {strength:g}\nexponent = {exponent:g}"


def random_walk(strength, model="random-walk"):
    """Returns an effect of white noise with the variance Q^2 per unit of time."""
    return f'[effects.charge_exchange]\nmodel = "{model}"\ntransfer_prefactor = {strength:g}\nrate = 1'


def dipoles(polarizability):
    return f"[effects.induced_dipoles]\npolarizability = {polarizability:g}\ntolerance = 1e-4"


def drag(speed, stokes=0.05, hold=1):
    return f"[effects.gas_drag]\nstokes = {stokes:g}\nspeed = {speed:g}\ncorrelation_time = {hold:g}"


def neutral(full):
    """Gas N: G 3.5b, 4.1b, 4.2, 4.4 to 4.7."""
    return Gas("neutral", 50016 if full else 8516, 400 if full else 200, 20 if full else 3, pictured=True)


def exchanging(full, strength):
    """Gas X: G 4.1b to 4.8; K Q^2 = 5e-6, 2e-5, 1e-4."""
    return Gas(f"exchange-{strength:g}", 50016 if full else 8516, 300 if full else 200, 20 if full else 3,
               effects=(impacts(), coulomb(strength)), pictured=strength != 1)


STRENGTHS = (0.25, 1, 5)


def early(full):
    """Gas X at early times with frequent frames: G 4.1b, 4.4a."""
    return Gas("early", 50016 if full else 8516, 10, 3, every=1, effects=(impacts(), coulomb(1)))


def monopolar(full, strength):
    """Gas M: G 4.1a."""
    effects = (coulomb(strength),) if strength else ()
    return Gas(f"monopolar-{strength:g}", 8516 if full else 1000, 1000, 8 if full else 3, warm=0, effects=effects,
               contact="[effects.linear_contact]\nstiffness = 278.6\nrestitution = 0.9",
               population="charge = 1" if strength else "")


REPULSIONS = (0, 0.01, 0.1, 1)


def walking(full, z):
    """Gas W: G 3.5a, 3.6 to 3.8. z = 0 in the source must mean zero charges, because a density exp(-|q|^z) has ever
    heavier tails."""
    drawn = f'charge = 0.25\ncharge_distribution = "exponential-power"\ncharge_exponent = {z:g}' if z else ""
    return Gas(f"walk-{z:g}", 8516 if full else 1000, 150, 8 if full else 3, every=1, population=drawn,
               effects=(random_walk(0.3) + "\ncapacity = 1", coulomb(1)), device=False, pictured=True)


def by_area(full):
    """Gas A: G 3.5b."""
    return Gas("area", 8516 if full else 1000, 1000 if full else 300, 8 if full else 3,
               effects=(random_walk(0.5, "contact-area"), coulomb(1)), device=False)


FILLINGS = {0.013: 8516, 0.03: 19652, 0.076: 50016, 0.137: 89746}  # grains in a cube of 70 (G table 5.2)


def fractal(full, filling=0.076, strength=1):
    """Gas F: G 5.1, 5.3 to 5.8; in the small set in a box of half the grains of 4.x."""
    count = FILLINGS[filling] if full else round(FILLINGS[filling] / 11.75)
    return Gas(f"fractal-{filling:g}-{strength:g}", count, 1000 if full else 300, 8 if full else 3,
               filled=FILLINGS[filling] * math.pi / 6 / 70**3, effects=(impacts(0.8), coulomb(strength)),
               pictured=filling == 0.076 and strength == 1)


POLARIZABILITIES = (0, 0.005, 0.075)


def polarized(full, polarizability, speed=0):
    """Gases P and G: G 7.1 to 7.6. K Q^2 = 5e-5. Contacts are stiffer for three units: at T = 10 and A = .075 the
    overlaps are so deep that mutual polarization diverges."""
    effects = [impacts(strength=7.07e-3), coulomb(1)]
    if polarizability:
        effects.append(dipoles(polarizability))
    if speed:
        effects.append(drag(speed))
    name = f"polarized-{polarizability:g}" + (f"-blown-{speed:g}" if speed else "")
    return Gas(name, 8516 if full else 1500, 600 if full else 300, 8 if full else 3, stiff=3, steps=60,
               effects=tuple(effects), device=not polarizability and not speed,
               pictured=speed > 0)


BLOWN = 1.0  # sigma, v0: of the gas that exerts the drag


def all_gases(full=False):
    return [neutral(full), *(exchanging(full, k) for k in STRENGTHS), early(full),
            *(monopolar(full, k) for k in REPULSIONS), *(walking(full, z) for z in (0, 2, 8)), by_area(full),
            *(fractal(full, filling) for filling in FILLINGS), fractal(full, strength=0.4), fractal(full, strength=5),
            *(polarized(full, a) for a in POLARIZABILITIES), polarized(full, 0.075, BLOWN)]
