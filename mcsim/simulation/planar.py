"""The planar algorithm on arrays: of the planar case, and of a vehicle that leans."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from mcsim.errors import InputError
from mcsim.kernels import planar
from mcsim.scenario.initial import Initial
from mcsim.sensor_terms.channel import ACCELEROMETER, GYROSCOPE, Channel
from mcsim.sensors.measurement import Measurement
from mcsim.simulation.linear_errors import Weights
from mcsim.simulation.nets import net_normals
from mcsim.simulation.own import own_system
from mcsim.simulation.planar_linear import linear_weights
from mcsim.simulation.planar_samples import wrap
from mcsim.simulation.problem import Array, History
from mcsim.simulation.reckoning import Description, Reckoning
from mcsim.trajectory import Motion

#: Forward and left acceleration, yaw rate.
CHANNELS = (Channel(ACCELEROMETER, 0), Channel(ACCELEROMETER, 1), Channel(GYROSCOPE, 2))
RATES = (False, False, True)
SIGNAL_NAMES = ("forward acceleration", "left acceleration", "yaw rate")
#: Places of the initial errors among the kernel's constants: speed, direction, heading, course.
_SPEED, _DIRECTION, _HEADING, _COURSE = 3, 4, 5, 6
DESCRIPTION = Description(
    errors=("along", "across", "position", "heading", "course"),
    signals=SIGNAL_NAMES,
    lengths={"position": ("along", "across")},
    wrapping=("heading", "course"),
    initial={
        "initial speed error": (_SPEED,),
        "initial direction error": (_DIRECTION,),
        "initial heading error": (_HEADING,),
        "initial course error": (_COURSE,),
    },
)


@dataclass(frozen=True, kw_only=True)
class PlanarProblem(Reckoning):
    """The planar system; see ``mcsim.kernels.planar.Planar``.

    ``truth`` is the true motion at the samples 0 ... n.
    """

    truth: Motion
    rule: str
    previous_share: float

    @property
    def description(self) -> Description:
        return DESCRIPTION

    @property
    def _own(self) -> type[Any] | None:
        """The system of a user's own rule, or of cubics between samples, if it is one."""
        if self.rule == "cubic":
            from mcsim.kernels.interpolated import Interpolated

            return Interpolated
        return own_system("planar", self.rule, self.timed)

    @property
    def kernel(self) -> Any:
        return self._own or (planar.TimedPlanar if self.timed else planar.Planar)

    @cached_property
    def weights(self) -> Weights:
        if self._own is not None or self.timed:
            return super().weights
        return linear_weights(
            self.signals,
            self._start,
            self.interval,
            self.rule == "trapezoidal",
            self.previous_share,
        )

    def laid_out(self, samples: Array) -> Array:
        """All channels act on three errors, the turn alone on the heading."""
        if self._own is not None:
            return super().laid_out(samples)
        return np.column_stack([super().laid_out(samples[:3]), samples[3, :, 2]])

    @cached_property
    def _start(self) -> planar.Motion:
        return self._motion(0)

    def _motion(self, sample: int) -> planar.Motion:
        """The true motion at a sample."""
        t = self.truth
        rows = (t.along, t.across, t.speed, t.heading, t.course)
        return planar.Motion(*(float(row[sample]) for row in rows))

    def system(self, measurement: Measurement, disturbed: bool) -> Any:
        m, end = measurement, self._motion(-1)
        if "course" in self.missing:
            end = end._replace(course=math.nan)
        drawn = self.deviations(m, disturbed)[: len(planar.Deviations._fields)]
        deviations = planar.Deviations(*map(float, drawn))
        trapezoidal = self.rule == "trapezoidal"
        if self.rule == "cubic":
            _refuse_wide_turns(m.largest(self.signals, 2), self.interval)
        way = planar.way_of(
            trapezoidal,
            self.longest * m.largest(self.signals, 2),
            offsets=bool(np.any(m.offsets)),
        )
        return self.kernel(
            way=0 if self._own else way,
            interval=self.interval,
            previous_share=self.previous_share,
            # The trapezoidal rule uses the noise of sample 0, and so may others.
            draws=trapezoidal or bool(self._own) or any(deviations),
            deviations=deviations,
            start=self._start,
            end=end,
        )

    def history(self, key: int, first: int, count: int, net: int = 0) -> History:
        truth = self.truth
        rows = np.stack([truth.along, truth.across, truth.heading, np.unwrap(truth.course)])
        states, then = self.late(self.states(key, first, count, net), rows)
        along, across = states[0] - then[0], states[1] - then[1]
        course = np.arctan2(states[3], states[2]) - then[3]
        course[truth.speed < _still(truth)] = np.nan
        if self.missing:
            course[-1] = np.nan
        heading = wrap(states[4] - then[2])
        return History(
            time=self.times,
            tracks=states[:2],
            truth=np.stack([truth.along, truth.across]),
            errors=np.stack([along, across, np.hypot(along, across), heading, wrap(course)]),
        )

    def mixing_normals(self, key: int, first: int, count: int, net: int = 0) -> Array:
        """The normals (m, count) of the mixing coefficients of some realizations."""
        from mcsim.kernels.constants import constants_of

        drawn = self.drawn(self.measurement)
        if net:
            normals = net_normals(key, first, count, net, drawn)
        else:
            normals = np.empty((drawn, count), np.float32)
            constants_of(np.uint64(key), np.uint64(first), normals)
        entries = len(self.sensor_errors.mixing)
        fixed = planar.Planar.CONSTANTS
        return normals[fixed : fixed + entries].astype(float)


def initial_deviations(initial: Initial) -> Array:
    """Standard deviations (12,) of the initial errors, in the places of the kernel's constants."""
    deviations = np.zeros(planar.Planar.CONSTANTS)
    deviations[[_SPEED, _DIRECTION, _HEADING, _COURSE]] = (
        initial.speed_error,
        initial.direction_error,
        initial.heading_error,
        initial.course_error,
    )
    return deviations


def _refuse_wide_turns(largest: float, interval: float) -> None:
    """Cubics turn by a polynomial, whose range every sample of any use is within."""
    from mcsim.kernels.interpolated import LARGEST_TURN, OVERSHOOT

    if OVERSHOOT * largest > LARGEST_TURN:
        rate = OVERSHOOT * largest / LARGEST_TURN / interval
        raise InputError(
            "reconstruction.integration: cubic: the vehicle may turn by "
            f"{math.degrees(largest):.0f}° between two samples; raise `sensors.rate` above "
            f"{rate:.0f} Hz"
        )


def _still(truth: Motion) -> float:
    """Speed below which a vehicle counts as standing."""
    return 1e-9 * float(np.max(truth.speed))
