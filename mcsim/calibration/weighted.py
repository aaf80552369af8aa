"""Six positions, each weighted by its own uncertainty.

A position that was held less still, or for a shorter time, counts for less: the variance of its
mean is that of its own samples, and what all positions scatter beyond them is added.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.calibration.scatter import FEWEST_OF_ITS_OWN, SampleScatter
from mcsim.calibration.six_positions import SixPositionFit, SixPositions, calibrate, inverse
from mcsim.calibration.uncertainty import DESIGN, Part, cut_at_zero, of_parts
from mcsim.errors import InputError

Array = NDArray[np.float64]

#: Positions (6, 3) in which an axis is level.
_LEVEL = np.abs(DESIGN[:, :3]) < 0.5
#: Rounds in which weights and the variance of positions settle.
_ROUNDS = 8


def calibrate_weighted(test: SixPositions) -> SixPositionFit:
    """Weighted least squares with uncertainties, Eq. (2) and (3).

    Weights are 1 / (own variance + that of positions); the latter is what the residuals of the
    fit without weights have beyond their own noise.

    Raises
    ------
    InputError
        Positions with too few samples to tell their noise, or repetitions whose parameters change.
    """
    plain = calibrate(test)
    if test.own is None or test.scatter is None:
        raise InputError(
            f"--weighted: each position needs {FEWEST_OF_ITS_OWN} samples or more, which tell its "
            "own uncertainty"
        )
    if plain.uncertainties.changing:
        what = " and ".join(plain.uncertainties.changing)
        raise InputError(
            f"--weighted: the {what} changes between the repetitions, which no position's own "
            "noise tells; calibrate without weights, or each repetition by itself"
        )
    return _weighted(test, test.own, test.scatter, plain)


def _weighted(
    test: SixPositions, own: Array, scatter: SampleScatter, plain: SixPositionFit
) -> SixPositionFit:
    scale = np.abs(np.diag(plain.matrix))
    means, counts, fixture = test.means, test.samples, plain.uncertainties.fixture
    if fixture:  # what errs alike teaches as much as one test
        means, own = means.mean(axis=0)[None], own.mean(axis=0)[None] / len(own)
        counts = counts.sum(axis=0)[None]
    axes = [
        _Axis(means[:, :, k].ravel(), own[:, :, k].ravel(), float(scale[k]), _LEVEL[:, k])
        for k in range(3)
    ]
    freedom = [np.maximum((counts.ravel() - 1.0) / scatter.inflation[k], 1.0) for k in range(3)]
    position, spread = _position(axes, freedom)
    solves = [axis.solve(position) for axis in axes]
    parameters = np.column_stack([s @ axis.outputs for s, axis in zip(solves, axes, strict=True)])
    matrix, bias = parameters[:3].T, parameters[3]
    parts = [_of_noise(k, solves[k], axes[k].own, freedom[k]) for k in range(3)]
    unit = np.array(
        [axis.scale**2 * np.sum(s**2, axis=1) for s, axis in zip(solves, axes, strict=True)]
    )
    parts.append(Part(unit * position, unit**2 * spread))
    noise, beyond = np.sqrt(own.mean(axis=(0, 1))), np.sqrt(position) * scale
    return replace(
        plain,
        matrix=matrix,
        bias=bias,
        correction=inverse(matrix),
        uncertainties=of_parts(parts, matrix, noise, beyond, fixture, ()),
        residuals=test.means - DESIGN @ parameters,
    )


@dataclass(frozen=True)
class _Axis:
    """Outputs (r 6,) of one axis with their ``own`` variances; ``level`` (6,) positions."""

    outputs: Array
    own: Array
    scale: float
    level: NDArray[np.bool_]

    @property
    def design(self) -> Array:
        return np.tile(DESIGN, (len(self.outputs) // len(DESIGN), 1))

    def weights(self, position: float) -> Array:
        variances = self.own + position * self.scale**2
        floor = 1e-12 * float(variances.max()) if variances.any() else 1.0
        return np.asarray(1.0 / np.maximum(variances, floor))

    def solve(self, position: float) -> Array:
        """What makes the parameters (4, r 6) out of the outputs."""
        weighted = self.design * self.weights(position)[:, None]
        return np.asarray(np.linalg.solve(self.design.T @ weighted, weighted.T), float)

    def squares(self, position: float) -> tuple[Array, float]:
        """The form (r 6, r 6) of the weighted squares of residuals, and its value."""
        left = np.eye(len(self.outputs)) - self.design @ self.solve(position)
        form = left.T @ (self.weights(position)[:, None] * left)
        return form, float(self.outputs @ form @ self.outputs)


def _position(axes: list[_Axis], freedom: list[Array]) -> tuple[float, float]:
    """Variance (g²) of positions beyond their noise, and the variance of that.

    An upright axis feels a small misalignment to second order only.
    """
    position = 0.0
    for _ in range(_ROUNDS):
        found = unit = spread = 0.0
        for axis, known in zip(axes, freedom, strict=True):
            form, value = axis.squares(position)
            shared = axis.scale**2 * np.tile(axis.level, len(axis.own) // len(DESIGN))
            found += value - float(np.diag(form) @ axis.own)
            unit += float(np.diag(form) @ shared)
            whole = form * (axis.own + position * shared)
            spread += 2.0 * float(np.sum(whole * whole.T))
            spread += float(np.diag(form) ** 2 @ (2.0 * axis.own**2 / known))
        position, spread = max(found / unit, 0.0), spread / unit**2
    return position, spread * (cut_at_zero(position / np.sqrt(spread)) if spread > 0.0 else 0.0)


def _of_noise(axis: int, solve: Array, own: Array, freedom: Array) -> Part:
    """Variance of one axis' parameters, each position's known from its own samples."""
    variance, spread = np.zeros((3, 4)), np.zeros((3, 4))
    variance[axis] = solve**2 @ own
    spread[axis] = solve**4 @ (2.0 * own**2 / freedom)
    return Part(variance, spread)
