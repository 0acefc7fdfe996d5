#!/usr/bin/python3
"""Row 15: regular arrays of perfect conductors (Rayleigh 1892, Perrins 1979, McPhedran and McKenzie 1978).

One cylinder of a square array, or one sphere of a simple cubic array, lies in the middle of its cell between two
electrodes. The other sides are insulating: by symmetry this is the field of the infinite array. The permittivity of the array is
the charge of an electrode over that of the empty cell.
"""

import json
import math
import tempfile
from pathlib import Path

from experiments import bounds, open_experiment, picture, published, record, row, run

ACCURACY = 1e-6
EXPECTED = "The cell between electrodes has the field of the infinite array, so that all published digits are found."
EXPECTED_SERIES = "The series of Rayleigh is right within its first omitted term, which is below 0.001 here."
CYLINDERS = {0.3: 1.860, 0.5: 3.080, 0.7: 7.433}  # Perrins, McKenzie and McPhedran 1979, table 1, conducting cylinders
SPHERES = {0.2: 1.76, 0.4: 3.26, 0.5: 5.89}  # McPhedran and McKenzie 1978, simple cubic array, three digits

SCENE = """
[domain]
size = {size}
left = {{ potential = 1 }}
right = {{ potential = 0 }}
[medium]
permittivity = 1
[[conductor]]
position = {centre}
radius = {radius!r}
[effects.floating_conductors]
[field]
{field}
"""


def permittivity(program, filling, dimension):
    """Returns the permittivity of the array over that of the medium. A unit cell has this filling."""
    if dimension == 2:
        radius, field = math.sqrt(filling / math.pi), f'method = "multipole"\ntolerance = {ACCURACY}'
    else:
        radius, field = (3 * filling / (4 * math.pi)) ** (1 / 3), f"tolerance = {ACCURACY}"
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "array.toml"
        scene.write_text(SCENE.format(size=[1] * dimension, centre=[0.5] * dimension, radius=radius, field=field))
        answer = json.loads(run(program, "solve", scene, "--json"))
    return answer["electrodes"][0]["charge"] / (answer.get("depth", 1) if dimension == 2 else 1)


def rayleigh(filling):
    """Returns Rayleigh's permittivity of conducting cylinders, 1 + 2 f/(1 - f - 0.3058 f^4)."""
    return 1 + 2 * filling / (1 - filling - 0.305827 * filling**4)


def half_digit(text_digits, value):
    """Returns the bounds of a value that was rounded to this many decimals."""
    half = 0.5 * 10**-text_digits
    return value - half, value + half


def main():
    request = open_experiment(15, "Rayleigh 1892; Perrins 1979; McPhedran, McKenzie 1978", __doc__)
    rows = []
    for dimension, name, table, digits in ((2, "square array of cylinders", CYLINDERS, 3),
                                           (3, "simple cubic array of spheres", SPHERES, 2)):
        for filling, value in list(table.items())[:1 if request.quick else None]:
            found = permittivity(request.program, filling, dimension)
            rows.append(row(f"permittivity of a {name}, filling {filling}", EXPECTED,
                            published(value, *half_digit(digits, value), "M"), bounds(found, ACCURACY * found)))
    series, omitted = rayleigh(0.2), 2 * 0.2 * 0.0134 * 0.2**8
    found = permittivity(request.program, 0.2, 2)
    rows.append(row("permittivity of a square array of cylinders, filling 0.2, by Rayleigh's series", EXPECTED_SERIES,
                    published(round(series, 7), series - omitted, series + omitted, "M"),
                    bounds(found, ACCURACY * found)))

    def draw(axes):
        fillings = [0.05 * k for k in range(1, 16)]
        axes.plot(fillings, [permittivity(request.program, f, 2) for f in fillings], label="cylinders, ours")
        axes.plot(CYLINDERS.keys(), CYLINDERS.values(), "o", label="cylinders, published")
        axes.plot(SPHERES.keys(), SPHERES.values(), "s", label="spheres, published")
        axes.set(xlabel="filling", ylabel="permittivity")

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
