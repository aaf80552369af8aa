"""The velocity case linearised around its undisturbed run, correlations included.

What a group draws once acts on every step in the same way: its effect on the velocity is
the sum of its effects on the steps, not the root of the sum of squares.  Calibration acts
on the acceleration and on the initial tilt, which cancel in part.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.velocity_system import Inputs
from mcsim.sensors.error_model import ChannelErrors
from mcsim.simulation.problem import LinearModel
from mcsim.simulation.running import LinearWeights

if TYPE_CHECKING:
    from mcsim.systems.velocity.problem import VelocityProblem

Array = NDArray[np.float64]

_FIELDS = Inputs._fields


def _columns(first: str, last: str) -> slice:
    """Columns of a group's inputs, by their names."""
    return slice(_FIELDS.index(first), _FIELDS.index(last) + 1)


#: Columns of a group's inputs: rows of the calibration matrix, zero biases, means at rest.
LX, LZ = _columns("lxx", "lxz"), _columns("lzx", "lzz")
BIAS, REST = _columns("bx", "bz"), _columns("rest_x", "rest_z")
_TILT, _GRAVITY = _FIELDS.index("tilt"), _FIELDS.index("gravity")
#: What a group draws once, by source: columns of the group's weights.
GROUP_SOURCES = {
    "calibration matrix": _columns("lxx", "lzz"),
    "zero bias": BIAS,
    "noise at rest": REST,
    "tilt change": _columns("tilt", "tilt"),
    "gravity": _columns("gravity", "gravity"),
}
#: What every step draws, by source.
NOISE, TIME_BASE = "noise while moving", "time base"
_COMPLEX_STEP = 1e-30


@dataclass(frozen=True)
class VelocityWeights:
    """Velocity errors (m/s) per unit normal.

    ``steps`` (n, 4) of each step's noise in x, y, z and of its interval; ``group`` (k, 14) of
    what a group draws once, at each instant; ``counts`` (k,) steps until each instant.
    With ``stamps`` an interval's error is the difference of two normals, those of its ends.
    ``slopes`` (k, 14) are per unit of what a group draws once, ``per_sample`` (3,) per unit of an
    axis' error at one step; ``offsets`` are the deviations (3,) of the axes' constant offsets,
    by source.
    """

    steps: Array
    group: Array
    counts: NDArray[np.int64]
    stamps: bool
    slopes: Array
    per_sample: Array
    offsets: Mapping[str, Array]

    def group_variances(self) -> Mapping[str, Array]:
        """Variances (k,) of the velocity from what a group draws once, by source."""
        drawn = {
            source: np.sum(self.group[:, columns] ** 2, axis=1)
            for source, columns in GROUP_SOURCES.items()
        }
        # An offset acts as an error of the zero bias of the other sign, at rest as well.
        return drawn | {
            source: self.slopes[:, BIAS] ** 2 @ deviation**2
            for source, deviation in self.offsets.items()
        }

    def group_with_offsets(self) -> Array:
        """``group`` with the offsets among the errors of the zero bias."""
        if not self.offsets:
            return self.group
        squares = np.sum([d**2 for d in self.offsets.values()], axis=0)
        group = self.group.copy()
        group[:, BIAS] = np.hypot(group[:, BIAS], self.slopes[:, BIAS] * np.sqrt(squares))
        group[:, BIAS] *= np.sign(self.slopes[:, BIAS])
        return group

    def step_variances(self) -> Mapping[str, Array]:
        """Variances (k,) of the velocity of one run from what every step draws, by source."""
        noise = np.cumsum(np.sum(self.steps[:, :3] ** 2, axis=1))
        time = self.steps[:, 3]
        if self.stamps:
            # A stamp ends one interval and begins the next; the first and the last do one only.
            inner = np.append(0.0, np.cumsum(np.diff(time) ** 2))
            times = time[0] ** 2 + inner + time**2
        else:
            times = np.cumsum(time**2)
        return {NOISE: noise[self.counts - 1], TIME_BASE: times[self.counts - 1]}

    def kernel_weights(self) -> LinearWeights:
        """The weights as the kernel takes them, where only white noise disturbs the samples."""
        before = np.zeros((1, self.steps.shape[1]))
        return LinearWeights(np.concatenate([before, self.steps]), self.group_with_offsets())


def accelerations(raw: Array, inputs: NDArray[Any], order: int) -> NDArray[Any]:
    """Horizontal acceleration (n,) in m/s^2 from raw output (n, 3), Eq. (4), (5), (15)-(20).

    ``inputs`` (14,) as the kernel has them, real or complex.
    """
    lx, lz, bias, g = inputs[LX], inputs[LZ], inputs[BIAS], inputs[_GRAVITY]
    p, q = turn(_tilt(inputs), order)
    return g * ((raw - bias) @ (p * lx - q * lz))


def calibration_pushes(raw: Array, inputs: Array, order: int) -> Array:
    """Derivatives (n, 9) of the acceleration with respect to l and B, the tilt being known."""
    lx, lz, bias, g = inputs[LX], inputs[LZ], inputs[BIAS], inputs[_GRAVITY]
    p, q = (float(factor) for factor in turn(_tilt(inputs), order))
    sensed = raw - bias
    by_bias = np.broadcast_to(q * lz - p * lx, sensed.shape)
    return np.asarray(g * np.concatenate([p * sensed, -q * sensed, by_bias], axis=1), float)


def _tilt(inputs: NDArray[Any]) -> Any:
    """The angle, Eq. (19) and (20)."""
    lx, lz, at_rest = inputs[LX], inputs[LZ], inputs[REST] - inputs[BIAS]
    return np.arctan((lx @ at_rest) / (lz @ at_rest)) + inputs[_TILT]


def turn(theta: Any, order: int) -> tuple[Any, Any]:
    """Factors of acx and of -acz in the horizontal acceleration."""
    if order == 0:
        return 1.0, theta
    if order == 1:
        return 1.0 / (1.0 + theta * theta), theta / (1.0 + theta * theta)
    return np.cos(theta), np.sin(theta)


def velocity_weights(p: VelocityProblem) -> VelocityWeights:
    """Weights of all disturbances, in closed form; those of the steps themselves agree."""
    raw, inputs, counts, order = p.raw, p.inputs, p.steps, p.tilt_order
    pushes = np.empty((len(counts), len(inputs)))
    for k in range(len(inputs)):
        moved = inputs.astype(complex)
        moved[k] += _COMPLEX_STEP * 1j
        slopes = np.imag(accelerations(raw, moved, order)) / _COMPLEX_STEP
        pushes[:, k] = np.cumsum(slopes)[counts - 1]
    per_sample = p.interval * accelerations(inputs[BIAS] + np.eye(3), inputs, order)
    times = _of_stamp(p.time_error, p.stamps) * accelerations(raw, inputs, order)
    return VelocityWeights(
        steps=np.column_stack([np.broadcast_to(per_sample * p.white, raw.shape), times]),
        group=p.uncertainties * p.interval * pushes,
        counts=counts,
        stamps=p.stamps,
        slopes=p.interval * pushes,
        per_sample=per_sample,
        offsets=_offsets(p.sensor_errors),
    )


def _offsets(errors: ChannelErrors) -> Mapping[str, Array]:
    """Deviations (3,) of the axes' constant offsets, by source."""
    return {
        f"accelerometer {source}": deviations
        for source, deviations in errors.constants.items()
        if np.any(deviations)
    }


def _of_stamp(time_error: float, stamps: bool) -> float:
    """Deviation of one stamp whose differences have the deviation ``time_error``."""
    return time_error / math.sqrt(2.0) if stamps else time_error


def velocity_linear_model(weights: VelocityWeights, runs: int) -> LinearModel:
    """Moments of the linear errors: velocity, mean velocity, scatter of the runs per instant.

    The sample standard deviation of normal runs has the mean ``c4 sigma`` and the mean
    square ``sigma^2``.
    """
    group, steps = weights.group_variances(), weights.step_variances()
    own = np.sum(list(steps.values()), axis=0)
    common = np.sum(list(group.values()), axis=0)
    zero = np.zeros_like(own)
    variances = {name: _rows(v, v, zero) for name, v in group.items()} | {
        name: _rows(v, v / runs, v) for name, v in steps.items()
    }
    mean = np.zeros(3 * len(own))
    mean[2::3] = _c4(runs) * np.sqrt(own)
    second_moment = _rows(common + own, common + own / runs, own)
    controlled = np.tile([1.0, 1.0, 0.0], len(own))
    return LinearModel(
        mean=mean,
        second_moment=second_moment,
        control_mean=controlled * mean,
        control_second_moment=controlled * second_moment,
        variances=variances,
        quantiles={
            3 * i + 2: _scatter_quantile(math.sqrt(variance), runs)
            for i, variance in enumerate(own)
            if runs > 1
        },
    )


def _rows(velocity: Array, mean_velocity: Array, scatter: Array) -> Array:
    return np.stack([velocity, mean_velocity, scatter], axis=1).ravel()


def _c4(runs: int) -> float:
    """Mean of the sample standard deviation of ``runs`` unit normals."""
    if runs < 2:
        return 0.0
    return math.sqrt(2.0 / (runs - 1)) * math.exp(
        math.lgamma(runs / 2.0) - math.lgamma((runs - 1) / 2.0)
    )


def _scatter_quantile(sigma: float, runs: int) -> Callable[[float], float]:
    def quantile(p: float) -> float:
        from scipy.special import chdtri

        return sigma * math.sqrt(float(chdtri(runs - 1, 1.0 - p)) / (runs - 1))

    return quantile
