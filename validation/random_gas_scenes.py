#!/usr/bin/python3
"""Runs random scene files of gases by the command line.

A run must end with status 0, 1 or 2, never by a signal, and its messages must be the program's own.

    random_gas_scenes.py [--program build/lichtenberg] [--count 100] [--first 0] [--seconds 20] [--keep FOLDER]

A seed determines keys, values and tables. Most values are sensible, some near the limits of a double, some of the wrong
type. Exits with 1 if a scene breaks a rule, and names it.
"""
import argparse
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

SIDES = ("left", "right", "bottom", "top", "front", "back")
EXTREME = ("0", "-1", "1e-300", "1e-30", "1e-6", "1e6", "1e30", "1e300", "nan", "inf", '"all"', "true", "[1, 2]", "1")
FOREIGN = ("boost", "H5", "HDF5", "std::", "filesystem", "basic_string", "terminate", "Traceback", "PETSC ERROR", "bad_")
NUMBER_THAT_IS_NONE = re.compile(r"(?<![\w\"])[-+]?(nan|inf)(?![\w\"])")


def decades(dice, low, high):
    return f"{10 ** dice.uniform(low, high):.4g}"


def value(dice, sensible, wild):
    return dice.choice(EXTREME) if dice.random() < wild else sensible


def table(dice, wild, name, alternatives):
    """Returns a table with one of the alternative sets of keys: texts unchanged, of other keys a random selection.
    Sensible values are functions of the dice."""
    lines = [name]
    for key, draw in dice.choice(alternatives).items():
        if isinstance(draw, str):
            lines.append(f"{key} = {draw}")
        elif dice.random() < 0.6:
            lines.append(f"{key} = {value(dice, draw(dice), wild)}")
    return "\n".join(lines) + "\n"


def words(*choices):
    return lambda dice: '"' + dice.choice(choices) + '"'


def between(low, high):
    return lambda dice: decades(dice, low, high)


def whole(low, high):
    return lambda dice: str(dice.randint(low, high))


def flag(dice):
    return dice.choice(("true", "false"))


COULOMB = {"coupling_constant": between(-5, 1)}
EXCHANGE = {"transfer_prefactor": between(-4, 0), "capacity": between(1, 2)}
POPULATION = {"temperature": between(-6, 1), "min_gap": between(-3, -1),
              "radius": lambda dice: dice.choice(("0.5", "0.4", "[0.3, 0.6]"))}
EFFECTS = {
    "viscoelastic_contact": [{"stiffness": between(1.5, 4), "damping": between(0, 2)}],
    "linear_contact": [{"stiffness": between(1.5, 4), "restitution": between(-1, 0)}],
    "coulomb": [COULOMB | {"accuracy": between(-7, -1)}, COULOMB | {"accuracy": between(-4, -1), "order": whole(4, 8)},
                COULOMB | {"cutoff": between(0, 0.5), "mesh": whole(8, 40), "order": whole(4, 8), "alpha": between(-1, 0.3)},
                COULOMB | {"sum": '"ewald"', "accuracy": between(-9, -1)}, COULOMB | {"sum": '"minimum-image"'},
                COULOMB | {"sum": '"shifted-force"', "cutoff": between(0, 0.5), "damping": between(-2, 0)}],
    "charge_exchange": [EXCHANGE | {"model": '"impact"', "exponent": between(-1, 0.5), "each_step": flag},
                        EXCHANGE | {"model": '"random-walk"', "rate": between(-1, 2)},
                        EXCHANGE | {"model": '"contact-area"', "rate": between(-1, 2)}, {"model": '"none"'}],
    "induced_dipoles": [{"polarizability": between(-3, -1.3), "tolerance": between(-6, -2),
                         "sum": words("ewald", "mixed-consistent", "minimum-image", "source")}],
    "gas_drag": [{"stokes": between(-2, 1), "speed": between(-1, 1), "correlation_time": between(-2, 0)}],
    "uniform_force": [{"acceleration": "[0, 0, 1e-3]"}],
}
POPULATIONS = [POPULATION, POPULATION | {"charge": between(-2, 1)},
               POPULATION | {"charge": "1", "charge_distribution": '"gaussian"'},
               POPULATION | {"charge": "2", "charge_distribution": '"exponential-power"', "charge_exponent": "0.8"}]
STAGES = [{"elastic": flag, "stiffness": between(0, 2), "temperature": between(-3, 1)}]
MECHANICS = [{"integrator": words("multirate", "verlet", "gear", "gear-printed", "cvode"), "step": between(-3.5, -2.5),
              "threads": whole(1, 3)}, {"step": between(-3, 0.5), "contact_substeps": whole(10, 60), "threads": whole(1, 3)}]


def scene(seed):
    """Returns the scene text and the command line."""
    dice = random.Random(seed)
    wild = dice.choice((0, 0, 0.03, 0.15))
    chance = lambda p: dice.random() < p
    edge = [value(dice, f"{dice.uniform(2.5, 12):.3f}", wild / 3) for _ in range(2 if chance(0.03) else 3)]
    text = f"[units]\n[domain]\nsize = [{', '.join(edge)}]\n"
    text += "\n".join(f'{side} = "periodic"' for side in SIDES[:2 * len(edge)] if not chance(wild / 6)) + "\n"
    for _ in range(dice.choice((0, *10 * (1,), 2, 2))):
        text += table(dice, wild, f"[[population]]\ncount = {dice.randint(1, 40)}", POPULATIONS)
    contact = dice.choice(("viscoelastic_contact", "viscoelastic_contact", "linear_contact"))
    for name, alternatives in EFFECTS.items():
        if name == contact or chance({"coulomb": 0.6, "charge_exchange": 0.5, "linear_contact": 0.02, "viscoelastic_contact": 0.02}.get(name, 0.1)):
            text += table(dice, wild, f"[effects.{name}]", alternatives)
    for _ in range(dice.choice((0, 0, 1, 2))):
        text += table(dice, wild, f"[[equilibration]]\nduration = {value(dice, decades(dice, -2, -1), wild)}", STAGES)
    if chance(0.5):
        text += table(dice, wild, "[mechanics]", MECHANICS)
    text += f"[stop]\ntime = {value(dice, decades(dice, -2, -0.5), wild)}\n[output]\npicture = false\n"
    text += f"every = {value(dice, decades(dice, -2, 0), wild / 3)}\n"
    return text, dice.choice((["explain"], ["run", "--overwrite"], ["run", "--overwrite", "--quiet"]))


def run(command, folder, seconds):
    """Returns the status (None: stopped), standard error and standard output."""
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=seconds)
    except subprocess.TimeoutExpired:
        return None, "", ""
    return done.returncode, done.stderr, done.stdout


def verdict(status, errors, output):
    """Returns the fault; empty if there is none."""
    if status is None:
        return ""
    if status not in (0, 1, 2):
        return f"ended with {status}"
    if status != 0 and "lichtenberg: " not in errors:
        return f"status {status} without an error message"
    foreign = next((word for word in FOREIGN if word in errors), None)
    if foreign:
        return f"says {foreign}"
    found = NUMBER_THAT_IS_NONE.search(output)
    if status == 0 and found:
        return f"prints {found[0]}"
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=Path("build/lichtenberg"))
    parser.add_argument("--count", type=int, default=100, help="scenes")
    parser.add_argument("--first", type=int, default=0, help="seed")
    parser.add_argument("--seconds", type=float, default=20, help="after which a run is stopped, which is no failure")
    parser.add_argument("--keep", type=Path, help="folder for the scenes that break the rule")
    arguments = parser.parse_args()
    program, broken, statuses = str(arguments.program.resolve()), 0, {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for seed in range(arguments.first, arguments.first + arguments.count):
            text, (command, *options) = scene(seed)
            (folder / "gas.toml").write_text(text)
            status, errors, output = run([program, command, "gas.toml", *options], folder, arguments.seconds)
            statuses[status] = statuses.get(status, 0) + 1
            wrong = verdict(status, errors, output)
            if not wrong:
                continue
            broken += 1
            print(f"seed {seed}: {command}: {wrong}: {errors.strip().splitlines()[-1:]}")
            if arguments.keep:
                arguments.keep.mkdir(exist_ok=True)
                (arguments.keep / f"gas-{seed}.toml").write_text(text)
    print(f"{arguments.count} scenes from seed {arguments.first} on: {broken} break the rule; by status "
          + ", ".join(f"{'stopped' if s is None else s}: {n}" for s, n in sorted(statuses.items(), key=str)))
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
