"""Short runs for these tests, made once by the program that LICHTENBERG names, in a temporary folder."""
import atexit
import contextlib
import io
import os
import subprocess
import sys
import tempfile
import unittest
import warnings
import zlib
from functools import cache
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("LICHTENBERG", str(HOME / "build/lichtenberg"))
sys.path.insert(0, str(HOME / "python"))

os.environ.setdefault("LICHTENBERG", PROGRAM)

from lichtenberg.__main__ import main  # noqa: E402
from lichtenberg.seal import FOOTER, MAGIC  # noqa: E402

long = unittest.skipUnless("LICHTENBERG_LONG" in os.environ, "is of the long tier")  # decorator of a test

_folder = tempfile.TemporaryDirectory(prefix="lichtenberg-test-")
atexit.register(_folder.cleanup)
FOLDER = Path(_folder.name)

GAS = """
title = "Few <grains> & \\"signs\\""
[units]  # </script> ends nothing
[domain]
size = [SIZE, SIZE, SIZE]
left = "periodic"
right = "periodic"
bottom = "periodic"
top = "periodic"
front = "periodic"
back = "periodic"
[[population]]
count = COUNT
temperature = 1
[effects.viscoelastic_contact]
[effects.charge_exchange]
[effects.coulomb]
sum = "minimum-image"
[stop]
time = 1
[output]
every = EVERY
picture = false
"""


def gas_scene(count=60, size=6, every=0.25):
    """Scene of `count` charged grains in a periodic cube of edge `size` (d0)."""
    return GAS.replace("COUNT", str(count)).replace("SIZE", str(size)).replace("EVERY", str(every))


def sealed(data):
    """Bytes of a result with the checksum that a run appends."""
    return bytes(data) + FOOTER.pack(MAGIC, len(data), zlib.crc32(data), 0)


def program(*words, folder=FOLDER):
    """Exit status, output and errors of the program in a folder."""
    ended = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, cwd=folder, check=False)
    return ended.returncode, ended.stdout, ended.stderr


def command(*words, folder=FOLDER):
    """Exit status, output and errors of a command in Python (plot, film, view, export), which runs in this process: a process
    of its own would import matplotlib again. The program's checks of the command line and of result files are left out."""
    output, errors, before = io.StringIO(), io.StringIO(), os.getcwd()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors), warnings.catch_warnings():
            status = main(*map(str, words))
    finally:
        os.chdir(before)
    return status, output.getvalue(), errors.getvalue()


def made(name, scene):
    (FOLDER / f"{name}.toml").write_text(scene)
    status, _, complaint = program("run", f"{name}.toml", "--quiet")
    assert status == 0, complaint
    return str(FOLDER / f"{name}.h5")


@cache
def seedling():
    """36 spheres in a plane that begin to form a tree: four frames."""
    text = (HOME / "scenes/seedling.toml").read_text().replace("time = 120.0", "time = 0.3")
    return made("seedling", text + "[output]\nevery = 0.1\npicture = false\n")


@cache
def gas():
    """60 grains in a periodic box: five frames."""
    return made("gas", gas_scene())


@cache
def periodic():
    """Two spheres between two plates in a box with two periodic axes: three frames."""
    return made(
        "periodic",
        """
title = "Two spheres between plates"
[domain]
size = [0.02, 0.016, 0.01]
left = "periodic"
right = "periodic"
bottom = "periodic"
top = "periodic"
front = { potential = 0 }
back = { potential = 100 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[conductor]]
position = [0.0001, 0.005, 0.005]
radius = 0.5e-3
charge = 1e-11
[[conductor]]
position = [0.018, 0.005, 0.005]
radius = 0.5e-3
charge = -1e-11
[effects.floating_conductors]
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[field]
accuracy = 1e-2
[output]
every = 1.0
picture = false
[stop]
time = 2.0
stationary = false
""",
    )


@cache
def electrodes_in_space():
    """Four spheres between two electrode sides and a ball electrode, two of them in contact with electrodes: three
    frames."""
    return made(
        "electrodes",
        """
title = "Electrodes in space"
[domain]
size = [0.02, 0.02, 0.02]
left = { potential = 9e3 }
right = { potential = -9e3 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[electrode]]
name = "ball"
shape = "sphere"
position = [0.01, 0.005, 0.01]
radius = 3e-3
potential = 1e3
[[conductor]]
position = [0.01, 0.0093, 0.01]
radius = 1e-3
[[conductor]]
position = [0.0013, 0.01, 0.012]
radius = 1e-3
[[conductor]]
position = [0.005, 0.015, 0.005]
radius = 1e-3
[[conductor]]
position = [0.015, 0.015, 0.015]
radius = 1e-3
[effects.floating_conductors]
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
contact_distance = 0.5e-3
[field]
accuracy = 1e-2
[stop]
time = 2e-3
[output]
every = 1e-3
picture = false
""",
    )


@cache
def unfinished_packing():
    """About 40 disks that are not at rest."""
    text = (HOME / "scenes/packing.toml").read_text().replace("count = 400", "count = 40").replace("[20e-3, 20e-3]", "[6.4e-3, 6.4e-3]")
    return made("unfinished", text.replace("[minimize]", "[minimize]\nmax_iterations = 5") + "[output]\npicture = false\n")


@cache
def packing():
    """About 40 disks that come to rest."""
    text = (HOME / "scenes/packing.toml").read_text().replace("count = 400", "count = 40").replace("[20e-3, 20e-3]", "[6.4e-3, 6.4e-3]")
    return made("packing", text + "[output]\npicture = false\n")
