#!/usr/bin/python3
"""Runs every shipped scene with one or two changed keys by the command line.

The program must end with status 0, 1 or 2, and for the latter two with an error message. It must not
print or store a non-finite number, and must end on one SIGTERM.

    mutated_scenes.py [--program build/lichtenberg] [--count 100] [--first 0] [--seconds 20] [--keep FOLDER]

Scenes are first made small: few bodies, coarse grids, short runs. The seed determines the scene, its change and the
command that reads it. Changes: a value of another size, near the limits of a double, or of another type; a key or table
that is missing, repeated or added. Exits with 1 if a scene breaks a rule, and names it.
"""
import argparse
import json
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from pathlib import Path

import h5py
import numpy as np

from random_gas_scenes import verdict

HOME = Path(__file__).resolve().parents[1]
NUMBERS = ["0", "-0.0", "-1", "1", "3", "0.5", "1e-3", "1e3", "1e9", "-1e9", "1e-9", "1e-30", "1e30", "-1e30", "1e-50", "1e50",
           "-1e50", "1e-51", "1e51", "1e-100", "1e100", "1e161", "1.7e308", "-1.7e308", "1e-308", "5e-324", "nan", "inf", "-inf",
           "2147483648", "9223372036854775807", "-9223372036854775808", "1e400", "99999999999999999999"]
LISTS = ["[]", "[0]", "[1]", "[0, 0]", "[1e-3, 2e-3]", "[2, 1]", "[nan, 1]", "[0, 0, 0]", "[1e50, -1e50]", "[[0, 0], [1, 1]]",
         '["a", "b"]', "[1, [2]]", "[0.01, 0.01, 0.01, 0.01]"]
WORDS = ['""', '"x"', '"periodic"', '"insulating"', '"all"', '"\\u001b[31mred\\u0007"', '"../../x"', '"%s%n"', '"-x"', '"a:b"']
OTHERS = ["true", "false", "{}", "{ potential = 1e50 }", "{ potential = nan }", "{ x = 1 }", "1979-05-27", "[{}]"]


def written(value):
    """Returns a TOML value; a Raw value is unchanged."""
    if isinstance(value, Raw):
        return str(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {written(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(written, value)) + "]"
    return json.dumps(value) if isinstance(value, str) else repr(value)


class Raw(str):
    """Text of a value."""


def is_tables(value):
    return isinstance(value, list) and value and all(isinstance(element, dict) for element in value)


def document(scene):
    """Returns the TOML text of tables [("header", {key: value})]."""
    return "\n".join(header + "\n" + "".join(f"{key} = {written(value)}\n" for key, value in keys) for header, keys in scene)


def tables_of(parsed, path=""):
    """Yields (header, [(key, value)]): tables get a header of their own."""
    own = [(key, value) for key, value in parsed.items() if not (isinstance(value, dict) and not is_side(key)) and not is_tables(value)]
    yield (f"[{path}]" if path else ""), own
    for key, value in parsed.items():
        inner = f"{path}.{key}" if path else key
        if is_tables(value):
            for element in value:
                yield f"[[{inner}]]", list(element.items())
        elif isinstance(value, dict) and not is_side(key):
            yield from tables_of(value, inner)


def is_side(key):
    return key in ("left", "right", "bottom", "top", "front", "back")


def fitting_cells(size):
    """Returns a number of cells along the longer side for which the shorter side has a whole number."""
    share = min(size) / max(size)
    return next(cells for cells in range(48, 200) if abs(cells * share - round(cells * share)) < 1e-9)


def small(parsed):
    """Returns the scene with few bodies, a coarse grid and a short run."""
    grains = "reference" in parsed
    kept = dict(parsed)
    factor = 1.0
    for population in kept.get("population", []):
        factor = max(factor, population["count"] / 12)
        population["count"] = min(population["count"], 12)
    if "conductor" in kept:
        kept["conductor"] = kept["conductor"][:12]
        named = {conductor.get("group") for conductor in kept["conductor"]}
        kept["group"] = [group for group in kept.get("group", []) if group["name"] in named]
    if factor > 1 and (grains or "soft_repulsion" in kept.get("effects", {})):
        size = kept["domain"]["size"]
        kept["domain"]["size"] = [max(length / factor ** (1 / len(size)), 4 if grains else 0) for length in size]
    field = kept.get("field", {})
    if "accuracy" in field:
        field["accuracy"] = max(field["accuracy"], 1e-2)
    elif not grains and "soft_repulsion" not in kept.get("effects", {}):
        field["cells"] = fitting_cells(kept["domain"]["size"])
        kept["field"] = field
    stop = kept.setdefault("stop", {})
    stop["time"] = 0.05 if grains else 1e-4
    output = kept.setdefault("output", {})
    output.update(picture=False, every=stop["time"] / 2)
    if "soft_repulsion" in kept.get("effects", {}):
        del kept["stop"], output["every"]
    for stage in kept.get("equilibration", []):
        stage["duration"] = min(stage["duration"], 0.02)
    return [(header, keys) for header, keys in tables_of(kept) if header or keys]


def known_keys(program):
    """Returns {table: [key]} as listed in the program's help."""
    text = subprocess.run([program, "help", "scene"], capture_output=True, text=True, check=True).stdout
    keys, table = {}, ""
    for line in text.splitlines():
        if line.startswith("["):
            table = line.strip()
            keys[table] = []
        elif match := re.match(r"    (\w+)\s", line):
            if table:
                keys[table].append(match[1])
    return keys


def drawn_value(dice, before):
    """Returns a random value that replaces another."""
    number = isinstance(before, (int, float)) and not isinstance(before, bool)
    if number and dice.random() < 0.6:
        factor = 10.0 ** dice.choice((-300, -45, -30, -20, -9, -6, -3, -2, -1, -0.3, 0.3, 1, 2, 3, 6, 9, 20, 30, 45, 300))
        value = before * factor
        return Raw(str(int(value)) if isinstance(before, int) and abs(value) < 1e18 else repr(value))
    if isinstance(before, list) and before and dice.random() < 0.6:
        index = dice.randrange(len(before))
        return [drawn_value(dice, value) if k == index else value for k, value in enumerate(before)]
    if isinstance(before, str) and dice.random() < 0.5:
        return Raw(dice.choice(WORDS))
    return Raw(dice.choice(dice.choice((NUMBERS, NUMBERS, NUMBERS, LISTS, WORDS, OTHERS))))


def change(dice, scene, known):
    """Changes one key or table in place. Returns a description."""
    table = dice.randrange(len(scene))
    header, keys = scene[table]
    kind = dice.choices(("value", "missing", "twice", "added", "table gone", "table twice"), (70, 7, 5, 13, 3, 2))[0]
    if kind == "table gone":
        return f"without {scene.pop(table)[0]}"
    if kind == "table twice":
        scene.append((header, list(keys)))
        return f"{header} twice"
    if kind == "added":
        header = dice.choice(list(known))
        if not known[header]:
            return "nothing"
        key, value = dice.choice(known[header]), drawn_value(dice, dice.choice((1.0, 1, [1.0, 1.0], "a")))
        for there, others in scene:
            if there == header and all(name != key for name, _ in others):
                others.append((key, value))
                return f"{header} {key} = {written(value)}"
        scene.append((header, [(key, value)]))
        return f"{header} {key} = {written(value)}"
    if not keys:
        return "nothing"
    k = dice.randrange(len(keys))
    key, value = keys[k]
    if kind == "missing":
        del keys[k]
        return f"{header} without {key}"
    if kind == "twice":
        keys.append((key, value))
        return f"{header} {key} twice"
    keys[k] = (key, drawn_value(dice, value))
    return f"{header} {key} = {written(keys[k][1])}"


def drawn_scene(seed, scenes, known):
    """Returns the scene's name, text, changes and command."""
    dice = random.Random(seed)
    name = dice.choice(sorted(scenes))
    scene = [(header, list(keys)) for header, keys in small(tomllib.loads(scenes[name]))]
    changes = [change(dice, scene, known) for _ in range(dice.choice((1, 1, 2)))]
    is_field = any("floating_conductors" in header for header, _ in scene)
    commands = [["explain"], ["explain"], ["run", "--overwrite"], ["run", "--overwrite", "--quiet"]]
    if is_field:
        commands += [["solve"], ["solve", "--json"], ["solve", "--capacitance"]]
    return name, document(scene), "; ".join(changes), dice.choice(commands)


PATIENCE = 30  # s, longer than the program's own time limit after SIGTERM for a step without end


def execute(command, folder, seconds):
    """Returns the status, standard error, standard output, and whether it was stopped by SIGTERM or, if that had no
    effect, by SIGKILL."""
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace")
    try:
        output, errors = process.communicate(timeout=seconds)
        return process.returncode, errors, output, ""
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGTERM)
    try:
        output, errors = process.communicate(timeout=seconds + PATIENCE)
        return process.returncode, errors, output, "stopped"
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return None, "", "", "deaf"


def numbers_that_are_none(path):
    """Returns the first dataset of a result's particles with a non-finite number; empty if there is none."""
    found = []

    def look(name, node):
        wanted = name.startswith("particles/") and name.endswith("/value")
        if not found and wanted and isinstance(node, h5py.Dataset) and node.dtype.kind == "f" and not np.isfinite(node[()]).all():
            found.append(name)

    with h5py.File(path, "r") as file:
        file.visititems(look)
    return found[0] if found else ""


def fault(command, folder, seconds):
    """Returns the fault of the command (empty: none), its messages and how it ended."""
    status, errors, output, stopped = execute(command, folder, seconds)
    if stopped == "deaf":
        return "does not end on SIGTERM", errors, "deaf"
    if stopped:
        if "stopping at once" in errors:
            return "does not end its step after SIGTERM", errors, "stopped"
        if status not in (-signal.SIGTERM, 0, 1, 2, 128 + signal.SIGTERM):
            return f"ended with {status} after SIGTERM", errors, "stopped"
        return ("takes too long to explain" if command[1] == "explain" else ""), errors, "stopped"
    wrong = verdict(status, errors, output)
    result = folder / "scene.h5"
    if not wrong and "\x1b" in output + errors:
        wrong = "prints an escape sequence"
    if not wrong and status == 0 and command[1] == "run" and result.exists():
        if bad := numbers_that_are_none(result):
            wrong = f"leaves a number that is none in {bad}"
    return wrong, errors, status


def check_all(arguments, program, scenes, known):
    """Returns the number of faulty scenes, and how commands ended."""
    broken, ends = 0, Counter()
    with tempfile.TemporaryDirectory(prefix="lichtenberg-mutated-") as name:
        folder = Path(name)
        for seed in range(arguments.first, arguments.first + arguments.count):
            for old in folder.iterdir():
                shutil.rmtree(old) if old.is_dir() else old.unlink()
            scene, text, changes, (command, *options) = drawn_scene(seed, scenes, known)
            (folder / "scene.toml").write_text(text)
            wrong, errors, end = fault([program, command, "scene.toml", *options], folder, arguments.seconds)
            ends[command, end] += 1
            if end == "stopped":
                print(f"seed {seed}: {command} {scene}: {changes}: stopped after {arguments.seconds:g} s", flush=True)
            if not wrong:
                continue
            broken += 1
            print(f"seed {seed}: {command} {scene}: {changes}: {wrong}: {errors.strip().splitlines()[-1:]}", flush=True)
            if arguments.keep:
                arguments.keep.mkdir(exist_ok=True)
                (arguments.keep / f"mutated-{seed}.toml").write_text(text)
    return broken, ends


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=HOME / "build/lichtenberg")
    parser.add_argument("--count", type=int, default=100, help="scenes")
    parser.add_argument("--first", type=int, default=0, help="seed")
    parser.add_argument("--seconds", type=float, default=20, help="after which a command gets SIGTERM")
    parser.add_argument("--keep", type=Path, help="folder for the scenes that break the rule")
    arguments = parser.parse_args()
    program = str(arguments.program.resolve())
    scenes = {path.name: path.read_text() for path in (HOME / "scenes").glob("*.toml")}
    broken, ends = check_all(arguments, program, scenes, known_keys(program))
    summary = ", ".join(f"{command} {end}: {count}" for (command, end), count in sorted(ends.items(), key=str))
    print(f"{arguments.count} scenes from seed {arguments.first} on: {broken} break the rule; {summary}")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
