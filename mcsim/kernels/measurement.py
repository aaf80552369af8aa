"""What sensors make of the true signals, sample by sample: every case's kernel measures here.

A channel's measured value is made in this order: the true signal, mixed with other channels
(scale factors, misalignment, g-sensitivity) by coefficients drawn once per realization,
constant offsets, sample-time jitter, coloured and white noise (see ``innovations``),
spikes, saturation, quantisation.  Terms that a scenario leaves out have empty arrays and cost
nothing; scenarios with offsets and white noise alone take the kernels' fast paths.

Scratch arrays are flat, one row of ``LANES`` values after the other.
"""

from __future__ import annotations

import math
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

    mix_to, mix_from : int64 (m,); mix_calibrated, mix_levelled : float64 (m,)
        Whose signal, less its calibrated part, shows in which channel; what of it does so while
        the attitude is levelled.
    mix_deviation : float64 (m,) or (m + 3 c,)
        Coefficients drawn once per realization: how much of a channel's signal shows in another;
        then, where a digital output is averaged at rest, the channels' biases that are calibrated
        away, and normals for what rounding makes of the means that calibrate and that level.
    innovation : float64 (n + 1, c) or (0, c)
        Standard deviation of each sample's innovation; empty where white noise and offsets are
        all there is, and then everything else is empty as well.
    gains, decay : float64 (n + 1, c, p), (c, p)
        Gains and decay of the coloured noise's processes; see ``mcsim.kernels.innovations``.
    start : float64 (c, p)
        What a unit normal of the mean that levels the attitude adds to the processes at the first
        sample.
    jitter : float64 (n + 1, c) or (0, c)
        Slope of each signal times the deviation of the sampling instants.
    spike_thresholds, spike_amplitudes : uint32, float64 (c,) or (0,)
        Half of 2^32 times the probability of a spike per sample, and its height.
    ranges, resolutions : float64 (c,) or (0,)
        Where each channel saturates, and its quantisation step (zero for none).
    calibrated_at, calibration_spread, levelling_spread : float64 (c,) or (0,)
        Where a digital output is averaged at rest: true signals there, and the deviations of the
        samples while biases are calibrated and while the attitude is levelled.
    rest_samples : float64 (2,) or (0,)
        Numbers of these samples, zero for none.
    """

    mix_to: NDArray[np.int64]
    mix_from: NDArray[np.int64]
    mix_calibrated: Array
    mix_levelled: Array
    mix_deviation: Array
    innovation: Array
    gains: Array
    decay: Array
    start: Array
    jitter: Array
    spike_thresholds: NDArray[np.uint32]
    spike_amplitudes: Array
    ranges: Array
    resolutions: Array
    calibrated_at: Array
    calibration_spread: Array
    levelling_spread: Array
    rest_samples: Array


@scalar
def make_scratch(terms):
    """Coefficients and a spare row, processes, the stream of events, and what calibration hides.

    The last has two rows per channel: what the output holds beyond the calibrated value, and
    what is taken off it.
    """
    coefficients = np.zeros((len(terms.mix_deviation) + 1) * LANES, np.float64)
    processes = np.zeros(terms.decay.size * LANES, np.float64)
    hidden = np.zeros(2 * len(terms.calibrated_at) * LANES, np.float64)
    return coefficients, processes, np.empty(4 * LANES, np.uint32), hidden


@scalar
def start_measuring(key, first, terms, first_row, constants, scratch):
    """Begin a block: coefficients from the constants' rows ``first_row`` and following."""
    coefficients, processes, event_state, hidden = scratch
    draw_coefficients(terms.mix_deviation, first_row, constants, coefficients)
    seed_lanes(key, first, EVENTS, event_state)
    processes[:] = 0.0
    if len(hidden) > 0:
        _hide(terms, coefficients, hidden)


@scalar
def _normal_below(x):
    return 0.5 * math.erfc(-x * math.sqrt(0.5))


@scalar
def _mean_cut(value, spread, largest):
    """Mean of a normal value that is cut at plus and minus ``largest``."""
    if largest == math.inf:
        return value
    low, high = (-largest - value) / spread, (largest - value) / spread
    below, above = _normal_below(low), _normal_below(-high)
    density = math.exp(-0.5 * low * low) - math.exp(-0.5 * high * high)
    within = value * (1.0 - below - above) + spread * density / math.sqrt(2.0 * math.pi)
    return within + largest * (above - below)


@scalar
def mean_output(value, spread, largest, resolution):
    """Mean of the digitised output of a normal value, and the variance that rounding adds.

    The mean is what averaging at rest finds; it moves with the mean of the noise.  What
    the samples scatter beyond that is rounding's own.
    """
    if spread <= 0.0:
        cut = min(max(value, -largest), largest)
        only = resolution * np.floor(cut / resolution + 0.5) if resolution > 0.0 else cut
        return only, 0.0
    if resolution <= 0.0:
        return _mean_cut(value, spread, largest), 0.0
    if spread > 1.5 * resolution:
        # Noise of more than a step leaves no trace of the steps in a mean.
        return _mean_cut(value, spread, largest), resolution * resolution / 12.0
    reach = 8.0 * spread
    cut = min(max(value - reach, -largest), largest)
    step = np.floor(cut / resolution + 0.5)
    cut = min(max(value + reach, -largest), largest)
    last = np.floor(cut / resolution + 0.5)
    first, mean, square, slope, order = step, 0.0, 0.0, 0.0, 1.0
    while step < last:
        step += 1.0
        place = (value - (step - 0.5) * resolution) / spread
        beyond = _normal_below(place)
        mean += beyond
        square += order * beyond
        slope += math.exp(-0.5 * place * place)
        order += 2.0
    slope *= resolution / math.sqrt(2.0 * math.pi)
    scatter = resolution * resolution * (square - mean * mean) - slope * slope
    return resolution * (first + mean), max(0.0, scatter)


@scalar
def mean_at_rest(value, normal, samples, spread, largest, resolution):
    """Mean of ``samples`` digitised outputs whose noise has brought ``value``."""
    mean, rounding = mean_output(value, spread, largest, resolution)
    return mean + normal * math.sqrt(rounding / samples)


@scalar
def _hide(terms, coefficients, hidden):
    """What the output holds beyond the calibrated value, and what calibrating at rest takes off."""
    channels = len(terms.calibrated_at)
    mixed, samples = len(terms.mix_to), terms.rest_samples[0]
    if samples == 0.0:
        hidden[:] = 0.0
        return
    hidden[: channels * LANES] = coefficients[mixed * LANES : (mixed + channels) * LANES]
    for entry in range(mixed):
        known = terms.mix_calibrated[entry]
        _mix(known, _row(coefficients, entry), _row(hidden, terms.mix_to[entry]))
    for channel in range(channels):
        at_rest, spread = terms.calibrated_at[channel], terms.calibration_spread[channel]
        largest, resolution = terms.ranges[channel], terms.resolutions[channel]
        bias, taken = _row(hidden, channel), _row(hidden, channels + channel)
        normals = _row(coefficients, mixed + channels + channel)
        for j in range(LANES):
            mean = mean_at_rest(at_rest + bias[j], normals[j], samples, spread, largest, resolution)
            taken[j] = mean - at_rest


@scalar
def expect_after_rest(channel, normals, terms, processes):
    """Move a channel's processes to where the normals of the levelling's mean expect them."""
    count = terms.start.shape[1]
    for s in range(count):
        gain = terms.start[channel, s]
        own = _row(processes, channel * count + s)
        for j in range(LANES):
            own[j] += gain * normals[j]


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
    coefficients, processes, event_state, hidden = scratch
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
        value = signals[i, terms.mix_from[entry]] - terms.mix_calibrated[entry]
        _mix(value, _row(coefficients, entry), _row(measured, terms.mix_to[entry]))
    if terms.jitter.shape[0] > 0:
        common = _row(coefficients, len(terms.mix_deviation))
        _draw_event_normals(event_state, common)
        for channel in range(channels):
            _mix(terms.jitter[i, channel], common, _row(measured, channel))
    for channel in range(channels):
        own = _row(measured, channel)
        if len(terms.spike_thresholds) > 0:
            threshold, amplitude = terms.spike_thresholds[channel], terms.spike_amplitudes[channel]
            _spike(threshold, amplitude, event_state, own)
        if len(hidden) > 0:
            _mix(1.0, _row(hidden, channel), own)
        if len(terms.ranges) > 0:
            if terms.resolutions[channel] > 0.0:
                _digitise(terms.ranges[channel], terms.resolutions[channel], own)
            else:
                _saturate(terms.ranges[channel], own)
        if len(hidden) > 0:
            _mix(-1.0, _row(hidden, channels + channel), own)
