#!/usr/bin/python3
"""Studies the growth of aggregates: exponent z, onset and fractal dimension against K Q^2 and the definition of a
cluster.

Compares neutral and charged gases at the source's size (50016 grains) with many seeds. --conditions varies number,
density, law of restitution and accuracy of forces, one at a time.

    growth_study.py --device cuda --seconds 450 --processes 12    runs as time permits; a new call continues
    growth_study.py --report                                      the table of the stored results
    growth_study.py --conditions ...                              the same for the conditions

Results are in output/growth (--out), one JSON per run: results of `lichtenberg analyse` and `dense_cells` by frame.
Runs proceed seed by seed, so that all points have equally many when time is over; an interrupted run counts up to its
end. Running needs the standard library only.
"""

import argparse
import concurrent.futures
import json
import os
import signal
import subprocess
import threading
import time
from dataclasses import replace
from pathlib import Path

import gas_scenes

SOURCE = Path(__file__).resolve().parent.parent
# Name: the gas and its K Q^2, in the order of execution. The second list begins when all of the first are complete.
POINTS = [{"5e-4": (5e-4, 150), "2e-5": (2e-5, 300), "neutral": (0, 400)}, {"1e-4": (1e-4, 200), "5e-6": (5e-6, 300)}]
# Quantities kept per frame; distributions of cluster sizes, speeds and others are omitted.
KEPT = ("time", "temperature", "local_temperature", "sonine", "mean_charge_magnitude", "mean_square_charge",
        "charge_kurtosis", "charge_speed_correlation", "contacts", "clusters", "largest_cluster", "mean_aggregate",
        "mean_cluster", "percolating_clusters", "fractal_dimension", "fractal_dimension_error", "fractal_dimension_from",
        "fractal_dimension_to", "cluster_exponent", "cluster_local_temperature", "cluster_square_charge", "bjerrum",
        "bound_clusters", "mean_bound_aggregate", "mean_bound_cluster", "bound_fractal_dimension",
        "bound_fractal_dimension_error", "bound_bjerrum", "bound_cluster_square_charge",
        "bound_cluster_local_temperature", "largest_bound_cluster", "density_clusters", "density_cluster_size",
        "density_cluster_number", "density_cluster_exponent", "mach_number", "mach_number_of_flow",
        "mean_square_displacement", "contact_persistence", "density_structure", "speed_density", "charge_by_speed")


def gas_of(coupling, until, accuracy=1e-3, **changes):
    found = gas_scenes.exchanging(True, coupling / gas_scenes.RATE**2) if coupling else gas_scenes.neutral(True)
    if coupling:
        changes["effects"] = (gas_scenes.impacts(), gas_scenes.coulomb(coupling / gas_scenes.RATE**2, accuracy))
    return replace(found, until=until, **changes)


def condition(**changes):
    """Returns a gas of K Q^2 = 1e-4 and 16000 grains with the given changes. Contacts are stiffer for three units after
    the warm-up, because some grains would otherwise pass through each other."""
    return gas_of(1e-4, 100, **{"count": 16000, "stiff": 3, **changes})


# Name: the gas, in the order of execution.
CONDITIONS = {
    "base": condition(),
    "N = 4000": condition(count=4000),
    "N = 50016": condition(count=50016),
    "phi = .03": condition(filled=0.03),
    "phi = .137": condition(filled=0.137),
    "D = 8": condition(contact=gas_scenes.VISCOELASTIC.replace("27.7", "8")),
    "constant restitution .3": condition(contact="[effects.linear_contact]\nstiffness = 278.6\nrestitution = 0.3"),
    "forces to 1e-2": condition(accuracy=1e-2),
    "forces to 1e-4": condition(accuracy=1e-4),
}


def studied(conditions):
    """Returns lists of gases by name; each list begins when all earlier ones are complete."""
    if conditions:
        return [CONDITIONS]
    return [{name: gas_of(*point) for name, point in points.items()} for points in POINTS]


class Study:
    def __init__(self, request):
        self.request = request
        self.end = time.monotonic() + request.seconds
        self.running = set()
        self.lock = threading.Lock()
        self.analysing = concurrent.futures.ThreadPoolExecutor(max(1, request.processes // 2))

    def left(self):
        """Returns the seconds left for runs, reserving time for the analysis."""
        return self.end - min(0.12 * self.request.seconds, 60) - time.monotonic()

    def go(self):
        jobs = [(name, gas, seed) for gases in studied(self.request.conditions)
                for seed in range(1, 1 + self.request.seeds) for name, gas in gases.items()]
        jobs = [job for job in jobs if not self.path(job[0], job[2]).exists()]
        self.request.out.mkdir(parents=True, exist_ok=True)
        self.request.scratch.mkdir(parents=True, exist_ok=True)
        watch = threading.Timer(min(max(self.left(), 0), 1e6), self.interrupt)
        watch.start()
        with concurrent.futures.ThreadPoolExecutor(self.request.processes) as pool:
            analyses = [found for found in pool.map(self.run, jobs) if found]
        watch.cancel()
        for analysis in analyses:
            analysis.result()

    def path(self, name, seed):
        return self.request.out / f"{name.replace(' ', '_')}-{seed}.json"

    def interrupt(self):
        with self.lock:
            for process in self.running:
                process.send_signal(signal.SIGINT)

    def run(self, job):
        if self.left() < 5:
            return None
        name, gas, seed = job
        scene = self.request.scratch / self.path(name, seed).with_suffix(".toml").name
        scene.write_text(replace(gas, name=name).scene(seed))
        result = scene.with_suffix(".h5")
        begun = time.monotonic()
        command = [self.request.build / "lichtenberg", "run", scene, "--out", result, "--overwrite", "--quiet",
                   "--device", self.request.device]
        process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        with self.lock:
            self.running.add(process)
        message = process.communicate()[1].decode().strip()
        with self.lock:
            self.running.discard(process)
        seconds = time.monotonic() - begun
        print(f"{name} {seed}: status {process.returncode} after {seconds:.1f} s {message}", flush=True)
        if not result.exists():
            return None
        return self.analysing.submit(self.keep, name, seed, result, seconds)

    def keep(self, name, seed, result, seconds):
        begun = time.monotonic()
        found = json.loads(self.output(self.request.analyser / "lichtenberg", "analyse", result, "--json"))
        frames = {key: [frame.get(key) for frame in found["frames"]] for key in KEPT}
        kept = {"point": name, "seed": seed, "seconds": seconds, "warm": gas_scenes.WARM, "frames": frames,
                "notes": found.get("notes", {}), "growth": found.get("growth", {})}
        if (self.request.analyser / "dense_cells").exists():
            kept["definitions"] = json.loads(self.output(self.request.analyser / "dense_cells", result))
        kept["analysis_seconds"] = time.monotonic() - begun
        part = self.path(name, seed).with_suffix(".part")
        part.write_text(json.dumps(kept))
        part.rename(self.path(name, seed))
        result.unlink()

    @staticmethod
    def output(*command):
        return subprocess.run(["nice", "-n", "5", *map(str, command)], check=True, capture_output=True).stdout


def read_request():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=SOURCE / "build", help="folder of the program that runs")
    parser.add_argument("--analyser", type=Path, help="folder of the programs that analyse (default: the same)")
    parser.add_argument("--conditions", action="store_true", help="number, density, restitution, accuracy in place of K Q^2")
    parser.add_argument("--out", type=Path, help="folder of what is kept (default: output/growth, output/conditions)")
    parser.add_argument("--scratch", type=Path, help="folder of the runs' frames until they are analysed (default: --out)")
    parser.add_argument("--device", default="cpu", choices=("cpu", "cuda"))
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=1e9, help="of wall time, after which all is over")
    parser.add_argument("--processes", type=int, default=os.cpu_count(), help="runs at a time")
    parser.add_argument("--report", action="store_true", help="run nothing: the table of what is there")
    request = parser.parse_args()
    request.out = request.out or SOURCE / "paper-figures" / "output" / ("conditions" if request.conditions else "growth")
    request.scratch = request.scratch or request.out
    request.analyser = request.analyser or request.build
    return request


def main():
    request = read_request()
    if request.report:
        import growth_report  # needs numpy and matplotlib

        return growth_report.report_conditions(request.out) if request.conditions else growth_report.report(request.out)
    Study(request).go()


if __name__ == "__main__":
    main()
