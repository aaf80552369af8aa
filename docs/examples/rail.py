"""A case of your own: a vehicle that cannot slip, by forward acceleration and yaw rate alone.

mcsim run docs/examples/rail.yaml --with docs/examples/rail.py
"""

import math
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np

import mcsim
from mcsim.kernels.rotation import turn  # sine and cosine would not vectorise


class Motion(NamedTuple):  # what is believed at the start, and compared at the end
    along: float
    across: float
    speed: float
    heading: float


class State(NamedTuple):
    along: float
    across: float
    speed: float
    c: float  # direction of the vehicle
    s: float


def start(system, motion, read):
    c, s = math.cos(motion.heading), math.sin(motion.heading)
    return State(motion.along, motion.across, motion.speed, c, s)


def step(system, x, read):
    forward, _, angle = read  # a vehicle that cannot slip needs no left acceleration
    T = system.interval
    c, s = turn(x.c, x.s, angle)
    speed = x.speed + T * forward
    return State(x.along + T * speed * c, x.across + T * speed * s, speed, c, s)


def end(system, x):
    return Motion(x.along, x.across, x.speed, math.atan2(x.s, x.c))


RAIL = mcsim.algorithm(
    "rail",
    signals=("forward acceleration", "left acceleration", "yaw rate"),
    motion=Motion,
    state=State,
    functions=(start, step, end),
    angles=("heading",),
    lengths={"position": ("along", "across")},
)


class RailScenario(mcsim.CaseScenario):
    ERRORS: ClassVar[tuple[str, ...]] = RAIL.description.errors
    DRAWN: ClassVar[tuple[str, ...]] = ("position", "speed")
    case: Literal["rail"]
    trajectory: mcsim.Trajectory
    sensors: mcsim.Sensors
    speed_error: Annotated[mcsim.fields.Speed, mcsim.fields.NotNegative] = 0.0


def problem(model, folder):
    drive = mcsim.driven(model.trajectory, model.sensors, folder)
    t = drive.truth
    return mcsim.OwnReckoning(
        algorithm=RAIL,
        signals=drive.signals,
        sensor_errors=drive.sensor_errors,
        truth=np.stack([t.along, t.across, t.speed, t.heading]),
        initial=np.array([0.0, 0.0, model.speed_error, 0.0]),
        interval=drive.interval,
        beyond_rate=drive.beyond_rate,
    )


def samples(model, folder):
    return mcsim.samples_of(model.trajectory, model.sensors, folder)


SPEED = mcsim.ErrorQuantity("speed", "m/s", "error of the speed")
mcsim.add(mcsim.Case("rail", RailScenario, problem, samples, quantities=(SPEED,)))
