"""The six-position static test: matrix M0 and bias B of a tri-axial accelerometer.

Each axis points up and down along gravity; the raw output of all three axes in the six
positions gives 18 equations ``am = M0 at + B`` for 12 parameters, solved by least squares.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.calibration.columns import read_columns
from mcsim.calibration.estimate import Estimate
from mcsim.calibration.scatter import SampleScatter, own_variances, sample_scatter
from mcsim.calibration.uncertainty import DESIGN, SOLVE, Uncertainties, uncertainties
from mcsim.errors import InputError
from mcsim.systems.velocity.samples import raw_output_of

Array = NDArray[np.float64]

POSITIONS = ("+x", "-x", "+y", "-y", "+z", "-z")
AXES = "xyz"
#: True acceleration (6, 3) in fractions of g: the axis that points up reads +1.
TRUE = DESIGN[:, :3]
#: Outputs beyond these cannot be fractions of g from a sensor that works.
_LARGEST_OUTPUT, _SMALLEST_SENSITIVITY = 3.0, 0.2
_SPELLINGS = {
    "xup": "+x", "xdown": "-x", "yup": "+y", "ydown": "-y", "zup": "+z", "zdown": "-z",
    "x": "+x", "y": "+y", "z": "+z", "x+": "+x", "x-": "-x", "y+": "+y", "y-": "-y",
    "z+": "+z", "z-": "-z",
}  # fmt: skip


@dataclass(frozen=True)
class SixPositions:
    """Mean raw output of a six-position test, repeated r times; fractions of g.

    ``means`` (r, 6, 3): positions in the order of ``POSITIONS``, axes x, y, z; ``scatter`` is
    what the samples' own scatter tells, None where each position is one row; ``counts`` (r, 6)
    are the samples behind each mean, one where absent.  ``own`` (r, 6, 3) are the variances of
    the means by each position's own samples, None where a position has too few.
    """

    means: Array
    scatter: SampleScatter | None = None
    counts: NDArray[np.int64] | None = None
    own: Array | None = None

    @property
    def samples(self) -> NDArray[np.int64]:
        """Samples (r, 6) behind each mean."""
        return np.ones(self.means.shape[:2], int) if self.counts is None else self.counts


@dataclass(frozen=True)
class SixPositionFit:
    """Result of a calibration.

    ``matrix`` (3, 3) is M0, ``bias`` (3,) B in fractions of g, ``correction`` (3, 3) the
    inverse L, ``uncertainties`` theirs.  ``repeatability`` has the type-A uncertainties from
    the repetitions alone (of ``correction`` and ``bias``), None for a single test.
    ``residuals`` (r, 6, 3).
    """

    matrix: Array
    bias: Array
    correction: Array
    uncertainties: Uncertainties
    residuals: Array
    repeatability: tuple[Array, Array] | None
    scatter: SampleScatter | None

    @property
    def u_matrix(self) -> Array:
        return self.uncertainties.u[:, :3]

    @property
    def u_bias(self) -> Array:
        return self.uncertainties.u[:, 3]

    @property
    def u_correction(self) -> Array:
        return self.uncertainties.u_correction

    def estimates(self) -> Mapping[str, Estimate]:
        """By name: ``lxx`` … ``lzz``, ``bx``, ``by``, ``bz``, then ``mxx`` … ``mzz``."""
        u = self.uncertainties
        return (
            _by_name("l", self.correction, u.u_correction, u.freedom_correction)
            | {
                f"b{axis}": Estimate(float(self.bias[i]), float(u.u[i, 3]), float(u.freedom[i, 3]))
                for i, axis in enumerate(AXES)
            }
            | _by_name("m", self.matrix, u.u[:, :3], u.freedom[:, :3])
        )


def _by_name(letter: str, values: Array, deviations: Array, freedom: Array) -> dict[str, Estimate]:
    return {
        f"{letter}{AXES[i]}{AXES[j]}": Estimate(
            float(values[i, j]), float(deviations[i, j]), float(freedom[i, j])
        )
        for i in range(3)
        for j in range(3)
    }


def read_six_positions(path: Path, tell: Callable[[str], None] | None = None) -> SixPositions:
    """Read a test from a CSV file with the columns ``position, x, y, z``.

    ``position`` is +x, -x, … -z (the axis that points up or down); several rows of one position
    are samples in the order of time.  A column ``repetition`` tells repeated tests apart.

    Raises
    ------
    InputError
        A missing position, text, or values that are no fractions of g.
    """
    table = read_columns(path, tuple(AXES), ("position",), ("repetition",), tell)
    outputs = np.column_stack([table.outputs[axis] for axis in AXES])
    written = table.texts["position"]
    repetitions = table.texts.get("repetition", ["1"] * len(written))
    samples: dict[str, dict[str, list[list[float]]]] = {}
    for row, (given, values) in enumerate(zip(written, outputs.tolist(), strict=True)):
        text = given.lower().replace("_", "").replace(" ", "").replace("\N{MINUS SIGN}", "-")
        position = _SPELLINGS.get(text, text)
        if position not in POSITIONS:
            raise InputError(
                f'{table.where(row)}: position: "{given}" is not one of {", ".join(POSITIONS)}; '
                "positions of other directions need --positions arbitrary"
            )
        if max(map(abs, values)) > _LARGEST_OUTPUT:
            raise InputError(
                f"{table.where(row)}: {max(values, key=abs):g} is no fraction of g at rest; "
                "write the unit into the header, such as x [m/s^2], x [mg] or x [16384 counts/g]"
            )
        samples.setdefault(repetitions[row], {}).setdefault(position, []).append(values)
    for repetition, by_position in samples.items():
        missing = [p for p in POSITIONS if p not in by_position]
        if missing:
            where = f" of repetition {repetition}" if len(samples) > 1 else ""
            raise InputError(
                f"{path}: position {', '.join(missing)}{where} is missing; "
                "each axis must point up and down once"
            )
    means = np.array(
        [[np.mean(by_position[p], axis=0) for p in POSITIONS] for by_position in samples.values()]
    )
    _check_positions(path, means)
    rows = [np.array(by_position[p]) for by_position in samples.values() for p in POSITIONS]
    counts = np.array([len(r) for r in rows]).reshape(means.shape[:2])
    scatter = sample_scatter(rows)
    return SixPositions(means, scatter, counts, own_variances(rows, scatter, means.shape))


def _check_positions(path: Path, means: Array) -> None:
    """Refuse positions that cannot be what their names say."""
    for mean in means:
        for i, a in enumerate(POSITIONS):
            for j in range(i):
                if np.abs(mean[i] - mean[j]).max() < _SMALLEST_SENSITIVITY:
                    raise InputError(
                        f"{path}: positions {POSITIONS[j]} and {a} have the same outputs; "
                        "the sensor was not turned between them, or one was written twice"
                    )
        for k, axis in enumerate(AXES):
            up, down, level = mean[2 * k, k], mean[2 * k + 1, k], np.median(mean[:, k])
            if up - level < _SMALLEST_SENSITIVITY or level - down < _SMALLEST_SENSITIVITY:
                raise InputError(
                    f"{path}: axis {axis} reads {up:.3g} g pointing up, {down:.3g} g pointing down "
                    f"and {level:.3g} g level; about +1, -1 and 0 are expected: are positions or "
                    "axes interchanged?"
                )


def calibrate(test: SixPositions) -> SixPositionFit:
    """Least-squares calibration with uncertainties, Eq. (2) and (3).

    Raises
    ------
    InputError
        The matrix cannot be inverted.
    """
    means = test.means
    parameters = SOLVE @ means.mean(axis=0)
    matrix, bias = parameters[:3].T, parameters[3]
    correction = inverse(matrix)
    return SixPositionFit(
        matrix=matrix,
        bias=bias,
        correction=correction,
        uncertainties=uncertainties(means, test.samples, test.scatter, matrix),
        residuals=means - DESIGN @ parameters,
        repeatability=_repeatability(means),
        scatter=test.scatter,
    )


def inverse(matrix: Array) -> Array:
    if np.linalg.cond(matrix) > 100.0:
        raise InputError(
            "the six positions give a singular matrix: two axes respond alike; "
            "are two of them the same channel?"
        )
    return np.asarray(np.linalg.inv(matrix), float)


def _repeatability(means: Array) -> tuple[Array, Array] | None:
    """Type-A uncertainty of the mean over repetitions, of the correction and the bias."""
    n = len(means)
    if n < 2:
        return None
    fits = [SOLVE @ mean for mean in means]
    corrections = np.array([np.linalg.inv(fit[:3].T) for fit in fits])
    biases = np.array([fit[3] for fit in fits])
    return corrections.std(axis=0, ddof=1) / np.sqrt(n), biases.std(axis=0, ddof=1) / np.sqrt(n)


def simulate_six_positions(
    correction: Array,
    bias: Array,
    noise: Array,
    samples: int,
    repetitions: int,
    alignment: float,
    generator: np.random.Generator,
) -> SixPositions:
    """The test of a known sensor.

    Parameters
    ----------
    correction, bias, noise
        L (3, 3); B (3,) and the noise of one sample (3,) in fractions of g.
    samples, repetitions : int
        Samples per position; repetitions of the whole test.
    alignment : float
        Standard deviation (rad) of the angle by which gravity misses the axis, in each of
        the two directions, anew at every position.
    """
    tilts = alignment * generator.standard_normal((repetitions, 6, 3))
    # A small turn of the true vector about a random axis.
    true = TRUE + np.cross(np.broadcast_to(TRUE, tilts.shape), tilts)
    true /= np.linalg.norm(true, axis=-1, keepdims=True)
    mean = raw_output_of(true.reshape(-1, 3), correction, bias).reshape(true.shape)
    counts = np.full(true.shape[:2], samples)
    scatter = generator.standard_normal(true.shape) * noise / np.sqrt(samples)
    if samples == 1:
        return SixPositions(mean + scatter, None, counts)
    freedom = float(counts.size * (samples - 1))
    found = np.asarray(noise) * np.sqrt(generator.chisquare(freedom, 3) / freedom)
    own = SampleScatter(found, np.ones(3), np.full(3, freedom))
    return SixPositions(mean + scatter, own, counts)
