"""What a strapdown realization draws once: places among its constants, deviations."""

from __future__ import annotations

import math

import numpy as np

from mcsim.kernels import strapdown
from mcsim.simulation.problem import Array
from mcsim.systems.strapdown.scenario import StrapdownScenario

#: Constants of the channels' offsets, in channel order.
OFFSETS = [0, 1, 2, strapdown.SPATIAL, strapdown.SPATIAL + 1, strapdown.SPATIAL + 2]

#: Constants of the mean specific force at rest, and the channels that it is the mean of.
REST, FORCE = [strapdown.REST, strapdown.REST + 1, strapdown.REST + 2], [0, 1, 3]


#: Constants in the order of ``Deviations``.
DEVIATIONS = [
    *OFFSETS,
    strapdown.SPEED,
    strapdown.DIRECTION,
    strapdown.HEADING,
    strapdown.COURSE,
    strapdown.ROLL,
    strapdown.PITCH,
    *REST,
]

#: Initial errors by source.
INITIAL = {
    "initial speed error": (strapdown.SPEED,),
    "initial direction error": (strapdown.DIRECTION,),
    "initial heading error": (strapdown.HEADING,),
    "initial course error": (strapdown.COURSE,),
    "initial tilt error": (strapdown.ROLL, strapdown.PITCH),
}


def signals_at_rest(force: Array) -> Array:
    """True signals (6,) of a vehicle at rest under the specific force (3,): forward, left, up."""
    signals = np.zeros(strapdown.Strapdown.CHANNELS)
    signals[FORCE] = force
    return signals


def initial_deviations(model: StrapdownScenario) -> Array:
    """Standard deviations (24,) of the initial errors, in the places of the kernel's constants."""
    initial = model.initial
    deviations = np.zeros(strapdown.Strapdown.CONSTANTS)
    deviations[strapdown.SPEED] = initial.speed_error
    deviations[strapdown.DIRECTION] = initial.direction_error
    deviations[strapdown.HEADING] = initial.heading_error
    deviations[strapdown.COURSE] = initial.course_error
    deviations[[strapdown.ROLL, strapdown.PITCH]] = tilt_deviations(model)
    return deviations


def tilt_deviations(model: StrapdownScenario) -> tuple[float, float]:
    """Standard deviations of the initial errors of roll and pitch (rad)."""
    initial = model.initial
    return (
        math.hypot(initial.tilt_error, initial.roll_error),
        math.hypot(initial.tilt_error, initial.pitch_error),
    )
