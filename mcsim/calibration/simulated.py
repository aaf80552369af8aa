"""Tests of a calibration as the sensor of a velocity scenario would have stood them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mcsim.calibration.norm import RestPositions, simulate_rest_positions
from mcsim.calibration.shaker import LinearityFit, cubic_of, linearity, simulate_shaker
from mcsim.calibration.six_positions import SixPositions, simulate_six_positions
from mcsim.errors import InputError
from mcsim.scenario_file import Scenario
from mcsim.systems.velocity.raw_output import raw_noise
from mcsim.systems.velocity.samples import correction_of
from mcsim.systems.velocity.scenario import Shaker, VelocityScenario

#: Samples of a simulated shaker test.
_MOST_SAMPLES = 100_000_000
_ENDINGS = (".yaml", ".yml")


def is_scenario(path: Path) -> bool:
    """Whether a file is a scenario, whose test is simulated, by its name."""
    return path.suffix.lower() in _ENDINGS


def velocity_scenario(path: Path) -> VelocityScenario:
    """The velocity scenario in a file.

    Raises
    ------
    InputError
        Another case, or not valid.
    """
    base = Scenario.from_yaml(path).base
    if not isinstance(base, VelocityScenario):
        raise InputError(f"{path}: case: `case: velocity` is needed here, not {base.case}")
    return base


def sensitivity(model: VelocityScenario) -> float:
    """The element mxx of M0, the inverse of the correction L."""
    return float(np.linalg.inv(correction_of(model.calibration)[0])[0, 0])


def simulated_test(
    model: VelocityScenario, samples: int, repetitions: int, alignment: float, seed: int
) -> SixPositions:
    """A six-position test of a scenario's sensor.

    Parameters
    ----------
    model : VelocityScenario
    samples, repetitions : int
        Samples per position, and how often the test is made.
    alignment : float
        Standard deviation of each position's angles (rad).
    seed : int
    """
    return simulate_six_positions(
        *correction_of(model.calibration),
        raw_noise(model),
        samples,
        repetitions,
        alignment,
        np.random.default_rng(seed),
    )


def simulated_positions(
    model: VelocityScenario, count: int, samples: int, seed: int
) -> RestPositions:
    """Rests of a scenario's sensor in ``count`` positions at random, ``samples`` in each."""
    return simulate_rest_positions(
        *correction_of(model.calibration),
        raw_noise(model),
        count,
        samples,
        0.0,
        np.random.default_rng(seed),
    )


def simulated_linearity(path: Path, model: VelocityScenario, seed: int) -> LinearityFit:
    """A shaker test of a scenario's sensor, as its block ``shaker`` says; ``path`` for messages.

    Raises
    ------
    InputError
        No such block, frequencies that the sensor does not sample, or too many samples.
    """
    shaker = _shaker(path, model)
    frequencies = np.linspace(shaker.lowest, shaker.highest, shaker.points)
    reference = shaker.amplitude * frequencies / shaker.highest
    scale = sensitivity(model)
    measured = simulate_shaker(
        frequencies,
        reference,
        scale,
        cubic_of(shaker.nonlinearity, shaker.full_scale, scale, reference),
        float(raw_noise(model)[0]),
        np.arange(round(shaker.duration * model.sensor.rate)) / model.sensor.rate,
        shaker.series,
        np.random.default_rng(seed),
    )
    return linearity(reference, measured, shaker.full_scale, simulated=True)


def _shaker(path: Path, model: VelocityScenario) -> Shaker:
    shaker = model.shaker
    if shaker is None:
        raise InputError(
            f"{path}: shaker: is missing; write `shaker: {{full_scale: 15 g, "
            "nonlinearity: 1000 ppm}`"
        )
    rate = model.sensor.rate
    if shaker.highest >= 0.5 * rate:
        raise InputError(
            f"{path}: shaker.highest: {shaker.highest:g} Hz must lie below half of the sensor's "
            f"rate, {0.5 * rate:g} Hz"
        )
    samples = shaker.duration * rate * shaker.points * shaker.series
    if samples > _MOST_SAMPLES:
        raise InputError(
            f"{path}: shaker: {samples:,.0f} samples in all are more than the {_MOST_SAMPLES:,} "
            "that are simulated; shorten `duration`, or lower `points` or `series`"
        )
    return shaker
