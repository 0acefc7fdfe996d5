#!/usr/bin/python3
"""Row 7: two conducting balls on the lower plate of a condenser (Galatola 2006).

Both balls have the potential of the lower plate, and the field between the plates polarizes them. The plates screen their
repulsion: its energy far off is proportional to K_0(r / lambda), and the force to K_1(r / lambda). The length lambda
follows from the force at two distances.
"""

import json
import math
import tempfile
from pathlib import Path

from experiments import bounds, open_experiment, picture, published, record, row, run

EXPECTED = ("The slowest mode between two plates decays over gap / pi. The next mode decays twice as fast, so that the "
            "length approaches this value exponentially and does not depend on the radius.")
RADII = (0.1, 0.2, 0.3)  # gaps
DISTANCES = (2.5, 2.75, 3.0)  # gaps, equally spaced
NEXT_MODE = math.exp(-math.pi * (DISTANCES[1] - DISTANCES[0]))  # factor of the next mode's share from one to the next

# The sides across are five gaps away, where the images of the balls have no effect. A clearance of 0.1 % of the radius
# keeps the ball off the plate.
SCENE = """
[domain]
size = [16, 10, 1]
back = {{ potential = 1 }}
front = {{ potential = 0 }}
[medium]
permittivity = 1
[effects.floating_conductors]
[field]
tolerance = 1e-11
[[group]]
name = "balls"
potential = 0
[[conductor]]
position = [{left!r}, 5, {height!r}]
radius = {radius!r}
group = "balls"
[[conductor]]
position = [{right!r}, 5, {height!r}]
radius = {radius!r}
group = "balls"
"""


def k1(x):
    """Returns the modified Bessel function K_1 (x > 0.5): the trapezoidal rule of its integral converges exponentially."""
    step = 0.05
    return step * math.fsum((1 if k else 0.5) * math.exp(-x * math.cosh(k * step)) * math.cosh(k * step) for k in range(160))


def repulsion(program, radius, distance):
    """Returns the force between two balls (permittivity x V^2); lengths in gaps of the condenser."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "balls.toml"
        scene.write_text(SCENE.format(left=8 - distance / 2, right=8 + distance / 2, height=1.001 * radius, radius=radius))
        answer = json.loads(run(program, "solve", scene, "--json"))
    return answer["conductors"][1]["force"][0]


def length_between(one, other, ratio):
    """Returns lambda for which K_1(other / lambda) / K_1(one / lambda) is the ratio, by bisection."""
    low, high = 0.1, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if k1(other / middle) / k1(one / middle) < ratio else (low, middle)
    return 0.5 * (low + high)


def screening_length(program, radius):
    """Returns lambda pi / gap for large distances and the size of its extrapolation."""
    force = [repulsion(program, radius, distance) for distance in DISTANCES]
    first, second = (math.pi * length_between(DISTANCES[k], DISTANCES[k + 1], force[k + 1] / force[k]) for k in (0, 1))
    correction = (second - first) * NEXT_MODE / (1 - NEXT_MODE)
    return second + correction, abs(correction)


def main():
    request = open_experiment(7, "Galatola 2006", __doc__)
    rows = []
    for radius in RADII[1:2] if request.quick else RADII:
        value, error = screening_length(request.program, radius)
        rows.append(row(f"decay length of the pair energy over gap / pi, balls of radius {radius} gaps", EXPECTED,
                        published(1, 1, 1, "A"), bounds(value, error)))

    def draw(axes):
        distances = [0.8 + 0.2 * k for k in range(12)]
        for radius in RADII:
            force = [repulsion(request.program, radius, distance) for distance in distances]
            last = k1(math.pi * distances[-1])
            axes.semilogy(distances, [f / force[-1] for f in force], "o", label=f"radius {radius} gaps")
        axes.semilogy(distances, [k1(math.pi * d) / last for d in distances], label="$K_1(\\pi r/d)$")
        axes.set(xlabel="distance (gaps)", ylabel="force over that at the largest distance")

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
