"""How often the intervals of `mcsim velocity` hold the true velocity.

    python -m benchmarks.measured_velocity [--groups 1000]

Groups of twelve recorded runs of the velocity paper's sensors A1 and A2, as `mcsim run` writes them
with `outputs: {runs: true}`: calibration, gravity, tilt and time stamps err as the scenario says,
anew in every group.  Each goes from its raw output to the velocity; the errors against the truth
are held against ± u and ± 1.96 u of Eq. (30) for one run, of Eq. (31)-(33) for the mean of twelve,
and of Monte Carlo for both; `interval` are the 2.5 and 97.5 % of its draws of the mean.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim import Scenario
from mcsim.measured_velocity.correction_file import CorrectionInput, read_correction
from mcsim.measured_velocity.group import STAMPS_BELOW, group_of, run_of, time_base
from mcsim.measured_velocity.measurement import Measurement, measure
from mcsim.measured_velocity.propagation import Inputs
from mcsim.measured_velocity.run_log import RecordedRuns
from mcsim.measured_velocity.segments import Length, Rule, segments
from mcsim.systems.velocity.raw_log import raw_log
from mcsim.systems.velocity.scenario import VelocityScenario
from mcsim.systems.velocity.steps import rest_steps, step_count

Array = NDArray[np.float64]

SCENARIOS = Path(__file__).resolve().parent.parent / "scenarios" / "velocity"
NAMES = ("Eq. (30), run", "MC, run", "Eq. (31), mean", "MC, mean")
ORDERS = ("first", "second", "exact")
FACTOR = 1.959963984540054
#: Draws for each group.
DRAWS = 200


@dataclass(frozen=True)
class Bench:
    """A sensor, which of its scenario's values differ, and whether rest and motion are found."""

    sensor: str
    overrides: tuple[str, ...] = ()
    found: bool = False

    @property
    def file(self) -> Path:
        return SCENARIOS / f"{self.sensor}.yaml"

    @cached_property
    def correction(self) -> CorrectionInput:
        return read_correction(self.file)

    def model(self) -> VelocityScenario:
        model = Scenario.from_yaml(self.file, self.overrides).base
        assert isinstance(model, VelocityScenario)
        return model


_EXACT, _STAMPS = "tilt.order=exact", "sensor.time_errors=stamps"
BENCHES = {
    "A1, intervals err": Bench("a1", (_EXACT,)),
    "A1, time stamps err": Bench("a1", (_EXACT, _STAMPS)),
    "A1, rest, motion found": Bench("a1", (_EXACT,), found=True),
    "A2, intervals err": Bench("a2", (_EXACT,)),
}


def recorded(model: VelocityScenario, seed: int, group: int) -> list[RecordedRuns]:
    """The runs of a simulated group, each with its rest; its reference is the truth."""
    log = {title: np.asarray(values) for title, values in raw_log(model, seed, group).items()}
    raw = np.column_stack([log[f"a{axis} [g]"] for axis in "xyz"])
    found = []
    for number in range(1, model.runs + 1):
        rows = log["run"] == number
        time = log["time [s]"][rows]
        found.append(
            RecordedRuns(f"{number}", time - time[0], raw[rows], log["true velocity [m/s]"][rows])
        )
    return found


def measured(bench: Bench, model: VelocityScenario, seed: int, group: int) -> Measurement:
    """One group from raw output to velocity."""
    records = recorded(model, seed, group)
    rule = Rule()
    if not bench.found:
        rule = Rule(Length(rest_steps(model), True), Length(step_count(model), True))
    runs = [run_of(r, segments(r, rule, True)[0][0], r.name) for r in records]
    base = time_base([r.time for r in records])
    gravity = model.gravity
    stamps = base.correlation < STAMPS_BELOW
    inputs = Inputs(
        bench.correction,
        model.tilt.change,
        gravity.estimate,
        gravity.uncertainty,
        base.deviation,
        stamps,
        ORDERS.index(model.tilt.order),
    )
    return measure(inputs, group_of(runs, base), DRAWS, seed + group)


@dataclass(frozen=True)
class Coverage:
    """Shares of groups (instants, 4) whose truth lies within u and 1.96 u, by ``NAMES``; of the
    mean's interval (instants,); and root mean square of errors over that of u (instants, 4)."""

    one: Array
    two: Array
    interval: Array
    ratio: Array


def coverage(bench: Bench, groups: int, seed: int = 7) -> Coverage:
    """Measure a bench, in the middle of the motion and at its end."""
    model = bench.model()
    errors, deviations, inside = [], [], []
    for group in range(groups):
        found = measured(bench, model, seed, group)
        assert found.group.reference is not None
        own = found.runs - found.group.reference
        mean = found.mean - found.reference
        at = [len(found.group.time) // 3, -1]
        errors.append([[own[0, i], own[0, i], mean[i], mean[i]] for i in at])
        s, d = found.sums, found.drawn
        deviations.append([[s.single[0, i], d.single[0, i], s.mean[i], d.mean[i]] for i in at])
        truth = found.mean - mean
        inside.append([d.low[i] <= truth[i] <= d.high[i] for i in at])
    e, u = np.abs(errors), np.array(deviations)
    return Coverage(
        np.mean(e <= u, axis=0),
        np.mean(e <= FACTOR * u, axis=0),
        np.mean(inside, axis=0),
        np.sqrt(np.mean(e**2, axis=0) / np.mean(u**2, axis=0)),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--groups", type=int, default=1000)
    groups = parser.parse_args().groups
    half = 196.0 * np.sqrt(0.05 * 0.95 / groups)
    print(f"{groups} groups of 12 runs, per cent; 95 is known to ±{half:.1f}, 68.3 to "
          f"±{196.0 * np.sqrt(0.683 * 0.317 / groups):.1f}")  # fmt: skip
    print("for each: ± u (68.3 is right), ± 1.96 u (95), true errors over u (1)")
    print(f"{'':<36}{''.join(f'{name:<22}' for name in NAMES)}interval")
    for name, bench in BENCHES.items():
        print(lines(name, bench, groups), flush=True)


def lines(name: str, bench: Bench, groups: int) -> str:
    """Two lines: coverage after a third of the motion, and at its end."""
    found, told = coverage(bench, groups), []
    for i, instant in enumerate(("a third", "the end")):
        cells = "".join(
            f"{100 * found.one[i, k]:5.1f} {100 * found.two[i, k]:5.1f} "
            f"{found.ratio[i, k]:5.2f}     "
            for k in range(len(NAMES))
        )
        what = "" if i else name
        told.append(f"{what:<27}{instant:<8} {cells}{100 * found.interval[i]:5.1f}")
    return "\n".join(told)


if __name__ == "__main__":
    main()
