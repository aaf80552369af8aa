"""The planar case: a scenario's point as arrays for the planar kernel."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mcsim.cases.problem import Array, History
from mcsim.errors import InputError
from mcsim.scenario import ERROR_NAMES, PlanarScenario
from mcsim.sensors.error_model import channel_errors
from mcsim.sensors.sampling import oversampling, sample
from mcsim.trajectory import Drive, Motion, drive_of

_COURSE = ERROR_NAMES.index("course")
#: Samples per track beyond which the arrays of the truth become absurd.
_MOST_DENSE_SAMPLES = 20_000_000
#: Standard deviations that bound the yaw rate of practically all realizations.
_WIDE = 7.0


@dataclass(frozen=True)
class PlanarProblem:
    """Arrays and numbers of the planar kernel; see ``mcsim.kernels.planar.simulate``.

    ``truth`` is the true motion at the samples 0 ... n.
    """

    signals: Array
    white: Array
    deviations: Array
    truth: Motion
    interval: float
    trapezoidal: bool
    previous_share: float
    missing: Mapping[str, str]
    error_names: tuple[str, ...] = ERROR_NAMES

    @classmethod
    def from_model(cls, model: PlanarScenario, folder: Path) -> PlanarProblem:
        """Truth, sampling and error model of one point.

        Raises
        ------
        InputError
            No such track, or one that is shorter than a sample or absurdly long.
        """
        drive = drive_of(model.trajectory, folder)
        sensors = model.sensors
        count = sample_count(drive, sensors.rate)
        times = -drive.lead + np.arange(count + 1) / sensors.rate
        errors = channel_errors(sensors)
        initial = model.initial
        return cls(
            signals=sample(drive.signals, -drive.lead, sensors.rate, count, sensors.sampling),
            white=errors.white,
            deviations=np.array(
                [
                    *errors.miscalibration,
                    initial.speed_error,
                    initial.direction_error,
                    initial.heading_error,
                    initial.course_error,
                ]
            ),
            truth=drive.motion(times),
            interval=1.0 / sensors.rate,
            trapezoidal=model.reconstruction.integration == "trapezoidal",
            previous_share=0.0 if sensors.sampling == "average" else 0.5,
            missing=_missing(drive),
        )

    @property
    def n_samples(self) -> int:
        return self.signals.shape[1] - 1

    def simulate(self, key: int, first: int, count: int) -> Array:
        errors = np.empty((len(ERROR_NAMES), count))
        self._run(key, first, self.white, self.deviations, errors, np.empty((0, 0, 0)))
        return errors

    def method_errors(self) -> Array:
        errors = np.empty((len(ERROR_NAMES), 1))
        self._run(0, 0, np.zeros(3), np.zeros(7), errors, np.empty((0, 0, 0)))
        return errors[:, 0]

    def history(self, key: int, first: int, count: int) -> History:
        from mcsim.kernels.planar import HISTORY_ROWS

        errors = np.empty((len(ERROR_NAMES), count))
        states = np.empty((HISTORY_ROWS, self.n_samples + 1, count))
        self._run(key, first, self.white, self.deviations, errors, states)
        truth = self.truth
        along = states[0] - truth.along[:, None]
        across = states[1] - truth.across[:, None]
        course = np.arctan2(states[3], states[2]) - truth.course[:, None]
        course[truth.speed < _still(truth)] = np.nan
        if self.missing:
            course[-1] = np.nan
        return History(
            time=np.arange(self.n_samples + 1, dtype=float) * self.interval,
            tracks=states[:2],
            truth=np.stack([truth.along, truth.across]),
            errors=np.stack(
                [
                    along,
                    across,
                    np.hypot(along, across),
                    wrap(states[4] - truth.heading[:, None]),
                    wrap(course),
                ]
            ),
        )

    def _run(
        self, key: int, first: int, white: Array, deviations: Array, errors: Array, history: Array
    ) -> None:
        from mcsim.kernels.planar import LARGEST_TURN, simulate

        truth = self.truth
        course_end = math.nan if "course" in self.missing else float(truth.course[-1])
        widest = np.max(np.abs(self.signals[2])) + _WIDE * math.hypot(white[2], deviations[2])
        simulate(
            np.uint64(key),
            np.uint64(first),
            errors.shape[1],
            self.signals,
            white,
            deviations,
            np.array(
                [
                    truth.along[0],
                    truth.across[0],
                    truth.speed[0],
                    truth.heading[0],
                    truth.course[0],
                ]
            ),
            np.array([truth.along[-1], truth.across[-1], truth.heading[-1], course_end]),
            self.interval,
            self.trapezoidal,
            self.previous_share,
            bool(widest * self.interval > LARGEST_TURN),
            errors,
            history,
        )


def wrap(angle: Array) -> Array:
    """Angles in (-pi, pi]."""
    return angle - 2.0 * np.pi * np.ceil((angle - np.pi) / (2.0 * np.pi))


def _still(truth: Motion) -> float:
    """Speed below which a vehicle counts as standing."""
    return 1e-9 * float(np.max(truth.speed))


def _missing(drive: Drive) -> Mapping[str, str]:
    if drive.manoeuvre.stops:
        return {"course": "the vehicle stands still at the end: its course is undefined"}
    return {}


def sample_count(drive: Drive, rate: float) -> int:
    """Number of the last sample that the drive holds."""
    count = math.floor(drive.duration * rate * (1.0 + 1e-12) + 1e-9)
    if count < 1:
        raise InputError(
            f"sensors.rate: the drive lasts {drive.duration:.4g} s, less than one sampling "
            f"interval; use a rate above {1.0 / drive.duration:.4g} Hz"
        )
    if count * oversampling(rate) > _MOST_DENSE_SAMPLES:
        raise InputError(
            f"trajectory: the drive lasts {drive.duration:.4g} s, {count:,} samples at "
            f"{rate:g} Hz; shorten it or lower the rate"
        )
    return count
