"""What sensors make of the true signals, sample by sample: every case's kernel measures here.

A channel's measured value is made in this order: the true signal, mixed with other channels
(scale factors, misalignment, g-sensitivity) by coefficients drawn once per realization,
constant offsets, sample-time jitter, coloured and white noise (see ``innovations``),
spikes, saturation, quantisation.  Terms that a scenario leaves out have empty arrays and cost
nothing; scenarios with offsets and white noise alone take the kernels' fast paths.

Scratch arrays are flat, one row of ``LANES`` values after the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import uint32
from numpy.typing import NDArray

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import LANES, seed_lanes
from mcsim.kernels.random import normal_pair, xoshiro_next

#: Stream of a realization for jitter and spikes (see ``lanes``).
EVENTS = 2
#: Channels of the planar case, whose normals have a stream of their own.
PLANAR = 3
#: Processes come in multiples of this; missing ones have no gain.
FOUR = 4

Array = NDArray[np.float64]


class ErrorTerms(NamedTuple):
    """The error terms of c channels over n + 1 samples, beyond white noise and offsets.

    mix_to, mix_from : int64 (m,); mix_deviation : float64 (m,)
        Coefficients drawn once per realization: how much of a channel's signal shows in another.
    innovation : float64 (n + 1, c) or (0, c)
        Standard deviation of each sample's innovation; empty where white noise and offsets are
        all there is, and then everything else is empty as well.
    gains, decay : float64 (n + 1, c, p), (c, p)
        Gains and decay of the coloured noise's processes; see ``mcsim.kernels.innovations``.
    jitter : float64 (n + 1, c) or (0, c)
        Slope of each signal times the deviation of the sampling instants.
    spike_thresholds, spike_amplitudes : uint32, float64 (c,) or (0,)
        Half of 2^32 times the probability of a spike per sample, and its height.
    ranges, resolutions : float64 (c,) or (0,)
        Where each channel saturates, and its quantisation step (zero for none).
    """

    mix_to: NDArray[np.int64]
    mix_from: NDArray[np.int64]
    mix_deviation: Array
    innovation: Array
    gains: Array
    decay: Array
    jitter: Array
    spike_thresholds: NDArray[np.uint32]
    spike_amplitudes: Array
    ranges: Array
    resolutions: Array


@scalar
def make_scratch(terms):
    """Coefficients of the mixing and a spare row, processes, and the stream of events."""
    coefficients = np.zeros((len(terms.mix_to) + 1) * LANES, np.float64)
    processes = np.zeros(terms.decay.size * LANES, np.float64)
    return coefficients, processes, np.empty(4 * LANES, np.uint32)


@scalar
def start_measuring(key, first, terms, first_row, constants, scratch):
    """Begin a block: coefficients from the constants' rows ``first_row`` and following."""
    coefficients, processes, event_state = scratch
    draw_coefficients(terms.mix_deviation, first_row, constants, coefficients)
    seed_lanes(key, first, EVENTS, event_state)
    processes[:] = 0.0


@scalar
def _row(array, number):
    """Row ``number`` of a flat array.

    Loops run over such slices: an index that a variable row number enters could be negative for
    all that LLVM knows, and it would not vectorise.
    """
    return array[number * LANES : (number + 1) * LANES]


@scalar
def draw_coefficients(mix_deviation, first_row, constants, coefficients):
    """Coefficients of the mixing entries, from the constants' rows ``first_row`` and following."""
    for entry in range(len(mix_deviation)):
        deviation = mix_deviation[entry]
        normals = _row(constants, first_row + entry)
        own = _row(coefficients, entry)
        for j in range(LANES):
            own[j] = deviation * normals[j]


@scalar
def _truth_and_noise(value, deviation, offsets, normals, measured):
    """The true value, the constant offset, and what a normal adds."""
    for j in range(LANES):
        measured[j] = value + offsets[j] + deviation * normals[j]


@scalar
def _truth_and_coloured_noise(
    value, deviation, offsets, decay, gains, normals, processes, measured
):
    """The same with the first four processes, in one loop."""
    d0, d1, d2, d3 = decay[0], decay[1], decay[2], decay[3]
    g0, g1, g2, g3 = gains[0], gains[1], gains[2], gains[3]
    for j in range(LANES):
        z = np.float64(normals[j])
        x0 = processes[j]
        x1 = processes[LANES + j]
        x2 = processes[2 * LANES + j]
        x3 = processes[3 * LANES + j]
        measured[j] = value + offsets[j] + deviation * z + ((x0 + x1) + (x2 + x3))
        processes[j] = d0 * x0 + g0 * z
        processes[LANES + j] = d1 * x1 + g1 * z
        processes[2 * LANES + j] = d2 * x2 + g2 * z
        processes[3 * LANES + j] = d3 * x3 + g3 * z


@scalar
def _mix(value, coefficients, measured):
    """Add what shows of another channel's true value."""
    for j in range(LANES):
        measured[j] += coefficients[j] * value


@scalar
def _processes(decay, gains, normals, processes, measured):
    """Add four processes' predictions, and move them on by one sample."""
    d0, d1, d2, d3 = decay[0], decay[1], decay[2], decay[3]
    g0, g1, g2, g3 = gains[0], gains[1], gains[2], gains[3]
    for j in range(LANES):
        z = np.float64(normals[j])
        x0 = processes[j]
        x1 = processes[LANES + j]
        x2 = processes[2 * LANES + j]
        x3 = processes[3 * LANES + j]
        measured[j] += (x0 + x1) + (x2 + x3)
        processes[j] = d0 * x0 + g0 * z
        processes[LANES + j] = d1 * x1 + g1 * z
        processes[2 * LANES + j] = d2 * x2 + g2 * z
        processes[3 * LANES + j] = d3 * x3 + g3 * z


@scalar
def _draw_event_normals(event_state, event_normals):
    """One normal per lane from the stream of events."""
    for j in range(LANES):
        s0 = event_state[j]
        s1 = event_state[LANES + j]
        s2 = event_state[2 * LANES + j]
        s3 = event_state[3 * LANES + j]
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        event_normals[j], _ = normal_pair(a, b)
        event_state[j] = s0
        event_state[LANES + j] = s1
        event_state[2 * LANES + j] = s2
        event_state[3 * LANES + j] = s3


@scalar
def _spike(threshold, amplitude, event_state, measured):
    """Add plus or minus the amplitude where a random word falls below the threshold."""
    for j in range(LANES):
        s0 = event_state[j]
        s1 = event_state[LANES + j]
        s2 = event_state[2 * LANES + j]
        s3 = event_state[3 * LANES + j]
        word, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        height = amplitude if (word & uint32(1)) == uint32(0) else -amplitude
        measured[j] += height if (word >> uint32(1)) < threshold else 0.0
        event_state[j] = s0
        event_state[LANES + j] = s1
        event_state[2 * LANES + j] = s2
        event_state[3 * LANES + j] = s3


@scalar
def _saturate(largest, measured):
    for j in range(LANES):
        value = measured[j]
        value = value if value < largest else largest
        measured[j] = value if value > -largest else -largest


@scalar
def _digitise(largest, resolution, measured):
    """Saturate, then round to the nearest step."""
    steps = 1.0 / resolution
    for j in range(LANES):
        value = measured[j]
        value = value if value < largest else largest
        value = value if value > -largest else -largest
        measured[j] = resolution * np.floor(value * steps + 0.5)


@scalar
def measure(
    i,
    channels,
    row,
    normals,
    further_row,
    further_normals,
    signals,
    offsets,
    terms,
    scratch,
    measured,
):
    """All channels of sample ``i``.

    Normals of the first three channels are rows of ``normals`` from ``row`` on, those of
    further channels rows of ``further_normals`` from ``further_row`` on.  The last of the
    coefficients' rows is spare.  Processes come in fours.
    """
    coefficients, processes, event_state = scratch
    count = terms.decay.shape[1]
    for channel in range(channels):
        drawn = (
            _row(normals, row + channel)
            if channel < PLANAR
            else _row(further_normals, further_row + channel - PLANAR)
        )
        value, deviation = signals[i, channel], terms.innovation[i, channel]
        own, offset = _row(measured, channel), _row(offsets, channel)
        for first in range(0, max(count, 1), FOUR):
            begin = (channel * count + first) * LANES
            decay = terms.decay[channel, first : first + FOUR]
            gains = terms.gains[i, channel, first : first + FOUR]
            group = processes[begin : begin + FOUR * LANES]
            if count == 0:
                _truth_and_noise(value, deviation, offset, drawn, own)
            elif first == 0:
                _truth_and_coloured_noise(value, deviation, offset, decay, gains, drawn, group, own)
            else:
                _processes(decay, gains, drawn, group, own)
    for entry in range(len(terms.mix_to)):
        value = signals[i, terms.mix_from[entry]]
        _mix(value, _row(coefficients, entry), _row(measured, terms.mix_to[entry]))
    if terms.jitter.shape[0] > 0:
        common = _row(coefficients, len(terms.mix_to))
        _draw_event_normals(event_state, common)
        for channel in range(channels):
            _mix(terms.jitter[i, channel], common, _row(measured, channel))
    for channel in range(channels):
        own = _row(measured, channel)
        if len(terms.spike_thresholds) > 0:
            threshold, amplitude = terms.spike_thresholds[channel], terms.spike_amplitudes[channel]
            _spike(threshold, amplitude, event_state, own)
        if len(terms.ranges) > 0:
            if terms.resolutions[channel] > 0.0:
                _digitise(terms.ranges[channel], terms.resolutions[channel], own)
            else:
                _saturate(terms.ranges[channel], own)
