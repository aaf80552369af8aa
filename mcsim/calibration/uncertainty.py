"""Uncertainty of a six-position calibration: from samples, positions and repetitions.

The mean output of a position errs by the noise of its samples, which their own scatter
tells, and by what changes from position to position: its alignment above all, slow noise
too.  The latter's variance is what the residuals have beyond the noise.  Each parameter's
variance is a sum of such estimated variances, whose effective degrees of freedom follow by Welch
and Satterthwaite (JCGM 100, G.4).

Repetitions are taken as independent as long as the residuals agree with it.  Positions that err
alike in every repetition (a fixture) teach as much as one test; parameters that change from one
repetition to the next (a bias that each turn-on makes anew) scatter with their own
type-A uncertainty.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.calibration.scatter import SampleScatter

Array = NDArray[np.float64]

_AXIS_ROWS = np.array([sign * np.eye(3)[axis] for axis in range(3) for sign in (1.0, -1.0)])
#: Acceleration and 1 for each position: ``am = DESIGN @ [row of M0, B]``.
DESIGN = np.column_stack([_AXIS_ROWS, np.ones(6)])
SOLVE = np.linalg.pinv(DESIGN)
_HAT = DESIGN @ SOLVE
#: In which positions (6, 3) an axis is level, where misalignment acts to first order.
_LEVEL = np.abs(_AXIS_ROWS) < 0.5
#: Levels of the tests for a fixture and for change: a fixture that is none costs little, while
#: two repetitions taken for changing ones leave a single degree of freedom.
FIXTURE_LEVEL, CHANGE_LEVEL = 0.3, 0.1
#: Scatter (g²) that rounding may make.
_ROUNDING = 1e-24
#: No estimated variance has fewer degrees of freedom.
_FEWEST = 1.0
#: Degrees of freedom of residuals, as a share of their number, where alignment dominates.
_EFFECTIVE = 0.7


@dataclass(frozen=True)
class Uncertainties:
    """Standard uncertainties and effective degrees of freedom.

    ``u`` and ``freedom`` (3, 4) are those of M0's rows and of B; the same with ``correction``
    (3, 3) of its inverse.  ``noise``, ``position`` (3,) are the two parts of one position's
    mean (fractions of g, the first nan where no samples were given); ``fixture`` says that
    positions err alike in all repetitions, ``changing`` what changes between them.
    """

    u: Array
    freedom: Array
    u_correction: Array
    freedom_correction: Array
    noise: Array
    position: Array
    fixture: bool
    changing: tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """A variance (3, 4) of the parameters that comes from one estimate.

    ``spread`` (3, 4) is the variance of that variance.
    """

    variance: Array
    spread: Array


def uncertainties(
    means: Array, counts: NDArray[np.int64], scatter: SampleScatter | None, matrix: Array
) -> Uncertainties:
    """Uncertainties of the least-squares parameters, Eq. (2) and (3).

    Parameters
    ----------
    means : (r, 6, 3)
        Mean outputs of r tests in fractions of g.
    counts : (r, 6)
        Samples behind them.
    scatter
        Noise of the samples, None if each position is one row.
    matrix : (3, 3)
        M0.
    """
    scale = np.abs(np.diag(matrix))
    fits = np.einsum("qp,rpk->rkq", SOLVE, means)
    fixture = len(means) > 1 and _errs_alike(means / scale)
    changing = _changing(means / scale, fits / scale[:, None], fixture) if len(means) > 1 else ()
    if fixture:
        residuals, own = _residuals(means.mean(axis=0)[None]), counts.sum(axis=0)[None]
        tests = 1
    else:
        # Each repetition has parameters of its own where they change.
        residuals = _residuals(means) if changing else means - DESIGN @ fits.mean(axis=0).T
        own, tests = counts, len(means)
    joint = not changing
    parts = (
        _from_residuals(residuals, tests, joint)
        if scatter is None
        else _from_samples(residuals, own, scatter, scale, tests, joint)
    )
    noise, position, components = parts
    if changing:
        components.append(_between(fits, components, changing))
    return of_parts(components, matrix, noise, position, fixture, changing)


def of_parts(
    components: list[Part],
    matrix: Array,
    noise: Array,
    position: Array,
    fixture: bool,
    changing: tuple[str, ...],
) -> Uncertainties:
    """Uncertainties of M0, B and the correction from the parts of M0's and B's variance."""
    u, freedom = _combined(components)
    # dL = -L dM L, and elements of M err independently, as their rows share no position.
    inverse = np.linalg.inv(matrix)
    through = [
        Part(
            inverse**2 @ part.variance[:, :3] @ inverse**2,
            inverse**4 @ part.spread[:, :3] @ inverse**4,
        )
        for part in components
    ]
    u_correction, freedom_correction = _combined(through)
    return Uncertainties(
        u, freedom, u_correction, freedom_correction, noise, position, fixture, changing
    )


def _residuals(means: Array) -> Array:
    """Residuals (r, 6, 3) of fits to each test."""
    return means - np.einsum("pq,rqk->rpk", _HAT, means)


def _from_samples(
    residuals: Array,
    counts: NDArray[np.int64],
    scatter: SampleScatter,
    scale: Array,
    tests: int,
    joint: bool,
) -> tuple[Array, Array, list[Part]]:
    """Parts from the samples' noise and from the positions, whose scatter all axes share.

    In units of the acceleration, a position's misalignment is alike in all directions.
    """
    noise = scatter.variance_of_mean(counts)
    in_g = noise / scale**2
    expected = np.array([_traces(in_g[:, :, k], joint)[0] for k in range(3)])
    seen = np.sum((residuals / scale) ** 2, axis=(0, 1))
    unit = np.array([_traces(np.tile(_LEVEL[:, k], (tests, 1)), joint)[0] for k in range(3)])
    # An axis counts the less, the noisier it is beside what all axes together show.
    own = in_g.mean(axis=(0, 1)) + max(float((seen - expected).sum() / unit.sum()), 0.0)
    weight = (own.max() / np.maximum(own, 1e-6 * own.max())) ** 2 if own.any() else np.ones(3)
    per_unit = float(weight @ unit)
    position = max(float(weight @ (seen - expected)) / per_unit, 0.0)
    squares = np.array(
        [_traces(in_g[:, :, k] + position * _LEVEL[:, k], joint)[1] for k in range(3)]
    )
    of_noise = 2.0 * expected**2 / scatter.freedom
    spread = float(weight**2 @ (2.0 * squares + of_noise)) / per_unit**2
    spread *= cut_at_zero(position / np.sqrt(spread)) if spread > 0.0 else 0.0
    parts = [Part(_of(noise, k), 2.0 * _of(noise, k) ** 2 / scatter.freedom[k]) for k in range(3)]
    # Taken for upright positions too: noise too slow for the samples to show acts there.
    by_position = np.outer(scale**2, np.sum(SOLVE**2, axis=1)) / tests
    parts.append(Part(by_position * position, by_position**2 * spread))
    return np.sqrt(noise.mean(axis=(0, 1))), np.sqrt(position) * scale, parts


def cut_at_zero(mean: float) -> float:
    """Variance of a normal quantity of unit deviation that is cut off below zero."""
    from scipy.special import ndtr

    above, density = float(ndtr(mean)), float(np.exp(-0.5 * mean**2) / np.sqrt(2.0 * np.pi))
    first = mean * above + density
    return (mean**2 + 1.0) * above + mean * density - first**2


def _of(noise: Array, axis: int) -> Array:
    """Variance (3, 4) of the parameters from one axis' noise (r, 6, 3)."""
    result = np.zeros((3, 4))
    result[axis] = SOLVE**2 @ noise[:, :, axis].sum(axis=0) / len(noise) ** 2
    return result


def _from_residuals(residuals: Array, tests: int, joint: bool) -> tuple[Array, Array, list[Part]]:
    """Parts from the residuals alone, axis by axis, since their noise may differ.

    A position that misses the vertical by a small angle changes the outputs of the two level
    axes, and hardly that of the upright one.  So an axis' variance is taken from the positions
    in which it is level; for those in which it is upright this errs on the safe side.
    """
    parts, position = [], np.empty(3)
    for axis in range(3):
        level = _LEVEL[:, axis]
        share = 1.0 - np.linalg.eigvalsh(_HAT[level][:, level])
        free = 4.0 * (tests - 1) if joint else 0.0
        times = 1 if joint else tests
        expected = free + times * float(np.sum(share**2))
        freedom = expected**2 / (free + times * float(np.sum(share**4)))
        variance = float(np.sum(residuals[:, level, axis] ** 2)) / expected
        own = np.zeros((3, 4))
        own[axis] = variance * np.sum(SOLVE**2, axis=1) / tests
        parts.append(Part(own, 2.0 * own**2 / freedom))
        position[axis] = np.sqrt(variance)
    return np.full(3, np.nan), position, parts


def _traces(variances: Array, joint: bool) -> tuple[float, float]:
    """Traces of P V and (P V)^2: V (r, 6) independent positions, P leaves the residuals.

    ``joint`` of one fit to all tests, otherwise of a fit to each.
    """
    v = np.asarray(variances, float)
    leverage, own = np.diag(_HAT), v
    if joint:
        leverage, own = leverage / len(v), v.sum(axis=0)[None] / len(v)
    expected = float(np.sum(v * (1.0 - leverage)))
    squares = float(np.sum(v**2 * (1.0 - 2.0 * leverage)))
    return expected, squares + float(np.einsum("rp,pq,rq->", own, _HAT**2, own))


def _combined(parts: list[Part]) -> tuple[Array, Array]:
    """Standard uncertainties and effective degrees of freedom, JCGM 100, Eq. (G.2b)."""
    variance = np.sum([part.variance for part in parts], axis=0)
    spread = np.sum([part.spread for part in parts], axis=0)
    known = (spread > _ROUNDING**2) & (variance > 0.0)
    freedom = 2.0 * variance**2 / np.where(known, spread, 1.0)
    return np.sqrt(variance), np.where(known, np.maximum(freedom, _FEWEST), np.inf)


def _between(fits: Array, parts: list[Part], changing: tuple[str, ...]) -> Part:
    """What the parameters' own scatter over the repetitions adds."""
    n = len(fits)
    type_a = fits.var(axis=0, ddof=1) / n
    own = np.sum([part.variance for part in parts], axis=0)
    changes = np.array(["matrix" in changing] * 3 + ["bias" in changing])
    return Part(
        np.where(changes, np.maximum(type_a - own, 0.0), 0.0),
        np.where(changes, 2.0 * type_a**2 / (n - 1), 0.0),
    )


def _errs_alike(means: Array) -> bool:
    """Whether the mean residuals over the repetitions exceed what independent ones would have."""
    own, n = _residuals(means), len(means)
    common = own.mean(axis=0)
    between = float(np.sum(common**2)) * n / 6.0
    freedom = 6.0 * (n - 1)
    within = float(np.sum((own - common) ** 2)) / freedom
    return _exceeds(between, within, 6.0, freedom, FIXTURE_LEVEL)


def _changing(means: Array, fits: Array, fixture: bool) -> tuple[str, ...]:
    """Which parameters scatter over the repetitions by more than their positions' errors."""
    own, n = _residuals(means), len(means)
    deviations = own - own.mean(axis=0) if fixture else own
    freedom = 6.0 * (n - 1 if fixture else n)
    within = float(np.sum(deviations**2)) / freedom
    moved = (fits - fits.mean(axis=0)) ** 2 / np.sum(SOLVE**2, axis=1)
    found = []
    for name, squares in {"bias": moved[:, :, 3], "matrix": moved[:, :, :3]}.items():
        number = float(squares[0].size * (n - 1))
        if _exceeds(float(squares.sum()) / number, within, number, freedom, CHANGE_LEVEL):
            found.append(name)
    return tuple(found)


def _exceeds(variance: float, other: float, freedom: float, others: float, level: float) -> bool:
    """Fisher's test, one-sided, of variances (g²) with ``freedom`` and ``others``."""
    from scipy.special import fdtri

    limit = float(fdtri(_EFFECTIVE * freedom, _EFFECTIVE * others, 1.0 - level))
    return variance > limit * other + _ROUNDING
