"""A velocity problem with one source of uncertainty alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mcsim.systems.velocity.linear import GROUP_SOURCES, NOISE, REST, TIME_BASE
from mcsim.systems.velocity.problem import VelocityProblem

#: The noise of the raw output, at rest and while moving.
ALL_NOISE = "noise"
#: What the accelerometer has beyond white noise.
SENSOR_TERMS = "accelerometer terms"
#: What each source is among the inputs that a group draws once.
_DRAWN_ONCE = {**GROUP_SOURCES, ALL_NOISE: REST}


def acting_alone(problem: VelocityProblem, source: str) -> VelocityProblem:
    """The problem with one source alone.

    ``source`` is one of the linear model's (``calibration matrix`` … ``time base``), ``noise`` at
    rest and while moving, or ``accelerometer terms``.
    """
    alone = np.zeros_like(problem.uncertainties)
    if source in _DRAWN_ONCE:
        alone[_DRAWN_ONCE[source]] = problem.uncertainties[_DRAWN_ONCE[source]]
    errors = problem.sensor_errors
    if source == SENSOR_TERMS:
        errors = replace(errors, white=np.zeros_like(errors.white))
    elif source in (ALL_NOISE, NOISE):
        errors = errors.white_alone()
    else:
        errors = errors.silent()
    return replace(
        problem,
        uncertainties=alone,
        sensor_errors=errors,
        time_error=problem.time_error if source == TIME_BASE else 0.0,
    )
