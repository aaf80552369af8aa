"""Logs that a sensor would write of an ideal signal, in plain numpy.

The errors of channels are those that kernels measure with; here the numpy forms of their
mechanisms make a log.  What is constant is drawn once; then the signal comes in pieces of any
size, and the result does not depend on how it is cut.  The order is that of a real element: its
filters, the mixing of the channels, offsets, noise, spikes, saturation, quantisation.
White noise is added behind the filters: its density is that of the output.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms import (
    digitise,
    event,
    linear_filter,
    mixing,
    offset,
    process,
    white,
)
from mcsim.sensors.error_model import ChannelErrors

Array = NDArray[np.float64]


class SimulatedLog:
    """Channels at work: ideal signals in, measured ones out.

    Parameters
    ----------
    errors : ChannelErrors
        Of c channels that sample all at the same instants (no jitter) and are not calibrated
        before.
    seed : int
        Seed of all its random numbers.
    oversampling : int
        Ideal samples per output sample; the filters work on the dense signal, which is then
        picked, aliasing included.
    """

    def __init__(self, errors: ChannelErrors, seed: int, oversampling: int = 1) -> None:
        channels = len(errors.white)
        self._errors = errors
        self._oversampling, self._phase = oversampling, 0
        self._filter = linear_filter.log_filter(errors.filters, oversampling / errors.interval)
        self._measured = 0
        self._mix = mixing.mixer(errors.mixing, seed)
        self._offsets = offset.drawn(errors.constants, channels, seed)
        self._added = [
            white.noise(errors.white, seed),
            process.in_run_noise(errors.processes, seed),
            event.spikes(errors.spike_rates, errors.spike_amplitudes, errors.interval, seed),
        ]

    def measure(self, ideal: Array) -> Array:
        """The output for the next piece of the ideal signals.

        Parameters
        ----------
        ideal : ndarray (n, s)
            At ``oversampling`` times the output rate, the c measured channels first; further ones
            show in them by mixing.

        Returns
        -------
        ndarray (about n / oversampling, c)
        """
        dense = self._filter(np.asarray(ideal, float))
        first = -self._phase % self._oversampling
        self._phase = (self._phase + len(dense)) % self._oversampling
        true = self._errors.with_columns(dense[first :: self._oversampling], self._measured)
        self._measured += len(true)
        measured = true[:, : len(self._offsets)] + self._offsets
        self._mix(true, measured)
        for take in self._added:
            measured += take(len(measured))
        return digitise.digitised(measured, self._errors.ranges, self._errors.resolutions)
