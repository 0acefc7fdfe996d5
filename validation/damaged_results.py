#!/usr/bin/python3
"""Damages result files by many methods and runs the Python readers and `analyse` on them (validation/fuzz: the others).

    damaged_results.py [--files 2000] [--seed 1] [--first 0] [--readers 1] [--jobs 1] [--keep FOLDER]

Each file is the result of a short run (conductors, a gas, a packing, a run with separate segments of frames). Damages
are flipped bits, a range of zeros, a missing end, exchanged blocks, or an object changed by h5py. The checksum is
unchanged, damaged, or made valid again. A reader may refuse a file (exit status 1 or 2 and an error message) or read
it. It fails if it ends by a signal, takes more than a minute, prints a Python traceback, or prints nan with status 0.
The exit status is the number of failures, at most 100. File k of a seed is the same each time.
"""
import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/python"))

from runs import FOOTER, HOME, MAGIC, PROGRAM, gas_scene, sealed  # noqa: E402

LIMIT = 60  # s, per reader

CONDUCTORS = """
title = "Conductors"
[domain]
size = [1.2e-2, 1.2e-2]
bottom = { potential = 0.0 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[population]]
count = 9
radius = 0.775e-3
min_gap = 0.1e-3
[effects.floating_conductors]
[effects.current_injection]
current = 0.2e-9
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
[field]
cells = 32
[output]
every = 0.01
checkpoint_every = 2
picture = false
[stop]
time = 0.04
"""

PACKING = """
title = "Packing"
[domain]
size = [4e-3, 4e-3]
[[population]]
count = 18
radius = [0.4e-3, 0.5e-3]
overlapping = true
[effects.soft_repulsion]
stiffness = 1e-6
[minimize]
force_tolerance = 1e-6
[output]
picture = false
"""


class Source:
    """Intact result with its run and its readers."""

    def __init__(self, folder, name, scene, readers):
        self.name, self.readers = name, readers
        self.scene = folder / f"{name}.toml"
        self.file = folder / f"{name}.h5"
        self.scene.write_text(scene)

    def run(self):
        subprocess.run([PROGRAM, "run", self.scene, "--out", self.file, "--quiet"], check=True)
        return self

    def interrupt_once_frames_stand_beside(self):
        """Ends the run while the file is an index of segments."""
        process = subprocess.Popen([PROGRAM, "run", self.scene, "--out", self.file, "--quiet"], stderr=subprocess.DEVNULL)
        while process.poll() is None and not (self.file.exists() and list(self.segments.glob("segment-*.h5"))):
            try:
                process.wait(0.02)
            except subprocess.TimeoutExpired:
                pass
        process.send_signal(signal.SIGTERM)
        process.wait()
        assert self.segments.exists(), "the run has left no segments"
        return self

    @property
    def segments(self):
        return Path(f"{self.file}.frames")


def make_sources(folder, with_segments):
    common = ["view", "xyz", "csv", "vtk", "load", "load", "plot", "analyse"]
    sources = [
        Source(folder, "conductors", CONDUCTORS, common + ["series"]).run(),
        Source(folder, "gas", gas_scene(40), common).run(),
        Source(folder, "packing", PACKING, common).run(),
    ]
    subprocess.run([PROGRAM, "analyse", sources[0].file], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([PROGRAM, "analyse", sources[1].file], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([PROGRAM, "network", sources[2].file, "--no-picture"], check=True, stdout=subprocess.DEVNULL)
    if with_segments:
        frames = Source(folder, "frames", gas_scene(3000, 40, 0.01), ["load", "csv", "analyse"])
        sources.append(frames.interrupt_once_frames_stand_beside())
    return sources


# ---- Damages of bytes without the checksum ----


def flip_bits(chance, data):
    for _ in range(chance.choice([1, 1, 3, 20])):
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)


def flip_bits_of_structure(chance, data):
    """Flips bits near HDF5's signatures, in its structure data."""
    marks = [m.start() for m in re.finditer(rb"TREE|HEAP|SNOD|GCOL|OHDR|\x89HDF", bytes(data))]
    for _ in range(chance.choice([1, 2, 6])):
        at = chance.choice(marks) + chance.randrange(200)
        if at < len(data):
            data[at] ^= 1 << chance.randrange(8)


def zero_range(chance, data):
    begin = chance.randrange(len(data))
    length = chance.choice([8, 64, 512, 4096, len(data)])
    data[begin : begin + length] = bytes(len(data[begin : begin + length]))


def random_range(chance, data):
    begin = chance.randrange(len(data))
    data[begin : begin + 256] = chance.randbytes(len(data[begin : begin + 256]))


def swap_blocks(chance, data):
    size = chance.choice([16, 512, 4096])
    a, b = (chance.randrange(max(1, len(data) // size)) * size for _ in range(2))
    first, second = bytes(data[a : a + size]), bytes(data[b : b + size])
    if len(first) == len(second):
        data[a : a + size], data[b : b + size] = second, first


def truncate(chance, data):
    del data[chance.randrange(len(data)) :]


BYTE_DAMAGES = [flip_bits, flip_bits_of_structure, flip_bits_of_structure, zero_range, random_range, swap_blocks, truncate]


# ---- Damages by h5py, which leave a file that is valid for HDF5 ----


def objects_of(file):
    found = []
    file.visititems(lambda name, thing: found.append(name))
    return found


def datasets_of(file):
    return [name for name in objects_of(file) if isinstance(file[name], h5py.Dataset)]


def replace(file, name, **new):
    attributes = dict(file[name].attrs)
    del file[name]
    dataset = file.create_dataset(name, **new)
    for key, value in attributes.items():
        dataset.attrs[key] = value


def other_type(chance, file):
    name = chance.choice(datasets_of(file))
    kind = chance.choice(["i1", "u8", "f4", ">f8", "S5", h5py.string_dtype(), np.dtype([("a", "f8"), ("b", "i4")]), "i4"])
    shape = file[name].shape
    if isinstance(kind, str):
        return replace(file, name, data=np.ones(shape).astype(kind))
    replace(file, name, shape=shape, dtype=kind)


def other_shape(chance, file):
    name = chance.choice(datasets_of(file))
    shape = list(file[name].shape) or [1]
    k = chance.randrange(len(shape))
    shape[k] = chance.choice([0, 1, shape[k] + 1, 2 * shape[k], max(shape[k] - 1, 0)])
    shape = chance.choice([shape, shape[1:], [*shape, 2], [3], []])
    kind = file[name].dtype
    replace(file, name, data=np.ones(shape).astype(kind) if kind.kind in "fiu" else "text")


def huge_shape(chance, file):
    name = chance.choice(datasets_of(file))
    dimension = max(1, len(file[name].shape))
    shape = [chance.choice([10**6, 10**9, 2**62])] + [4] * (dimension - 1)
    shape = shape if np.prod([float(n) for n in shape]) < 2.0**60 else [2**40] + [4] * (dimension - 1)
    replace(file, name, shape=shape, dtype="f8", chunks=(64,) + (4,) * (dimension - 1))


def strange_numbers(chance, file):
    name = chance.choice([n for n in datasets_of(file) if file[n].dtype.kind in "fiu"])
    dataset = file[name]
    if dataset.dtype.kind == "f":
        dataset[...] = chance.choice([np.nan, np.inf, 1e308, -1e308, 0.0, -1.0, 1e-320])
    else:
        dataset[...] = chance.choice([-1, 0, 2**31 - 1, -(2**31)]) if dataset.dtype.kind == "i" else 2**31


def one_strange_number(chance, file):
    name = chance.choice([n for n in datasets_of(file) if file[n].dtype.kind in "fi" and file[n].size])
    values = file[name][()]
    flat = np.atleast_1d(values).reshape(-1)
    flat[chance.randrange(flat.size)] = chance.choice([-1, 7, 10**6]) if flat.dtype.kind == "i" else np.nan
    file[name][...] = flat.reshape(np.shape(values))


def missing(chance, file):
    del file[chance.choice(objects_of(file))]


def group_for_dataset(chance, file):
    name = chance.choice(objects_of(file))
    was_group = isinstance(file[name], h5py.Group)
    del file[name]
    if was_group:
        file[name] = np.arange(4.0)
    else:
        file.create_group(name)


def strange_attribute(chance, file):
    owners = ["/", *objects_of(file)]
    owners = [name for name in owners if len(file[name].attrs)]
    owner = file[chance.choice(owners)]
    name = chance.choice(list(owner.attrs))
    values = [3.5, np.arange(5000), "", "x" * 5000, np.array(["a", "b"], dtype=h5py.string_dtype()), b"\xff\xfe", -1, 2**62]
    del owner.attrs[name]
    if chance.random() < 0.8:
        owner.attrs[name] = values[chance.randrange(len(values))]


def strange_link(chance, file):
    name = chance.choice(objects_of(file))
    del file[name]
    file[name] = chance.choice([h5py.SoftLink("/" + name), h5py.SoftLink("/"), h5py.ExternalLink("/dev/zero", "/x")])


def strange_scene(chance, file):
    if "scene/text" not in file:  # a segment of frames
        return missing(chance, file)
    text = file["scene/text"][()].decode()
    at = chance.randrange(len(text))
    file["scene/text"][()] = chance.choice([text[:at], text[:at] + "\x01" + text[at:], "", text.replace("1", "9", 1)])


H5PY_DAMAGES = [other_type, other_shape, other_shape, huge_shape, strange_numbers, one_strange_number, missing,
                group_for_dataset, strange_attribute, strange_link, strange_scene]  # fmt: skip


def damage_file(chance, path):
    """Damages the file. Returns a description."""
    if chance.random() < 0.45:
        kind = chance.choice(H5PY_DAMAGES)
        with h5py.File(path, "r+") as file:
            kind(chance, file)
        if chance.random() < 0.85:
            path.write_bytes(sealed(path.read_bytes()))
            return f"{kind.__name__}, sealed"
        return kind.__name__
    whole = path.read_bytes()
    data, footer = bytearray(whole[: -FOOTER.size]), bytearray(whole[-FOOTER.size :])
    kind = chance.choice(BYTE_DAMAGES)
    ending = chance.choice(["sealed"] * 6 + ["as it was", "mark damaged", "mark missing", "tail of zeros"])
    if ending == "tail of zeros":
        length = min(len(whole), chance.choice([8, 24, 100, 5000, len(whole) // 2]))
        path.write_bytes(whole[:-length] + bytes(length))
        return ending
    kind(chance, data)
    if ending == "mark damaged":
        footer[chance.randrange(len(MAGIC))] ^= 1 << chance.randrange(8)
    path.write_bytes(sealed(data) if ending == "sealed" else bytes(data) + (b"" if ending == "mark missing" else bytes(footer)))
    return f"{kind.__name__}, {ending}"


# ---- Readers ----

LOAD = """
import sys, warnings; sys.path.insert(0, sys.argv[1]); warnings.simplefilter("ignore")
import lichtenberg
try:
    with lichtenberg.load(sys.argv[2]) as result:
        [result[name] for name in result.columns], result.tables, result.observables, result.summary, result.provenance
        [frame.time for frame in result], result.scene, result.title, result.field
except lichtenberg.InputError as error:
    sys.exit(f"lichtenberg: {error}")
"""


def command(reader, path):
    out = path.parent / "out"
    words = {
        "analyse": ["analyse", path],
        "plot": ["plot", path, "--out", f"{out}.png"],
        "series": ["plot", "--series", path, "--out", f"{out}.png"],
        "view": ["view", path, "--out", f"{out}.html"],
        "xyz": ["export", path, "--to", "xyz", "--out", f"{out}.xyz"],
        "csv": ["export", path, "--to", "csv", "--out", f"{out}-csv"],
        "vtk": ["export", path, "--to", "vtk", "--out", f"{out}-vtk"],
    }
    if reader == "load":
        return ["/usr/bin/python3", "-c", LOAD, str(HOME / "python"), str(path)]
    return [PROGRAM, *map(str, words[reader])]


def trouble(words):
    """Returns the failure of a reader, or None."""
    process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True, errors="replace", start_new_session=True)  # fmt: skip
    try:
        out, err = process.communicate(timeout=LIMIT)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return f"no end after {LIMIT} s"
    if process.returncode < 0 or process.returncode > 2:
        return f"status {process.returncode}: {err[-300:]}"
    if "Traceback" in err or "terminate called" in err:
        return err[-600:]
    if process.returncode == 0 and re.search(r"(?<![\w.])-?nan\b", out, re.IGNORECASE):
        return f"nan: {re.search(r'.*nan.*', out, re.IGNORECASE)[0]}"
    if process.returncode > 0 and not err.strip():
        return "no sentence"
    return None


def try_file(sources, seed, number, count, keep):
    """Returns messages on the failures of `count` readers of file `number`."""
    chance = random.Random(f"{seed} {number}")
    weights = [1 if source.name == "frames" else 10 for source in sources]
    source = chance.choices(sources, weights)[0]
    readers = [chance.choice(source.readers) for _ in range(count)]
    found = []
    with tempfile.TemporaryDirectory(prefix="lichtenberg-damaged-") as folder:
        damaged = Path(folder) / source.file.name
        shutil.copy(source.file, damaged)
        segment = None
        if source.segments.exists():
            shutil.copytree(source.segments, f"{damaged}.frames")
            segment = chance.choice(sorted(Path(f"{damaged}.frames").iterdir()))
        what = damage_file(chance, segment if segment and chance.random() < 0.5 else damaged)
        before = damaged.read_bytes()
        for reader in readers:
            wrong = trouble(command(reader, damaged))
            if wrong:
                found.append(f"file {number}: {source.name}, {what}: {reader}: {wrong}")
                if keep:
                    kept = Path(keep) / f"{number}-{reader}-{damaged.name}"
                    kept.write_bytes(before)
                    if segment:
                        shutil.copytree(f"{damaged}.frames", f"{kept}.frames", dirs_exist_ok=True)
            for left in Path(folder).glob("out*"):
                shutil.rmtree(left) if left.is_dir() else left.unlink()
            damaged.write_bytes(before)  # analyse writes to it
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--files", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="number of the first file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--readers", type=int, default=1, help="of each file")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--keep", help="folder for the files that a reader fails on")
    parser.add_argument("--no-segments", action="store_true", help="omit results with frames in separate files")
    request = parser.parse_args()
    os.environ["HDF5_USE_FILE_LOCKING"] = "FALSE"
    if request.keep:
        Path(request.keep).mkdir(exist_ok=True)
    failures = 0
    with tempfile.TemporaryDirectory(prefix="lichtenberg-sound-") as folder, ThreadPoolExecutor(request.jobs) as pool:
        sources = make_sources(Path(folder), not request.no_segments)
        numbers = range(request.first, request.first + request.files)
        tried = pool.map(lambda k: try_file(sources, request.seed, k, request.readers, request.keep), numbers)
        for done, found in enumerate(tried, 1):
            failures += len(found)
            if done % 100 == 0:
                print(f"{done} files, {failures} failures", flush=True)
            for sentence in found:
                print(sentence, flush=True)
    print(f"{failures} failures with {request.files} damaged results, {request.readers} reader(s) each")
    return min(failures, 100)


if __name__ == "__main__":
    sys.exit(main())
