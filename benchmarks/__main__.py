"""Speed and memory of the engine, as ratios against named baselines.

    python -m benchmarks [--quick] [--json FILE]

Everything runs in one process, variants interleaved, medians of several rounds; the
compile time is reported apart.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numba
import numpy as np

from benchmarks.baselines import naive_numba, plain_numpy
from mcsim import Scenario
from mcsim.engine import run_point
from mcsim.statistics import Collector, estimate
from mcsim.sweep import run_sweep
from mcsim.systems import problem_of
from mcsim.version import __version__

BASE = Path(__file__).resolve().parent.parent / "scenarios" / "paper" / "figure1.yaml"
ROLLING = BASE.parent.parent / "strapdown" / "rolling_vehicle.yaml"
#: A scenario of each case, for its kernel.
CASES = {
    "planar": BASE,
    "strapdown": ROLLING,
    "velocity": BASE.parent.parent / "velocity" / "a1.yaml",
}
ALL_ERRORS = {
    "sensors.accelerometer.miscalibration": "0.01 m/s^2",
    "sensors.gyroscope.miscalibration": "0.1 °/s",
    "initial.speed_error": "0.01 m/s",
    "initial.direction_error": "0.1 °",
}
#: The in-run terms, scale factor, quantisation and saturation together.
ALL_TERMS = {
    **ALL_ERRORS,
    "sensors.accelerometer.scale_factor_error": "0.5 %",
    "sensors.gyroscope.scale_factor_error": "0.5 %",
    "sensors.accelerometer.gauss_markov": "{deviation: 2 mg, correlation_time: 1 s}",
    "sensors.gyroscope.gauss_markov": "{deviation: 0.1 °/s, correlation_time: 1 s}",
    "sensors.accelerometer.acceleration_random_walk": "5 m/s/h^1.5",
    "sensors.gyroscope.rate_random_walk": "100 °/h^1.5",
    "sensors.accelerometer.resolution": "1 mg",
    "sensors.gyroscope.resolution": "0.02 °/s",
    "sensors.accelerometer.range": "4 m/s^2",
    "sensors.gyroscope.range": "100 °/s",
}
WITH_FLICKER = {
    **ALL_TERMS,
    "sensors.accelerometer.bias_instability": "1 mg",
    "sensors.gyroscope.bias_instability": "20 °/h",
}


def interleaved(variants: dict[str, Callable[[], int]], rounds: int) -> dict[str, float]:
    """Median nanoseconds per unit of work; a variant returns the units that it did."""
    times: dict[str, list[float]] = {name: [] for name in variants}
    for variant in variants.values():
        variant()
    for _ in range(rounds):
        for name, variant in variants.items():
            begun = time.perf_counter()
            units = variant()
            times[name].append(1e9 * (time.perf_counter() - begun) / units)
    return {name: statistics.median(values) for name, values in times.items()}


def scenario(**overrides: str | None) -> Scenario:
    given = (f"{path}={'null' if v is None else v}" for path, v in overrides.items())
    return Scenario.from_yaml(BASE, ["sweep=null", *given])


def kernel_speed(rounds: int) -> dict[str, object]:
    """One realization's sample, in the kernel and in the baselines, on one thread."""
    numba.set_num_threads(1)
    p = problem_of(scenario().base, Path())
    everything = problem_of(scenario(**ALL_ERRORS).base, Path())
    terms = problem_of(scenario(**ALL_TERMS).base, Path())
    flicker = problem_of(scenario(**WITH_FLICKER).base, Path())
    trapezoidal = replace(p, rule="trapezoidal")
    white = p.sensor_errors.white
    rng = np.random.default_rng(1)
    n, many, few = p.n_samples, 12_800, 1_000

    def work(count: int, run: Callable[[], object]) -> Callable[[], int]:
        def timed() -> int:
            run()
            return count * n

        return timed

    ns = interleaved(
        {
            "plain numpy": work(
                few, lambda: plain_numpy(p.signals, white, p._start, p.interval, few, rng)
            ),
            "naive numba": work(
                few, lambda: naive_numba(p.signals, white, p._start, p.interval, few)
            ),
            "kernel": work(many, lambda: p.simulate(1, 0, many)),
            "kernel, controls": work(many, lambda: p.simulate(1, 0, many, controls=True)),
            "kernel, all errors": work(many, lambda: everything.simulate(1, 0, many)),
            "kernel, all error terms": work(many, lambda: terms.simulate(1, 0, many)),
            "kernel, and flicker noise": work(many, lambda: flicker.simulate(1, 0, many)),
            "kernel, trapezoidal": work(many, lambda: trapezoidal.simulate(1, 0, many)),
        },
        rounds,
    )
    return {
        "ratio to plain numpy": {k: round(ns["plain numpy"] / v, 2) for k, v in ns.items()},
        "ratio to naive numba": {k: round(ns["naive numba"] / v, 2) for k, v in ns.items()},
    }


def strapdown_speed(rounds: int) -> dict[str, object]:
    """A sample of the strapdown kernel, as a multiple of the planar kernel's, on one thread."""
    planar = problem_of(scenario().base, Path())
    count = 12_800

    def work(problem, **options) -> Callable[[], int]:
        def timed() -> int:
            problem.simulate(1, 0, count, **options)
            return count * problem.n_samples

        return timed

    def rolling(**overrides: str):
        s = Scenario.from_yaml(ROLLING, {"sweep": None, **overrides})
        return problem_of(s.base, Path())

    p = rolling()
    variants = {"planar": work(planar), "planar, controls": work(planar, controls=True)}
    for rule in ("rectangular", "forward_euler", "trapezoidal", "two_sample"):
        variants[rule] = work(rolling(**{"reconstruction.integration": rule}))
    variants["rectangular, controls"] = work(p, controls=True)
    ns = interleaved(variants, rounds)
    return {name: round(value / ns["planar"], 2) for name, value in ns.items()}


def thread_scaling(rounds: int) -> dict[str, object]:
    """Two threads against one; runs first, since numba's own threads spin when they idle."""
    p = problem_of(scenario().base, Path())
    count = 51_200

    def one() -> int:
        p.simulate(1, 0, 2 * count)
        return 2 * count

    with ThreadPoolExecutor(2) as pool:

        def two() -> int:
            list(pool.map(lambda first: p.simulate(1, first, count), (0, count)))
            return 2 * count

        ns = interleaved({"one": one, "two": two}, rounds)
    return {"two threads to one": round(ns["one"] / ns["two"], 2)}


def statistics_cost(rounds: int) -> dict[str, object]:
    """Estimating all statistics of 1000 realizations, as a multiple of simulating them."""
    s = scenario()
    p, settings = problem_of(s.base, Path()), s.base.monte_carlo
    collected = Collector(1000, _reference(p))
    sample = p.simulate(1, 0, 1000, controls=True)
    collected.add(0, sample.errors, sample.controls)

    def once(run: Callable[[], object]) -> Callable[[], int]:
        def timed() -> int:
            for _ in range(20):
                run()
            return 20

        return timed

    ns = interleaved(
        {
            "simulate": once(lambda: p.simulate(1, 0, 1000)),
            "estimate": once(lambda: estimate(collected, 3.0, settings.resamples, 1)),
        },
        rounds,
    )
    return {
        "resamples": settings.resamples,
        "estimate to simulate": round(ns["estimate"] / ns["simulate"], 2),
    }


def _reference(problem):
    from mcsim.statistics import Reference

    linear = problem.linear
    return Reference(problem.method_errors(), linear.control_mean, linear.control_second_moment)


def scaling(rounds: int) -> dict[str, object]:
    """Time per realization and sample over the number of either, relative to the base."""
    p = problem_of(scenario().base, Path())
    long = problem_of(scenario(**{"trajectory.length": "500 m"}).base, Path())
    variants: dict[str, Callable[[], int]] = {}
    for count in (128, 1024, 8192, 65_536):
        repeat = max(1, 16_384 // count)

        def run(count: int = count, repeat: int = repeat) -> int:
            for _ in range(repeat):
                p.simulate(1, 0, count)
            return repeat * count * p.n_samples

        variants[f"{count} realizations"] = run

    def run_long() -> int:
        long.simulate(1, 0, 2048)
        return 2048 * long.n_samples

    variants[f"{long.n_samples} samples"] = run_long
    ns = interleaved(variants, rounds)
    base = ns["8192 realizations"]
    return {name: round(value / base, 2) for name, value in ns.items()}


def allan_speed(rounds: int) -> dict[str, object]:
    """Overlapping Allan deviation of 14 h at 100 Hz, against allantools at the same times."""
    import allantools

    from mcsim.characterisation import allan_curve

    samples = np.random.default_rng(1).standard_normal(14 * 3600 * 100)
    tau = allan_curve(samples, 100.0).tau

    def theirs() -> int:
        allantools.oadev(samples, rate=100.0, data_type="freq", taus=tau)
        return len(samples)

    def ours() -> int:
        allan_curve(samples, 100.0)
        return len(samples)

    ns = interleaved({"allantools": theirs, "mcsim": ours}, max(1, rounds // 3))
    return {"time to allantools'": round(ns["mcsim"] / ns["allantools"], 3)}


def sweep_overhead(rounds: int) -> dict[str, object]:
    """A point of a sweep (1000 realizations, statistics) relative to its kernel time."""
    whole = Scenario.from_yaml(BASE)
    p = problem_of(whole.points[0].model, whole.folder)

    def kernel() -> int:
        for _ in range(whole.n_points):
            p.simulate(1, 0, 1000)
        return whole.n_points

    def sweep(jobs: int) -> Callable[[], int]:
        def timed() -> int:
            run_sweep(whole, jobs)
            return whole.n_points

        return timed

    ns = interleaved(
        {"kernel": kernel, "sweep, 1 job": sweep(1), "sweep, 2 jobs": sweep(2)}, rounds
    )
    return {name: round(value / ns["kernel"], 2) for name, value in ns.items()}


def precision(rounds: int) -> dict[str, object]:
    """Realizations until all RMS intervals are within 0.1 %, by estimator."""
    del rounds
    table = {}
    for name, overrides in (
        ("base parameters", {}),
        ("all errors", ALL_ERRORS),
        ("gyroscope miscalibration 3 °/s", {"sensors.gyroscope.miscalibration": "3 °/s"}),
    ):
        row = {}
        for estimator in ("plain", "control_variate"):
            s = scenario(
                **{
                    **overrides,
                    "monte_carlo.realizations": None,
                    "monte_carlo.precision": "0.1 %",
                    "monte_carlo.max_realizations": 20_000_000,
                    "monte_carlo.estimator": estimator,
                }
            )
            result = run_point(problem_of(s.base, Path()), s.base.monte_carlo, 1, 2)
            row[estimator] = result.realizations
        row["ratio"] = round(row["plain"] / row["control_variate"], 1)
        table[name] = row
    return table


def memory() -> dict[str, object]:
    """Peak memory of 10^7 realizations beyond that of 10^5 (MB), each in a fresh process.

    Linux only: ``ru_maxrss`` of a fresh process begins with what its parent has used.
    """
    code = (
        "import sys; from pathlib import Path; from benchmarks.__main__ import *;"
        "s = scenario(**{'monte_carlo.realizations': int(sys.argv[1])});"
        "run_point(problem_of(s.base, Path()), s.base.monte_carlo, 1, 2);"
        "print(Path('/proc/self/status').read_text().split('VmHWM:')[1].split()[0])"
    )
    peaks = [
        int(
            subprocess.run(
                [sys.executable, "-c", code, str(count)],
                capture_output=True,
                text=True,
                check=True,
            ).stdout
        )
        / 1024
        for count in (100_000, 10_000_000)
    ]
    return {"10^5 realizations": round(peaks[0]), "beyond it for 10^7": round(peaks[1] - peaks[0])}


def compile_time() -> dict[str, object]:
    """Seconds to compile each case's kernel from nothing, and to find it in the cache."""
    found: dict[str, object] = {}
    for case, file in CASES.items():
        with tempfile.TemporaryDirectory() as folder:
            cold, warm = (_seconds_to_run(file, folder) for _ in range(2))
        found[case] = {"cold (s)": round(cold, 1), "from the cache (s)": round(warm, 2)}
    return found


def _seconds_to_run(file: Path, folder: str) -> float:
    """Seconds that the first realizations take in a fresh process, with its cache in ``folder``."""
    code = (
        "import sys, time; from mcsim import Scenario; from mcsim.systems import problem_of;"
        "s = Scenario.from_yaml(sys.argv[1], {'sweep': None});"
        "p = problem_of(s.base, s.folder); t = time.perf_counter();"
        "p.simulate(1, 0, 10); print(time.perf_counter() - t)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(file)],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "NUMBA_CACHE_DIR": folder},
    )
    return float(done.stdout)


def machine() -> dict[str, object]:
    """What the figures were measured on."""
    cpu = platform.processor()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [x for x in info.read_text().splitlines() if x.startswith("model name")]
        cpu = names[0].split(":")[1].strip() if names else cpu
    import llvmlite.binding as llvm

    features = llvm.get_host_cpu_features()
    return {
        "cpu": cpu,
        "target": numba.config.CPU_NAME or llvm.get_host_cpu_name(),
        "avx512": bool(features.get("avx512f")) and numba.config.CPU_NAME is None,
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
        "mcsim": __version__,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer rounds, no memory or compile")
    parser.add_argument("--json", type=Path, help="also write the figures to this file")
    options = parser.parse_args()
    rounds = 3 if options.quick else 15
    figures: dict[str, object] = {"machine": machine()}
    parts: dict[str, Callable[[], object]] = {
        "threads": lambda: thread_scaling(rounds),
        "kernel": lambda: kernel_speed(rounds),
        "strapdown (time to the planar kernel's)": lambda: strapdown_speed(rounds),
        "statistics": lambda: statistics_cost(rounds),
        "scaling (time per realization and sample)": lambda: scaling(rounds),
        "sweep (time per point)": lambda: sweep_overhead(rounds),
        "Allan deviation, 14 h at 100 Hz": lambda: allan_speed(rounds),
    }
    if not options.quick:
        parts |= {
            "realizations for 0.1 %": lambda: precision(rounds),
            "peak memory (MB)": memory,
            "compile time": compile_time,
        }
    for name, part in parts.items():
        figures[name] = part()
        print(f"\n{name}")
        _print(figures[name])
    if options.json:
        options.json.write_text(json.dumps(figures, indent=2, ensure_ascii=False) + "\n")


def _print(value: object, indent: int = 2) -> None:
    assert isinstance(value, dict)
    for key, item in value.items():
        if isinstance(item, dict):
            print(" " * indent + str(key))
            _print(item, indent + 2)
        else:
            print(" " * indent + f"{key:<{36 - indent}} {item}")


if __name__ == "__main__":
    main()
