"""Matrix and bias of an accelerometer from arbitrary positions at rest: the norm of gravity.

Whatever its position, a sensor at rest feels one g: ``|L (am - B)| = 1`` with L = M0⁻¹.  A
rotation of L changes no norm, so nine of the twelve parameters are left.  L is taken as
symmetric: of all frames that explain the data as well it is that in which L is closest to the
identity (polar decomposition), so turned least from the sensor's own axes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.calibration.estimate import Estimate
from mcsim.calibration.scatter import SampleScatter, sample_scatter
from mcsim.calibration.uncertainty import cut_at_zero
from mcsim.errors import InputError

Array = NDArray[np.float64]

AXES = "xyz"
#: Elements of the symmetric L, in the order of the unknowns; B follows.
_ELEMENTS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
UNKNOWNS = 9
NAMES = (*(f"l{AXES[i]}{AXES[j]}" for i, j in _ELEMENTS), *(f"b{axis}" for axis in AXES))
#: Condition of the equations from which on positions cover too little, and where a word is due.
REFUSED, WORTH_A_WORD = 300.0, 15.0
#: Rounds in which weights and the scatter between positions settle.
_ROUNDS = 6
_FEWEST_FREEDOM = 1.0
#: Variance (g²) that rounding may make.
_ROUNDING = 1e-24


@dataclass(frozen=True)
class RestPositions:
    """Mean outputs ``means`` (n, 3) of n positions at rest, in fractions of g.

    ``counts`` (n,) are the samples behind them, ``scatter`` what these tell of the noise, None
    where each position is one row; ``names`` (n,) are for messages.
    """

    means: Array
    counts: NDArray[np.int64]
    scatter: SampleScatter | None
    names: tuple[str, ...]

    @classmethod
    def of_samples(cls, positions: Sequence[Array], names: Sequence[str]) -> RestPositions:
        """From the samples (k, 3) of each position, in the order of time."""
        means = np.array([samples.mean(axis=0) for samples in positions])
        counts = np.array([len(samples) for samples in positions])
        return cls(means, counts, sample_scatter(positions), tuple(names))


@dataclass(frozen=True)
class NormFit:
    """Result of a calibration by the norm of gravity.

    ``correction`` (3, 3) is the symmetric L, ``matrix`` its inverse M0, ``bias`` (3,) B in
    fractions of g; ``covariance`` (9, 9) and ``freedom`` (9,) of the unknowns ``NAMES``.
    ``residuals`` (n,) are norms less one, ``deviations`` (n,) what they scatter by;
    ``position`` is the deviation (g) between positions beyond the samples' noise, ``condition``
    that of the equations, ``weakest`` the unknowns that the positions tell least about.
    """

    matrix: Array
    bias: Array
    correction: Array
    covariance: Array
    freedom: Array
    residuals: Array
    deviations: Array
    position: float
    condition: float
    weakest: tuple[str, ...]
    test: RestPositions

    @property
    def scatter(self) -> SampleScatter | None:
        """Noise of the samples, None where each position is one row."""
        return self.test.scatter

    def estimates(self) -> Mapping[str, Estimate]:
        """By name: ``lxx`` … ``lzz``, ``bx``, ``by``, ``bz``, then ``mxx`` … ``mzz``."""
        u, freedom = np.sqrt(np.diag(self.covariance)), self.freedom
        found = {}
        for i in range(3):
            for j in range(3):
                k = _ELEMENTS.index((min(i, j), max(i, j)))
                value = float(self.correction[i, j])
                found[f"l{AXES[i]}{AXES[j]}"] = Estimate(value, float(u[k]), float(freedom[k]))
        for i, axis in enumerate(AXES):
            found[f"b{axis}"] = Estimate(
                float(self.bias[i]), float(u[6 + i]), float(freedom[6 + i])
            )
        return found | self._of_matrix()

    def _of_matrix(self) -> dict[str, Estimate]:
        """dM = -M dL M; degrees of freedom those of L's parts, by Welch and Satterthwaite."""
        found = {}
        for i in range(3):
            for j in range(3):
                outer = np.outer(self.matrix[i], self.matrix[j])
                gradient = np.array(
                    [outer[a, b] + (outer[b, a] if a != b else 0.0) for a, b in _ELEMENTS]
                )
                variance = float(gradient @ self.covariance[:6, :6] @ gradient)
                parts = gradient**2 * np.diag(self.covariance)[:6]
                freedom = parts.sum() ** 2 / float(np.sum(parts**2 / self.freedom[:6]))
                found[f"m{AXES[i]}{AXES[j]}"] = Estimate(
                    float(self.matrix[i, j]), float(np.sqrt(variance)), float(freedom)
                )
        return found


def calibrate_by_norm(test: RestPositions) -> NormFit:
    """Least squares on ``|L (am - B)| = 1``, each position weighted by its own uncertainty.

    The variance of a norm is that of its mean output along the direction that matters, and one
    that all positions share: what they scatter beyond the noise (Paule and Mandel 1982).

    Raises
    ------
    InputError
        Too few positions, or such that cover too little.
    """
    _check_number(test)
    known = _variances(test)
    unknowns = _start(test.means)
    own, extra = np.zeros(len(test.means)), 0.0
    for _ in range(_ROUNDS):
        weights = _weights(own, extra)
        unknowns = _solved(test.means, unknowns, weights)
        residuals, jacobian = equations(test.means, unknowns)
        own = np.sum((_along(test.means, unknowns)) ** 2 * known, axis=1)
        extra = _extra(residuals, own)
    condition, weakest = observability(jacobian)
    _check_condition(condition, weakest)
    covariance, freedom = _uncertainty(jacobian, own, extra, test)
    correction = _symmetric(unknowns)
    return NormFit(
        matrix=np.asarray(np.linalg.inv(correction), float),
        bias=unknowns[6:],
        correction=correction,
        covariance=covariance,
        freedom=freedom,
        residuals=residuals,
        deviations=np.sqrt(own + extra),
        position=float(np.sqrt(extra)),
        condition=condition,
        weakest=weakest,
        test=test,
    )


def equations(means: Array, unknowns: Array) -> tuple[Array, Array]:
    """Norms less one (n,), and their derivatives (n, 9)."""
    offset = means - unknowns[6:]
    true = offset @ _symmetric(unknowns)
    norm = np.linalg.norm(true, axis=1)
    unit = true / norm[:, None]
    of_matrix = [
        unit[:, i] * offset[:, j] + (unit[:, j] * offset[:, i] if i != j else 0.0)
        for i, j in _ELEMENTS
    ]
    return norm - 1.0, np.column_stack([*of_matrix, -unit @ _symmetric(unknowns)])


def observability(jacobian: Array) -> tuple[float, tuple[str, ...]]:
    """Condition number of the equations (n, 9), and the unknowns that are told worst."""
    _, singular, right = np.linalg.svd(jacobian)
    full = np.zeros(UNKNOWNS)
    full[: len(singular)] = singular
    worst = np.abs(right[-1])
    weakest = tuple(NAMES[k] for k in np.argsort(-worst) if worst[k] > 0.5 * worst.max())
    return float(full[0] / full[-1]) if full[-1] > 1e-12 * full[0] else float("inf"), weakest


def _symmetric(unknowns: Array) -> Array:
    matrix = np.empty((3, 3))
    for value, (i, j) in zip(unknowns[:6], _ELEMENTS, strict=True):
        matrix[i, j] = matrix[j, i] = value
    return matrix


def _start(means: Array) -> Array:
    scale = 1.0 / float(np.mean(np.linalg.norm(means, axis=1)))
    return np.array([scale, 0.0, 0.0, scale, 0.0, scale, 0.0, 0.0, 0.0])


def _solved(means: Array, start: Array, weights: Array) -> Array:
    from scipy.optimize import least_squares

    root = np.sqrt(weights)

    def weighted(x: Array) -> Array:
        return np.asarray(root * equations(means, x)[0])

    def slopes(x: Array) -> Array:
        return np.asarray(root[:, None] * equations(means, x)[1])

    found = least_squares(
        weighted,
        start,
        jac=slopes,
        method="lm",
        xtol=1e-14,
        ftol=1e-14,
        gtol=1e-14,
    )
    return np.asarray(found.x, float)


def _variances(test: RestPositions) -> Array:
    """Variance (n, 3) of the mean outputs; zero where nothing tells it."""
    if test.scatter is None:
        return np.zeros(test.means.shape)
    return test.scatter.variance_of_mean(test.counts)


def _along(means: Array, unknowns: Array) -> Array:
    """Derivative (n, 3) of the norms by the outputs."""
    true = (means - unknowns[6:]) @ _symmetric(unknowns)
    return np.asarray(true / np.linalg.norm(true, axis=1)[:, None] @ _symmetric(unknowns))


def _weights(own: Array, extra: float) -> Array:
    """Relative weights (n,), of mean 1; equal where nothing tells them apart."""
    variance = own + extra
    if not np.all(variance > _ROUNDING):
        return np.ones(len(own))
    weights = 1.0 / variance
    return np.asarray(weights / weights.mean())


def _extra(residuals: Array, own: Array) -> float:
    """The variance that makes the weighted squares as many as there are degrees of freedom."""
    freedom = len(residuals) - UNKNOWNS

    def beyond(extra: float) -> float:
        return float(np.sum(residuals**2 / (own + extra))) - freedom

    if freedom == 0 or (own.all() and beyond(0.0) <= 0.0):
        return 0.0
    from scipy.optimize import brentq

    high = float(np.sum(residuals**2)) / freedom
    return 0.0 if high < _ROUNDING else float(brentq(beyond, 1e-9 * high, high * (1.0 + 1e-9)))


def _uncertainty(
    jacobian: Array, own: Array, extra: float, test: RestPositions
) -> tuple[Array, Array]:
    """Covariance (9, 9) and effective degrees of freedom (9,), JCGM 100, Eq. (G.2b)."""
    weights = _weights(own, extra)
    solve = np.linalg.solve((jacobian.T * weights) @ jacobian, jacobian.T * weights)
    variance = own + extra
    covariance = (solve * variance) @ solve.T
    left = len(own) - UNKNOWNS
    of_noise = np.square(solve**2 @ own) * (0.0 if test.scatter is None else _spread(test.scatter))
    spread = of_noise
    if left:
        of_extra = 2.0 * float(np.mean(variance)) ** 2 / left
        of_extra *= cut_at_zero(extra / np.sqrt(of_extra)) if own.any() and of_extra else 1.0
        spread = of_noise + np.sum(solve**2, axis=1) ** 2 * of_extra
    square = np.diag(covariance) ** 2
    known = spread > _ROUNDING**2
    freedom = 2.0 * square / np.where(known, spread, 1.0)
    return covariance, np.where(known, np.maximum(freedom, _FEWEST_FREEDOM), np.inf)


def _spread(scatter: SampleScatter) -> float:
    """Relative variance of the noise's variance, that of the axis which knows it least."""
    return 2.0 / float(scatter.freedom.min())


def _check_number(test: RestPositions) -> None:
    n = len(test.means)
    if n <= UNKNOWNS:
        raise InputError(
            f"{n} position{'s' * (n != 1)} at rest are too few: {UNKNOWNS + 1} are needed, for "
            f"{UNKNOWNS} unknowns and something that checks them; 12 or more are better"
        )


def _check_condition(condition: float, weakest: tuple[str, ...]) -> None:
    if condition > REFUSED:
        raise InputError(
            f"the positions cover too little (condition number {condition:.3g}, at most "
            f"{REFUSED:g}): they tell nothing of {', '.join(weakest)}; turn each axis up, down and "
            "to some angles between"
        )


def simulate_rest_positions(
    correction: Array,
    bias: Array,
    noise: Array,
    count: int,
    samples: int,
    between: float,
    generator: np.random.Generator,
) -> RestPositions:
    """Positions at random, all directions as likely, of a known sensor.

    Parameters
    ----------
    correction, bias, noise
        L (3, 3); B (3,) and the noise of one sample (3,) in fractions of g.
    count, samples : int
        Positions; samples of each.
    between : float
        Deviation (g) by which each axis scatters from position to position besides.
    """
    true = generator.standard_normal((count, 3))
    true /= np.linalg.norm(true, axis=1, keepdims=True)
    means = true @ np.linalg.inv(correction).T + bias
    means = means + generator.standard_normal(means.shape) * np.asarray(noise) / np.sqrt(samples)
    means = means + between * generator.standard_normal(means.shape)
    names = tuple(str(k + 1) for k in range(count))
    counts = np.full(count, samples)
    if samples == 1:
        return RestPositions(means, counts, None, names)
    freedom = float(count * (samples - 1))
    found = np.asarray(noise) * np.sqrt(generator.chisquare(freedom, 3) / freedom)
    own = SampleScatter(found, np.ones(3), np.full(3, freedom))
    return RestPositions(means, counts, own, names)
