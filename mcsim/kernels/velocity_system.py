"""What the velocity system is: its state and steps, its numbers, what a group draws once."""

from __future__ import annotations

from typing import NamedTuple

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import WHITE_NOISE
from mcsim.kernels.system import Step

#: Stream of a group for the white noise at rest.
REST_NOISE = 3
#: How the tilt enters, as numbers.
FIRST_ORDER, SECOND_ORDER, EXACT = range(3)
#: Ways of taking a sample.
RUN, REST = range(2)
#: Rows of the results at every instant: a group's first run, mean of all runs, their scatter.
PER_INSTANT = 3


class Inputs(NamedTuple):
    """What a group draws once, in the order of its constants.

    Rows of the calibration matrix; zero biases and means of the raw output at rest (fractions of
    g); the change of tilt (rad), gravity (m/s^2).
    """

    lxx: float
    lxy: float
    lxz: float
    lzx: float
    lzy: float
    lzz: float
    bx: float
    by: float
    bz: float
    rest_x: float
    rest_y: float
    rest_z: float
    tilt: float
    gravity: float


class Deviations(NamedTuple):
    """Standard deviations: of the axes' offsets (fractions of g), and of the inputs."""

    x: float
    y: float
    z: float
    lxx: float
    lxy: float
    lxz: float
    lzx: float
    lzy: float
    lzz: float
    bx: float
    by: float
    bz: float
    rest_x: float
    rest_y: float
    rest_z: float
    tilt: float
    gravity: float


class State(NamedTuple):
    """Velocity, the last stamp's normal, constant and factors of the raw output."""

    speed: float
    stamp: float
    k0: float
    kx: float
    ky: float
    kz: float


class Resting(NamedTuple):
    """The same, then sums of the raw output at rest."""

    speed: float
    stamp: float
    k0: float
    kx: float
    ky: float
    kz: float
    x: float
    y: float
    z: float


class Numbers(NamedTuple):
    """The numbers of a velocity system.

    Parameters
    ----------
    way : int
        ``RUN``.
    draws : bool
        True.
    runs, samples : int
        Runs of a group, and samples of each that are taken.
    at_rest : int
        Samples of the rest where they are measured; zero where their mean is drawn.
    order : int
        ``FIRST_ORDER``, ``SECOND_ORDER`` or ``EXACT`` tilt correction.
    interval : float
        Nominal interval between samples (s).
    time_error : float
        Standard deviation (s) of an interval or, where time stamps err, of a stamp.
    difference : float
        One where time stamps err, so that neighbouring intervals err oppositely; zero where
        intervals err independently.
    inputs : Inputs
        Estimates.
    deviations : Deviations
    """

    way: int
    draws: bool
    runs: int
    samples: int
    at_rest: int
    order: int
    interval: float
    time_error: float
    difference: float
    inputs: Inputs
    deviations: Deviations


@scalar
def _run(system, x, read):
    """One step of a run, Eq. (24); the last that is read is the normal of the interval's error."""
    rx, ry, rz, normal = read
    interval = system.interval + system.time_error * (normal - system.difference * x.stamp)
    speed = x.speed + (x.k0 + x.kx * rx + x.ky * ry + x.kz * rz) * interval
    return State(speed, normal, x.k0, x.kx, x.ky, x.kz)


@scalar
def _timed_run(system, x, read):
    """The same over the interval that is given; a sample that is lost has none."""
    rx, ry, rz, normal, given = read
    taken = given != 0.0
    error = system.time_error * (normal - system.difference * x.stamp)
    interval = system.interval * given + (error if taken else 0.0)
    speed = x.speed + (x.k0 + x.kx * rx + x.ky * ry + x.kz * rz) * interval
    return State(speed, normal if taken else x.stamp, x.k0, x.kx, x.ky, x.kz)


@scalar
def _rest(system, x, read):
    """One sample at rest."""
    rx, ry, rz = read[0], read[1], read[2]
    return Resting(x.speed, x.stamp, x.k0, x.kx, x.ky, x.kz, x.x + rx, x.y + ry, x.z + rz)


class Velocity(Numbers):
    """The velocity system, as the frame knows it."""

    __slots__ = ()

    #: A run changes the velocity and the stamp.
    STEPS = (Step(_run, State, moving=2), Step(_rest, Resting))
    FOURS = {RUN: Step(_run, State, offsets=False, moving=2)}  # noqa: RUF012 - of the class
    SINGLY = True
    #: There is no sample before the first one.
    LATE = (RUN, REST)
    STATE = len(Resting._fields)
    CHANNELS = 3
    #: The normal of the interval.
    BARE = 1
    STREAMS = (WHITE_NOISE,)
    #: The inputs, then offsets of the axes, which have no first sample of their own.
    CONSTANTS = len(Inputs._fields) + 3
    FIXED, FIRST = (len(Inputs._fields),), ()
    ERRORS = PER_INSTANT
    #: The velocity.
    LINEAR = (0,)
    HISTORY = 1
    #: Linear errors of the means at rest, and the last stamp's normal for the linear error.
    SPARE = 4


class TimedVelocity(Velocity):
    """The same at intervals that vary; see ``intervals``."""

    __slots__ = ()

    STEPS = (Step(_timed_run, State, moving=2), Step(_rest, Resting))
    FOURS = {}  # noqa: RUF012 - of the class, not of its instances
    SINGLY = False
    TIMED = True
