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
from mcsim.cases.velocity_samples import raw_output_of
from mcsim.errors import InputError

Array = NDArray[np.float64]

POSITIONS = ("+x", "-x", "+y", "-y", "+z", "-z")
AXES = "xyz"
#: True acceleration (6, 3) in fractions of g: the axis that points up reads +1.
TRUE = np.array([sign * np.eye(3)[axis] for axis in range(3) for sign in (1.0, -1.0)])
_DESIGN = np.column_stack([TRUE, np.ones(6)])
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

    ``means`` (r, 6, 3): positions in the order of ``POSITIONS``, axes x, y, z; ``noise`` (3,)
    is the standard deviation of one sample, where samples were given.
    """

    means: Array
    noise: Array | None = None


@dataclass(frozen=True)
class SixPositionFit:
    """Result of a calibration.

    ``matrix`` (3, 3) is M0, ``bias`` (3,) B in fractions of g, ``correction`` (3, 3) the
    inverse L; each with its standard uncertainty from the residuals of all repetitions, with
    ``freedom`` degrees of freedom.  ``repeatability`` has the type-A uncertainties from
    the repetitions alone (of ``correction`` and ``bias``), None for a single test.
    ``residuals`` (r, 6, 3).
    """

    matrix: Array
    u_matrix: Array
    bias: Array
    u_bias: Array
    correction: Array
    u_correction: Array
    freedom: float
    residuals: Array
    repeatability: tuple[Array, Array] | None
    noise: Array | None

    def estimates(self) -> Mapping[str, tuple[float, float]]:
        """Estimate and uncertainty by name: ``lxx`` … ``lzz``, ``bx``, ``by``, ``bz``."""
        named = {
            f"l{AXES[i]}{AXES[j]}": (float(self.correction[i, j]), float(self.u_correction[i, j]))
            for i in range(3)
            for j in range(3)
        }
        return named | {
            f"b{axis}": (float(self.bias[i]), float(self.u_bias[i])) for i, axis in enumerate(AXES)
        }


def read_six_positions(path: Path, tell: Callable[[str], None] | None = None) -> SixPositions:
    """Read a test from a CSV file with the columns ``position, x, y, z``.

    ``position`` is +x, -x, … -z (the axis that points up or down); several rows of one position
    are samples.  A column ``repetition`` tells repeated tests apart.

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
                f'{table.where(row)}: position: "{given}" is not one of {", ".join(POSITIONS)}'
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
    spread = [
        np.asarray(rows) - np.mean(rows, axis=0)
        for by_position in samples.values()
        for rows in by_position.values()
        if len(rows) > 1
    ]
    if not spread:
        return SixPositions(means)
    freedom = sum(len(rows) - 1 for rows in spread)
    return SixPositions(means, np.sqrt(np.sum(np.concatenate(spread) ** 2, axis=0) / freedom))


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
    design = np.tile(_DESIGN, (len(test.means), 1))
    outputs = test.means.reshape(-1, 3)
    parameters, *_ = np.linalg.lstsq(design, outputs, rcond=None)
    residuals = outputs - design @ parameters
    u_matrix, u_bias, freedom = _uncertainties(residuals)
    matrix, bias = parameters[:3].T, parameters[3]
    correction = _inverse(matrix)
    # dL = -L dM L: elements of M err independently.
    u_correction = np.sqrt((correction**2) @ u_matrix**2 @ (correction**2))
    return SixPositionFit(
        matrix=matrix,
        u_matrix=u_matrix,
        bias=bias,
        u_bias=u_bias,
        correction=correction,
        u_correction=u_correction,
        freedom=freedom,
        residuals=residuals.reshape(test.means.shape),
        repeatability=_repeatability(test.means),
        noise=test.noise,
    )


def _uncertainties(residuals: Array) -> tuple[Array, Array, float]:
    """Standard uncertainties of M0 (3, 3) and B (3,), and their degrees of freedom.

    A position that misses the vertical by a small angle changes the outputs of the two level
    axes, and hardly that of the upright one.  So an axis' variance is taken from the positions
    in which it is level; for those in which it is upright this errs on the safe side.
    """
    repetitions = len(residuals) // 6
    solve = np.linalg.pinv(_DESIGN)
    hat = _DESIGN @ solve
    u = np.empty((3, 4))
    for axis in range(3):
        level = np.abs(_DESIGN[:, axis]) < 0.5
        # Expected sum of squares of the level residuals per unit variance of level rows.
        own = hat[level][:, level]
        freedom = float(repetitions * level.sum() - 2.0 * np.trace(own) + np.sum(own**2))
        variance = np.sum(residuals[np.tile(level, repetitions), axis] ** 2) / freedom
        u[axis] = np.sqrt(variance * np.sum(solve**2, axis=1) / repetitions)
    return u[:, :3], u[:, 3], freedom


def _inverse(matrix: Array) -> Array:
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
    fits = [np.linalg.lstsq(_DESIGN, mean, rcond=None)[0] for mean in means]
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
    scatter = generator.standard_normal(true.shape) * noise / np.sqrt(samples)
    return SixPositions(mean + scatter, np.asarray(noise) if samples > 1 else None)
