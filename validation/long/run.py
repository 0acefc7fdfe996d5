"""Runs the long checks of validation/long/checks.toml in slices, and keeps one JSON file per slice.

    validation/long.sh [--list] [--hours 10] [--again] [--record] [NAME ...]

A slice that passed for this commit is not repeated, so that a stopped run continues. No slice begins that might end
after the given hours. Prints a row per slice. Exits with 1 if a slice failed, with 2 for wrong input, and with 3 if
slices are left for a later call.
"""
import argparse
import fcntl
import json
import os
import platform
import re
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
PAGE = "long-validation"
KEYS = {"name": str, "shows": str, "command": str, "minutes": int, "slices": (int, list), "preset": str, "targets": list}
DEFAULTS = {"slices": 1, "preset": "release", "targets": []}
LONGEST = 60  # minutes of a slice


def refuse(message):
    print(f"long.sh: {message}", file=sys.stderr)
    sys.exit(2)


def checks_of(path):
    """Returns the checks of a file as a list of objects with all keys; slices are texts. Ends the program if one is wrong."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError) as error:
        refuse(f"{path}: {error}")
    checks = []
    for entry in table.get("check", []):
        where = f"{path}: check {entry.get('name', '?')!r}"
        for key in entry:
            if key not in KEYS:
                refuse(f"{where}: the key {key!r} is unknown; allowed are {', '.join(KEYS)}")
        check = DEFAULTS | entry
        for key, kind in KEYS.items():
            if not isinstance(check.get(key), kind):
                refuse(f"{where}: the value of {key!r} is missing or of a wrong type")
        if not re.fullmatch(r"[a-z0-9-]+", check["name"]) or check["name"] in [other["name"] for other in checks]:
            refuse(f"{where}: the name must be unique and consist of small letters, digits and '-'")
        if isinstance(check["slices"], int):
            check["slices"] = range(1, check["slices"] + 1)
        check["slices"] = list(map(str, check["slices"]))
        if not 1 <= check["minutes"] <= LONGEST or not check["slices"]:
            refuse(f"{where}: 'minutes' must be from 1 to {LONGEST}, and 'slices' at least 1")
        checks.append(check)
    return checks


def commit():
    """Returns the commit of the source tree, with "-changed" if tracked files differ from it; empty outside of a git checkout."""
    done = subprocess.run(["git", "-C", HOME, "describe", "--always", "--abbrev=8", "--exclude=*", "--dirty=-changed"],
                          capture_output=True, text=True, check=False)
    return done.stdout.strip()


def machine():
    """Returns the processor and the number of its cores."""
    names = re.findall(r"^model name\s*: (.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.MULTILINE)
    return f"{names[0] if names else platform.machine()}, {len(os.sched_getaffinity(0))} cores"


class Store:
    """Results of slices, one JSON file each, in a folder that one run uses at a time."""

    def __init__(self, folder, at):
        self.folder, self.at = folder, at
        folder.mkdir(parents=True, exist_ok=True)
        self.lock = (folder / ".lock").open("w", encoding="utf-8")
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            refuse(f"another run uses {folder}: wait for its end")

    def path(self, check, part, kind="json"):
        return self.folder / f"{check['name']}-{part}.{kind}"

    def read(self, check, part):
        """Returns the result of a slice for this commit, or None."""
        try:
            result = json.loads(self.path(check, part).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return result if result.get("commit") == self.at else None

    def write(self, check, part, result):
        """Replaces the file of a slice as a whole, so that a stopped run leaves the old or the new one."""
        path = self.path(check, part)
        path.with_suffix(".part").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        path.with_suffix(".part").replace(path)


def call(words, log, limit, environment=None):
    """Runs a command with its output in `log`; returns its exit status, or None after `limit` seconds."""
    child = subprocess.Popen(words, stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, cwd=HOME,
                             env=environment, start_new_session=True)
    try:
        return child.wait(limit)
    except subprocess.TimeoutExpired:
        return None
    finally:  # also ends processes that the command left behind, or that a signal to this program interrupts
        try:
            os.killpg(child.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        child.wait()


def build(check, log):
    """Builds the targets of a check. Returns an empty text, or the reason of a failure."""
    folder = HOME / ("build" if check["preset"] == "release" else f"build-{check['preset']}")
    if not (folder / "build.ninja").exists() and call(["cmake", "--preset", check["preset"]], log, LONGEST * 60) != 0:
        return f"the preset {check['preset']} was not configured"
    targets = check["targets"] or (["lichtenberg"] if check["preset"] == "release" else [])
    if call(["ninja", "-C", str(folder), *targets], log, LONGEST * 60) != 0:
        return f"ninja failed in {folder.name}"
    return ""


def run_slice(check, part, store):
    """Builds and runs one slice; returns its result."""
    figures = store.path(check, part, "figures")
    figures.unlink(missing_ok=True)
    command = check["command"].replace("{slices}", str(len(check["slices"]))).replace("{slice}", part)
    result = {"check": check["name"], "slice": part, "command": command, "commit": store.at, "machine": machine(),
              "date": time.strftime("%Y-%m-%d")}
    with store.path(check, part, "log").open("w", encoding="utf-8") as log:
        start = time.monotonic()
        failure = build(check, log)
        result["build seconds"] = round(time.monotonic() - start, 1)
        start = time.monotonic()
        if not failure:
            status = call(["bash", "-c", command], log, 60 * check["minutes"],
                          os.environ | {"LICHTENBERG_FIGURES": str(figures)})
            failure = {0: "", None: f"it took longer than {check['minutes']} minutes"}.get(status, f"exit status {status}")
    result |= {"seconds": round(time.monotonic() - start, 1), "passed": not failure, "failure": failure}
    if figures.exists():
        try:
            result["figures"] = json.loads(figures.read_text(encoding="utf-8"))
        except ValueError as error:
            result |= {"passed": False, "failure": f"{figures.name}: {error}"}
        figures.unlink()
    return result


def state_of(result):
    return "-" if result is None else "passed" if result["passed"] else f"failed: {result['failure']}"


def record(checks, store, data):
    """Writes the last results to the measurements, and the page of documentation."""
    rows, measurements = [], []
    for check in checks:
        found = [result for part in check["slices"] if (result := store.read(check, part))]
        rows.append({"check": check["name"], "shows": check["shows"], "slices": len(check["slices"]), "run": len(found),
                     "passed": sum(result["passed"] for result in found), "time (s)": round(sum(r["seconds"] for r in found)),
                     "failures": "; ".join(dict.fromkeys(r["failure"] for r in found if not r["passed"])) or "-"})
        tables = [row for result in found if "figures" in result
                  for row in (result["figures"] if isinstance(result["figures"], list) else [{"slice": result["slice"]} | result["figures"]])]
        if tables:
            measurements.append({"page": PAGE, "measures": f"figures of {check['name']}", "unit": "1", "command": check["command"],
                                 "commit": store.at, "machine": found[0]["machine"], "date": found[-1]["date"], "rows": tables})
    whole = {"page": PAGE, "measures": "long checks, slices that passed, and time", "unit": "1",
             "command": "validation/long.sh --record", "commit": store.at, "machine": machine(),
             "date": time.strftime("%Y-%m-%d"), "rows": rows}
    data.write_text(json.dumps([whole, *measurements], indent=1) + "\n", encoding="utf-8")
    subprocess.run([sys.executable, HOME / "docs/render_measurements.py"], check=True)


def arguments():
    parser = argparse.ArgumentParser(prog="long.sh", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", metavar="NAME", nargs="*", help="checks to run; default all")
    parser.add_argument("--list", action="store_true", help="list the checks and the state of their slices only")
    parser.add_argument("--hours", type=float, default=10, help="time for this call; default 10")
    parser.add_argument("--again", action="store_true", help="repeat slices that passed for this commit, too")
    parser.add_argument("--record", action="store_true",
                        help=f"then write docs/measurements/long.json and docs/{PAGE}.md from all results of this commit")
    parser.add_argument("--checks", type=Path, default=HOME / "validation/long/checks.toml", help="file of checks")
    parser.add_argument("--results", type=Path, default=HOME / "build/long", help="folder of the results")
    options = parser.parse_args()
    if not options.hours > 0:
        refuse("--hours must be above 0")
    return options


def main():
    """Runs the chosen slices that have not passed yet."""
    options = arguments()
    checks = checks_of(options.checks)
    known = [check["name"] for check in checks]
    for name in options.names:
        if name not in known:
            refuse(f"there is no check {name!r}; known are {', '.join(known)}")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    chosen = [check for check in checks if not options.names or check["name"] in options.names]
    if not (at := commit()):
        refuse(f"{HOME} is no git checkout, so that results would have no commit")
    store = Store(options.results, at)
    left = failed = 0
    end = time.monotonic() + 3600 * options.hours
    print(f"{'check':<24}{'slice':>24}{'minutes':>9}{'s':>8}  state", flush=True)
    for check in chosen:
        for part in check["slices"]:
            result = store.read(check, part)
            repeat = result is None or not result["passed"] or options.again or store.at.endswith("-changed")
            if repeat and not options.list:
                if time.monotonic() + 60 * check["minutes"] > end:
                    left += 1
                    result = None
                else:
                    result = run_slice(check, part, store)
                    store.write(check, part, result)
                    failed += not result["passed"]
            print(f"{check['name']:<24}{part:>24}{check['minutes']:>9}"
                  f"{result['seconds'] if result else '-':>8}  {state_of(result)}", flush=True)
            if result and not result["passed"] and not options.list:
                print(f"    log: {store.path(check, part, 'log')}", flush=True)
    if options.record:
        record(checks, store, HOME / "docs/measurements/long.json")
    return 1 if failed else 3 if left else 0


if __name__ == "__main__":
    sys.exit(main())
