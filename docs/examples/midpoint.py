"""A rule of your own: the midpoint rule, which turns forces by the heading half-way.

    mcsim run scenarios/paper/figure1.yaml --with docs/examples/midpoint.py \\
        --set sweep=null --set reconstruction.integration=midpoint
"""

import math
from typing import NamedTuple

import mcsim
from mcsim.kernels.planar import Motion
from mcsim.kernels.rotation import turn  # sine and cosine would not vectorise


class State(NamedTuple):
    along: float
    across: float
    u: float  # velocity along and across
    v: float
    c: float  # direction of the vehicle's axis
    s: float


def start(system, motion, read):
    u, v = motion.speed * math.cos(motion.course), motion.speed * math.sin(motion.course)
    c, s = math.cos(motion.heading), math.sin(motion.heading)
    return State(motion.along, motion.across, u, v, c, s)


def step(system, x, read):
    forward, left, angle = read
    T = system.interval
    c, s = turn(x.c, x.s, 0.5 * angle)
    u = x.u + T * (c * forward - s * left)
    v = x.v + T * (s * forward + c * left)
    c, s = turn(c, s, 0.5 * angle)
    return State(x.along + 0.5 * T * (x.u + u), x.across + 0.5 * T * (x.v + v), u, v, c, s)


def end(system, x):
    course, heading = math.atan2(x.v, x.u), math.atan2(x.s, x.c)
    return Motion(x.along, x.across, math.hypot(x.u, x.v), heading, course)


mcsim.add_rule("planar", "midpoint", state=State, start=start, step=step, end=end)
