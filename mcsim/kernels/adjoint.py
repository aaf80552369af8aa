"""The linear model of any system: one backward sweep over its own steps.

The end errors of a realization are to first order a weighted sum of everything that disturbs it.
With the step ``x[i+1] = f(x[i], z[i+1])`` and its Jacobians ``A = df/dx``, ``B = df/dz`` the
weights of a sample are ``W[i+1] = l B``, and ``l`` becomes ``l A`` one sample before
(Bryson & Ho, *Applied Optimal Control*, sect. 2.2).

Jacobians are central differences of the fourth order over the frame's own parts: every lane of a
block holds one varied state.  They err by about 1e-8 of their value.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel, scalar
from mcsim.kernels.lane_loops import row_of
from mcsim.kernels.lanes import LANES
from mcsim.kernels.measurement import make_scratch
from mcsim.kernels.system import (
    Sensors,
    advance,
    begin,
    enter,
    interval_place,
    keep,
    linear_rows,
    numbers,
    outcome,
    start_offsets,
)

Array = NDArray[np.float64]

#: Step of the differences, relative to what is varied where that is larger than one.
_STEP = 0.01
#: Lanes that each varied number takes: at -2, -1, 1 and 2 steps.
_POINTS = 4
#: Numbers that fit into a block.
MOST_VARIED = LANES // _POINTS


@scalar
def _vary(row, number, value):
    """Put ``value`` into a row, varied in the lanes of number ``number``; the step."""
    step = _STEP * max(1.0, abs(value))
    for j in range(LANES):
        row[j] = value
    first = number * _POINTS
    row[first] = value - 2.0 * step
    row[first + 1] = value - step
    row[first + 2] = value + step
    row[first + 3] = value + 2.0 * step
    return step


@scalar
def _slope(row, number, step):
    """Derivative of a row with respect to number ``number``."""
    first = number * _POINTS
    far = row[first + 3] - row[first]
    return (8.0 * (row[first + 2] - row[first + 1]) - far) / (12.0 * step)


@kernel
def adjoint(
    system: Any, sensors: Sensors, samples: Array, constants_weights: Array, states: Array
) -> None:
    """Linear errors per unit of every disturbance.

    Parameters
    ----------
    system : NamedTuple
        The numbers of a system, its deviations all one.
    sensors : Sensors
        Their signals; errors do not matter.
    samples : float64 (e, n + 1, c), written
        Weights of the errors of all that each sample's step reads.
    constants_weights : float64 (e, k), written
        Weights of what a realization draws once, apart from what offsets do by the samples.
    states : float64 (n + 1, s), written
        The undisturbed states.
    """
    n_signals, n_channels, _, n_constants, n_linear, at_offsets, _, _, end = numbers(system)
    timed = interval_place(system)
    signals = sensors.signals
    n = signals.shape[0] - 1
    size = at_offsets // LANES
    rows = np.zeros(end, np.float64)
    constants = np.zeros(n_constants * LANES, np.float32)
    measured = np.empty(n_channels * LANES, np.float64)
    scratch = make_scratch(sensors.terms)
    steps = np.empty(size + n_channels)
    jacobian = np.empty((size, size + n_channels))
    sensitivity = np.empty((n_linear, size))

    _read(signals, 0, n_signals, timed, measured)
    _start(system, constants, sensors, scratch, measured, rows)
    _keep_state(rows, states, 0)
    for i in range(1, n + 1):
        _read(signals, i, n_signals, timed, measured)
        advance(system, system.way, measured, rows)
        _keep_state(rows, states, i)
    _end(system, states[n], rows, steps, sensitivity)
    for i in range(n, 0, -1):
        for row in range(size):
            steps[row] = _vary(row_of(rows, row), row, states[i - 1, row])
        for channel in range(n_channels):
            number = size + channel
            value = _signal(signals, i, channel, n_signals, timed)
            steps[number] = _vary(row_of(measured, channel), number, value)
        advance(system, system.way, measured, rows)
        for row in range(size):
            for number in range(size + n_channels):
                jacobian[row, number] = _slope(row_of(rows, row), number, steps[number])
        moved = sensitivity @ jacobian
        samples[:, i] = moved[:, size:]
        sensitivity[:] = moved[:, :size]
    # Sample 0, then what is drawn once, one block of normals after the other.
    for channel in range(n_channels):
        value = _signal(signals, 0, channel, n_signals, timed)
        steps[channel] = _vary(row_of(measured, channel), channel, value)
    _start(system, constants, sensors, scratch, measured, rows)
    for channel in range(n_channels):
        samples[:, 0, channel] = sensitivity @ _slopes(rows, size, channel, steps[channel])
    _read(signals, 0, n_signals, timed, measured)
    for first in range(0, n_constants, MOST_VARIED):
        last = min(first + MOST_VARIED, n_constants)
        constants[:] = 0.0
        for number in range(first, last):
            _vary(row_of(constants, number), number - first, 0.0)
        _start(system, constants, sensors, scratch, measured, rows)
        for number in range(first, last):
            # What float32 makes of the step.
            step = 0.5 * np.float64(row_of(constants, number)[(number - first) * _POINTS + 3])
            slopes = _slopes(rows, size, number - first, step)
            constants_weights[:, number] = sensitivity @ slopes


@scalar
def _slopes(rows, size, number, step):
    found = np.empty(size)
    for row in range(size):
        found[row] = _slope(row_of(rows, row), number, step)
    return found


@scalar
def _signal(signals, i, channel, channels, timed):
    """What a step reads without errors; normals that it reads as they are, are zero."""
    if channel == timed:
        return signals[i, signals.shape[1] - 1]
    return signals[i, channel] if channel < channels else 0.0


@scalar
def _read(signals, i, channels, timed, measured):
    for channel in range(len(measured) // LANES):
        row_of(measured, channel)[:] = _signal(signals, i, channel, channels, timed)


@scalar
def _start(system, constants, sensors, scratch, measured, rows):
    start_offsets(system, constants, rows)
    begin(system, constants, sensors, scratch, rows)
    keep(system, constants, measured, rows)
    enter(system, 0, constants, np.zeros(LANES, np.float32), rows)


@scalar
def _keep_state(rows, states, i):
    for row in range(states.shape[1]):
        states[i, row] = rows[row * LANES]


@scalar
def _end(system, state, rows, steps, sensitivity):
    """Derivatives of the linear errors with respect to the last state."""
    errors = np.empty((len(linear_rows(system)) + 2, LANES))
    for row in range(len(state)):
        steps[row] = _vary(row_of(rows, row), row, state[row])
    outcome(system, rows, errors)
    wanted = linear_rows(system)
    for e in range(len(wanted)):
        for row in range(len(state)):
            slope = _slope(errors[wanted[e]], row, steps[row])
            sensitivity[e, row] = slope if np.isfinite(slope) else 0.0
