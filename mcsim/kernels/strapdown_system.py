"""What the strapdown system is: its motion, its numbers, what a realization draws once."""

from __future__ import annotations

import math
from typing import NamedTuple

from mcsim.kernels import strapdown_steps as steps
from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import LANES, WHITE_NOISE
from mcsim.kernels.quaternion import LARGEST_ROTATION, LITTLE_ROTATION
from mcsim.kernels.rotation import wrap

#: Streams of the channels and constants that the planar system does not have.
SPATIAL_NOISE, SPATIAL_CONSTANTS, MIXING_CONSTANTS = 16, 17, 18
#: Turns among the channels.
TURNS = (2, 4, 5)
#: Ways of taking a sample.
LITTLE, RECTANGULAR, FORWARD_EULER, TRAPEZOIDAL = range(4)
#: The deviation of the mean that levels by the force forwards, among the deviations.
FIRST_OF_REST = 12
_EXACTLY = 3  # further on: the same rules for rotations of any size


class Motion(NamedTuple):
    """Where a vehicle is and moves.

    Along, across, height (m), speed (m/s), climb, roll, pitch, heading, course (rad).
    """

    along: float
    across: float
    height: float
    speed: float
    climb: float
    roll: float
    pitch: float
    heading: float
    course: float


#: At rest in the origin, level.
AT_ORIGIN = Motion(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Force(NamedTuple):
    """A specific force (m/s^2): forward, left, up."""

    forward: float
    left: float
    up: float


class Deviations(NamedTuple):
    """Standard deviations of what a realization draws once.

    Offsets of the channels in their order; initial speed (m/s), direction, heading, course,
    roll, pitch (rad); means of the specific force that level the attitude.
    """

    forward: float
    left: float
    yaw: float
    up: float
    roll_turn: float
    pitch_turn: float
    speed: float
    direction: float
    heading: float
    course: float
    roll: float
    pitch: float
    rest_forward: float
    rest_left: float
    rest_up: float


NO_DEVIATIONS = Deviations(
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
)

#: Where the constants of a realization stand.  The first twelve are the planar system's:
#: offsets of its three channels, initial speed, direction, heading, course, a spare one, noise of
#: sample 0, a spare one.  Then offsets of the other three channels, initial roll and pitch, noise
#: of the levelling's means (forward, left, up), noise of sample 0 of the other channels, a spare.
SPEED, DIRECTION, HEADING, COURSE, FIRST_PLANAR = 3, 4, 5, 6, 8
SPATIAL, ROLL, PITCH, REST, FIRST_SPATIAL = 12, 15, 16, 17, 20


class Numbers(NamedTuple):
    """The numbers of a strapdown system.

    Parameters
    ----------
    way : int
        Number of the step; see ``way_of``.
    interval : float
        Sampling interval T (s).
    gravity : float
        m/s^2, downwards.
    previous_share : float
        Weight of the previous sample in the interval's mean, for the second-order rules: 1/2 for
        momentary samples, 0 for samples that are already means over the interval.
    coning : float
        Weight of the coning and sculling terms: 1/12 or none.
    draws : bool
        Whether anything scales what a realization draws once.
    levelled : bool
        Roll and pitch are initialised from the measured specific force at rest.
    rest : Force
        Specific force at rest in the initial attitude.
    deviations : Deviations
    start, end : Motion
        Truth at sample 0 and at sample n; its course may be NaN there if undefined.
    """

    way: int
    interval: float
    gravity: float
    previous_share: float
    coning: float
    draws: bool
    levelled: bool
    rest: Force
    deviations: Deviations
    start: Motion
    end: Motion


@scalar
def _initial(system, constants, j):
    """The motion that a realization believes to start with; levelling is the algorithm's own."""
    start, deviations = system.start, system.deviations
    direction = deviations.direction * constants[DIRECTION * LANES + j]
    return Motion(
        start.along,
        start.across,
        start.height,
        start.speed + deviations.speed * constants[SPEED * LANES + j],
        start.climb,
        start.roll + deviations.roll * constants[ROLL * LANES + j],
        start.pitch + deviations.pitch * constants[PITCH * LANES + j],
        start.heading + direction + deviations.heading * constants[HEADING * LANES + j],
        start.course + direction + deviations.course * constants[COURSE * LANES + j],
    )


@scalar
def _errors(system, motion):
    """Along, across, height, position, roll, pitch, heading, course."""
    end = system.end
    along, across = motion.along - end.along, motion.across - end.across
    height = motion.height - end.height
    return (
        along,
        across,
        height,
        math.sqrt(along * along + across * across + height * height),
        wrap(motion.roll - end.roll),
        wrap(motion.pitch - end.pitch),
        wrap(motion.heading - end.heading),
        wrap(motion.course - end.course),
    )


@scalar
def _recorded(system, motion):
    """Position, velocity (along, across, height), roll, pitch, heading."""
    level = motion.speed * math.cos(motion.climb)
    return (
        motion.along,
        motion.across,
        motion.height,
        level * math.cos(motion.course),
        level * math.sin(motion.course),
        motion.speed * math.sin(motion.climb),
        motion.roll,
        motion.pitch,
        motion.heading,
    )


class Strapdown(Numbers):
    """The strapdown system, as the frame knows it."""

    __slots__ = ()

    STEPS = (steps.EVEN.rectangular, *steps.EVEN, *steps.EVEN_EXACTLY)
    FOURS = {  # noqa: RUF012 - of the class, not of its instances
        LITTLE: steps.EVEN_LITTLE.rectangular,
        RECTANGULAR: steps.EVEN.rectangular,
        FORWARD_EULER: steps.EVEN.forward_euler,
        TRAPEZOIDAL: steps.EVEN.trapezoidal,
    }
    #: The forward Euler rule reads sample 0 in its first step.
    LATE = (FORWARD_EULER, FORWARD_EULER + _EXACTLY)
    STATE = len(steps.Remembering._fields)
    CHANNELS = 6
    STREAMS = (WHITE_NOISE, SPATIAL_NOISE)
    CONSTANTS = 24
    FIXED, FIRST = (0, SPATIAL), (FIRST_PLANAR, FIRST_SPATIAL)
    #: Along, across, height, position, roll, pitch, heading, course.
    ERRORS = 8
    #: Along, across, height, course, roll, pitch, heading.
    LINEAR = (0, 1, 2, 7, 4, 5, 6)
    #: Position, velocity (along, across, height), roll, pitch, heading.
    HISTORY = 9
    #: Rows for angles and vectors at the start and the end.
    SPARE = 8
    #: For algorithms of a user's own: see ``custom``.
    INITIAL, ERRORS_OF, RECORDED = _initial, _errors, _recorded
    #: Channels that hold turns per interval.
    TURNS = TURNS


class TimedStrapdown(Strapdown):
    """The same at intervals that vary; see ``intervals``.

    The forward Euler rule remembers the sample before: its interval is known with the next one.
    """

    __slots__ = ()

    STEPS = (steps.VARYING.rectangular, *steps.VARYING, *steps.VARYING_EXACTLY)
    FOURS = {}  # noqa: RUF012 - of the class, not of its instances
    LATE = ()  # type: ignore[assignment]
    TIMED = True
    HISTORY = Strapdown.HISTORY + 1


def way_of(rule: str, largest_turn: float) -> int:
    """Which step to take; ``largest_turn`` (rad) bounds the rotation per sample."""
    way = {
        "rectangular": RECTANGULAR,
        "forward_euler": FORWARD_EULER,
        "trapezoidal": TRAPEZOIDAL,
        "two_sample": TRAPEZOIDAL,
    }[rule]
    if largest_turn > LARGEST_ROTATION:
        return way + _EXACTLY
    return LITTLE if way == RECTANGULAR and largest_turn <= LITTLE_ROTATION else way
