"""Ideal accelerations of the excitations, in closed form at any time."""

from __future__ import annotations

import math
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from mcsim.vibration.scenario import Elevator, Harmonic, Sweep

Array = NDArray[np.float64]


def acceleration(excitation: Harmonic | Sweep | Elevator, time: Array, duration: float) -> Array:
    """Acceleration (m/s²) at ``time`` (s), both (n,), of an excitation that lasts ``duration``."""
    match excitation:
        case Harmonic():
            return _harmonic(excitation, time)
        case Sweep():
            return _sweep(excitation, time, duration)
        case Elevator():
            return _elevator(excitation, time)
        case _:
            assert_never(excitation)


def _harmonic(excitation: Harmonic, time: Array) -> Array:
    turn = 2.0 * math.pi * excitation.speed * time
    total: Array = np.zeros_like(time)
    for order in excitation.orders:
        total += order.amplitude * np.sin(order.order * turn + order.phase)
    return total


def _sweep(excitation: Sweep, time: Array, duration: float) -> Array:
    first, last = excitation.first, excitation.last
    if excitation.scale == "linear":
        cycles = first * time + (last - first) * time**2 / (2.0 * duration)
    else:
        octaves = math.log(last / first)
        cycles = first * duration / octaves * np.expm1(octaves * time / duration)
    signal: Array = excitation.amplitude * np.sin(2.0 * math.pi * cycles)
    return signal


def elevator_phases(excitation: Elevator) -> tuple[Array, Array]:
    """Times (s) and accelerations (m/s²) where the run's jerk changes, (8,); linear in between."""
    ramp = excitation.acceleration / excitation.jerk
    hold = excitation.speed / excitation.acceleration - ramp
    rise = 2.0 * ramp + hold
    cruise = excitation.distance / excitation.speed - rise
    steps = [0.0, ramp, hold, ramp, cruise, ramp, hold, ramp]
    top = excitation.acceleration
    times: Array = excitation.start + np.cumsum(steps)
    return times, np.array([0.0, top, top, 0.0, 0.0, -top, -top, 0.0])


def elevator_speed(excitation: Elevator, time: Array) -> Array:
    """Speed of the car (m/s) at ``time`` (s), (n,): the integral of the phases."""
    knots, values = elevator_phases(excitation)
    slopes = np.diff(values) / np.maximum(np.diff(knots), 1e-300)
    speeds = np.concatenate(([0.0], np.cumsum((values[1:] + values[:-1]) / 2.0 * np.diff(knots))))
    at = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, len(slopes) - 1)
    since = np.clip(time, knots[0], knots[-1]) - knots[at]
    speed: Array = speeds[at] + values[at] * since + 0.5 * slopes[at] * since**2
    return speed


def _elevator(excitation: Elevator, time: Array) -> Array:
    total: Array = np.interp(time, *elevator_phases(excitation), left=0.0, right=0.0)
    if excitation.hum:
        share = elevator_speed(excitation, time) / excitation.speed
        for hum in excitation.hum:
            total += hum.amplitude * share * np.sin(2.0 * math.pi * hum.frequency * time)
    return total
