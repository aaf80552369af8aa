"""A case's sensor errors laid out as the kernels take them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mcsim.kernels.measurement import ErrorTerms

if TYPE_CHECKING:
    from mcsim.sensors.measurement import Measurement


def laid_out(m: Measurement) -> ErrorTerms:
    """The error terms of a measurement; see ``ErrorTerms`` for the arrays and their shapes."""
    c = len(m.white)
    if not m.innovations:
        return no_terms(c)
    most = max((len(i.decay) for i in m.innovations), default=0)
    most = -(-most // 4) * 4  # the kernels take processes in fours
    n = len(m.innovations[0].deviations) + m.first
    innovation, gains = np.zeros((n, c)), np.zeros((n, c, most))
    decay, start = np.zeros((c, most)), np.zeros((c, most))
    for k, (own, mean) in enumerate(zip(m.innovations, m.means, strict=True)):
        count = len(own.decay)
        innovation[m.first :, k] = own.deviations
        gains[m.first :, k, :count] = own.gains
        decay[k, :count] = own.decay
        start[k, :count] = mean.gains
    errors = m.errors
    nothing, extra = np.zeros(0), np.zeros(0)
    averaged = len(m.ranges) > 0 and bool(errors.calibration or errors.levelling)
    if averaged:
        extra = np.concatenate([errors.hidden_bias, np.ones(2 * c)])
    return ErrorTerms(
        m.mix_to,
        m.mix_from,
        np.array([entry.calibrated for entry in errors.mixing], float),
        np.array([entry.levelled - entry.calibrated for entry in errors.mixing], float),
        np.append(m.mix_deviation, extra),
        innovation,
        gains,
        decay,
        start,
        np.concatenate([np.zeros((m.first, c)), m.jitter]) if len(m.jitter) else m.jitter,
        m.spike_thresholds,
        m.spike_amplitudes,
        m.ranges,
        m.resolutions,
        errors.at_rest if averaged else nothing,
        errors.calibration_spread if averaged else nothing,
        np.array([mean.spread for mean in m.means]) if averaged else nothing,
        np.array([errors.calibration, errors.levelling], float) if averaged else nothing,
    )


def no_terms(channels: int) -> ErrorTerms:
    """The terms where white noise and offsets are all there is."""
    empty, whole = np.zeros(0), np.zeros(0, np.int64)
    nothing = np.zeros((0, channels))
    return ErrorTerms(
        whole,
        whole,
        empty,
        empty,
        empty,
        nothing,
        np.zeros((0, channels, 0)),
        np.zeros((channels, 0)),
        np.zeros((channels, 0)),
        nothing,
        np.zeros(0, np.uint32),
        empty,
        empty,
        empty,
        empty,
        empty,
        empty,
        empty,
    )
