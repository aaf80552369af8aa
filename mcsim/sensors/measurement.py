"""Sensor errors of a case's channels, laid out for the kernels, and their linear effect."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.sensor_terms.mechanisms import event, jitter, mixing, offset, white
from mcsim.sensor_terms.mechanisms.digitise import QUANTISATION, rounding_variances
from mcsim.sensor_terms.mechanisms.process import Processes
from mcsim.sensors.coloured import Innovations, innovations_of
from mcsim.sensors.error_model import ChannelErrors, saturates
from mcsim.sensors.rest import (
    MeanAtRest,
    after_rest,
    rest_and_run,
    spread_at_rest,
    term_variances,
)

if TYPE_CHECKING:
    from mcsim.kernels.measurement import ErrorTerms

Array = NDArray[np.float64]

#: Standard deviations that bound the errors of practically all realizations.
_WIDE = 7.0
#: Samples times processes of in-run noise that fit in memory (0.8 GB).
_MOST_STATES = 50_000_000


@dataclass(frozen=True)
class AtRest:
    """A rest before the run that the run's start is taken from.

    ``weights`` (e, c) of the channels' mean errors there.
    """

    weights: Array


@dataclass(frozen=True)
class NormalWeights:
    """Linear errors per unit normal: of each sample (e, n + 1, c), of the constant offsets
    (e, c), of the mixing coefficients (e, m), of the means that level the attitude (e, c)."""

    samples: Array
    offsets: Array
    mixing: Array
    levelling: Array

    @property
    def covariance(self) -> Array:
        """Covariance (e, e) of the linear errors that the sensors' normals make."""
        samples = self.samples.reshape(len(self.samples), -1)
        parts = (samples, self.offsets, self.mixing, self.levelling)
        return np.asarray(sum(part @ part.T for part in parts), float)


@dataclass(frozen=True)
class Measurement:
    """What a kernel needs to measure with errors; see ``mcsim.kernels.measurement``.

    ``white`` and ``offsets`` (c,) serve the fast paths, ``terms`` the other ones; these are
    empty where white noise and offsets are all there is.  ``means`` are those at the rest that
    levels the attitude, ``first`` the row of ``signals`` that is the first sample after it;
    ``ranged`` tells whether any realization can reach a range.
    """

    errors: ChannelErrors
    white: Array
    offsets: Array
    mix_to: NDArray[np.int64]
    mix_from: NDArray[np.int64]
    mix_deviation: Array
    innovations: tuple[Innovations, ...]
    means: tuple[MeanAtRest, ...]
    jitter: Array
    spike_thresholds: NDArray[np.uint32]
    spike_amplitudes: Array
    ranges: Array
    resolutions: Array
    first: int = 0
    ranged: bool = False

    @classmethod
    def of(
        cls,
        errors: ChannelErrors,
        signals: Array,
        interval: float,
        count: int | None = None,
        first: int = 0,
    ) -> Measurement:
        """Errors of channels that measure ``signals`` (n + 1, c).

        Further columns of ``signals`` are not measured but may show in the others.  Where
        signals repeat, ``count`` is the number of samples that are measured in all.  Rows before
        the ``first`` are never read.

        Raises
        ------
        InputError
            A run too long for the arrays of its in-run noise.
        """
        count = len(signals) if count is None else count
        states = sum(p.count for p in errors.processes)
        if count * states > _MOST_STATES:
            raise InputError(
                f"sensors: the in-run noise of {count:,} samples takes more memory than "
                "mcsim allows; shorten the drive, lower `sensors.rate`, or leave out "
                "bias_instability, random walks and gauss_markov"
            )
        c = len(errors.white)
        own = signals[:, :c]
        ranged = bool(np.any(np.isfinite(errors.ranges))) and saturates(
            errors, own, _WIDE * _spread(errors, signals, count)
        )
        digital = ranged or bool(np.any(errors.resolutions))
        probability = event.probability(errors.spike_rates, interval)
        spiky = bool(np.any(probability * errors.spike_amplitudes))
        coloured = any(p.count for p in errors.processes)
        plain = not (errors.mixing or coloured or digital or spiky or errors.time_jitter > 0.0)
        levelled = [_levelled(errors, k) for k in range(c)]
        return cls(
            errors=errors,
            white=errors.white,
            offsets=errors.offsets,
            mix_to=np.array([m.target for m in errors.mixing], np.int64),
            mix_from=np.array([m.source for m in errors.mixing], np.int64),
            mix_deviation=np.array([m.deviation for m in errors.mixing], float),
            innovations=()
            if plain
            else tuple(
                innovations_of(p, float(deviation), count - first)
                for (p, _), deviation in zip(levelled, errors.white, strict=True)
            ),
            means=tuple(mean for _, mean in levelled),
            jitter=jitter.slopes(own[first:], errors.time_jitter, interval)
            if errors.time_jitter > 0.0
            else np.zeros((0, c)),
            spike_thresholds=event.thresholds_of(probability) if spiky else np.zeros(0, np.uint32),
            spike_amplitudes=errors.spike_amplitudes if spiky else np.zeros(0),
            ranges=errors.ranges if digital else np.zeros(0),
            resolutions=errors.resolutions if digital else np.zeros(0),
            first=first,
            ranged=ranged,
        )

    @classmethod
    def none(cls, errors: ChannelErrors) -> Measurement:
        """Measurement without any error, for the same channels."""
        c = len(errors.white)
        empty, whole = np.zeros(0), np.zeros(0, np.int64)
        return cls(
            errors,
            np.zeros(c),
            np.zeros(c),
            whole,
            whole,
            empty,
            (),
            (MeanAtRest(0.0, empty, 0.0),) * c,
            np.zeros((0, c)),
            np.zeros(0, np.uint32),
            empty,
            empty,
            empty,
        )

    @cached_property
    def terms(self) -> ErrorTerms:
        """The error terms as the kernels take them."""
        from mcsim.sensors.layout import laid_out

        return laid_out(self)

    @property
    def coefficients(self) -> int:
        """Number of coefficients that the kernels draw once per realization."""
        return len(self.terms.mix_deviation)

    def largest(self, signals: Array, channel: int) -> float:
        """A bound of a channel's values that practically no realization exceeds."""
        spread = 0.0
        if np.any(self.white) or np.any(self.offsets) or self.innovations:
            spread = _WIDE * float(_spread(self.errors, signals, len(signals))[channel])
            spread += float(np.sum(self.errors.spike_amplitudes[channel]))
        return float(np.max(np.abs(signals[:, channel]))) + spread

    def fold(self, weights: Array, signals: Array, at_rest: AtRest | None = None) -> NormalWeights:
        """Weights (e, n + 1, c) of the channels' errors as weights of their unit normals.

        Offsets and mixing act also ``at_rest`` before the run, where the case measures there.
        """
        samples = weights * self.white
        e, c = len(weights), len(self.white)
        rest = np.zeros((e, c)) if at_rest is None else at_rest.weights
        levelling = rest * [mean.deviation for mean in self.means]
        if self.innovations:
            samples = np.zeros_like(weights)
            for k, (own, mean) in enumerate(zip(self.innovations, self.means, strict=True)):
                normals, levelling[:, k] = rest_and_run(
                    weights[:, self.first :, k], rest[:, k], own, mean
                )
                samples[:, self.first :, k] = normals
        return NormalWeights(
            samples=samples,
            offsets=_of_offsets(weights, at_rest) * self.offsets,
            mixing=self._mixing_weights(weights, signals, at_rest),
            levelling=levelling,
        )

    def _mixing_weights(self, weights: Array, signals: Array, at_rest: AtRest | None) -> Array:
        """Linear errors (e, m) per unit normal of each mixing coefficient."""
        rest = None if at_rest is None else at_rest.weights
        return mixing.weights_of(self.errors.mixing, weights, signals, rest)

    def variances(
        self, weights: Array, signals: Array, at_rest: AtRest | None = None
    ) -> Mapping[str, Array]:
        """Variance (e,) of the linear errors by source, sensor elements told apart.

        Parameters as in ``fold``.
        """
        found: dict[str, Array] = {}
        for source, variance in self._shares(weights, signals, at_rest):
            found[source] = found.get(source, 0.0) + variance
        return found

    def _shares(
        self, weights: Array, signals: Array, at_rest: AtRest | None
    ) -> Iterator[tuple[str, Array]]:
        """Sources with variances (e,), channel by channel."""
        errors = self.errors
        of_white = white.variances(weights, self.white)
        of_offset = _of_offsets(weights, at_rest)
        rest = np.zeros_like(of_offset) if at_rest is None else at_rest.weights
        for k, element in enumerate(errors.elements):
            yield f"{element} {white.NOISE}", of_white[:, k]
            for source, deviation in errors.constants.items():
                yield f"{element} {source}", offset.variance(of_offset[:, k], deviation[k])
            own = weights[:, self.first :, k], rest[:, k], errors.processes[k]
            levelled = errors.levelling, errors.levels(k)
            for term, variance in term_variances(*own, *levelled).items():
                yield f"{element} {term}", variance
            each = np.sum(weights[:, :, k] ** 2, axis=1)
            if errors.resolutions[k]:
                rounding = self._rounding(k, each, rest[:, k], of_offset[:, k])
                yield f"{element} {QUANTISATION}", rounding
            if len(self.spike_thresholds):
                spikes = float(self._spike_probability[k]), float(self.spike_amplitudes[k])
                yield f"{element} {event.SPIKES}", event.variance(each, *spikes)
        mixed = self._mixing_weights(weights, signals, at_rest)
        for column, entry in enumerate(errors.mixing):
            yield entry.term, mixed[:, column] ** 2
        if len(self.jitter):
            yield jitter.JITTER, jitter.variance(weights[:, self.first :], self.jitter)

    def _rounding(self, k: int, each: Array, rest: Array, offset: Array) -> Array:
        """Variance (e,) of a channel's rounding errors.

        ``each`` (e,) are sums of the samples' squared weights, ``rest`` and ``offset`` (e,) the
        weights of the mean at rest and of a constant.
        """
        resolution = float(self.errors.resolutions[k])
        # A rounding error is uniform over a step, where the noise is no smaller.
        rounding = each * resolution**2 / 12.0
        lasting, _ = rounding_variances(resolution, self.means[k].spread)
        rounding = rounding + rest**2 * lasting
        if self.errors.calibration:
            spread = float(self.errors.calibration_spread[k])
            _, averaging = rounding_variances(resolution, spread)
            rounding = rounding + offset**2 * averaging / self.errors.calibration
        return rounding

    @property
    def _spike_probability(self) -> Array:
        return event.drawn_probability(self.spike_thresholds)

    def levelling_noise(self, at_rest: AtRest) -> Array:
        """Variance (e,) by what changes from sample to sample while the attitude is levelled."""
        errors = self.errors
        if not errors.levelling:
            return np.zeros(len(at_rest.weights))
        variances = np.array(
            [
                _noise_at_rest(errors, k) ** 2
                + rounding_variances(float(errors.resolutions[k]), mean.spread)[1]
                for k, mean in enumerate(self.means)
            ]
        )
        return np.asarray(at_rest.weights**2 @ variances / errors.levelling, float)

    def spike_events(self, weights: Array) -> Array:
        """How many spikes of equal weight a realization has on average, per error (e,)."""
        if not len(self.spike_thresholds):
            return np.zeros(len(weights))
        return event.equal_events(weights, self._spike_probability, self.spike_amplitudes)


def _levelled(errors: ChannelErrors, k: int) -> tuple[Processes, MeanAtRest]:
    """A channel's in-run noise at the first sample, and the mean that levels the attitude."""
    processes = errors.processes[k]
    if not errors.levelling:
        return processes, MeanAtRest(0.0, np.zeros(processes.count), 0.0)
    spread = spread_at_rest(processes, float(errors.white[k]), errors.levelling)
    noise = _noise_at_rest(errors, k)
    return after_rest(processes, noise, errors.levelling, errors.levels(k), spread)


def _noise_at_rest(errors: ChannelErrors, k: int) -> float:
    spikes = float(errors.spike_rates[k]) * errors.interval
    return event.with_spikes(float(errors.white[k]), spikes, float(errors.spike_amplitudes[k]))


def _of_offsets(weights: Array, at_rest: AtRest | None) -> Array:
    """Linear errors (e, c) per constant offset."""
    total = weights.sum(axis=1)
    return total if at_rest is None else total + at_rest.weights


def _spread(errors: ChannelErrors, signals: Array, count: int) -> Array:
    """Standard deviation (c,) of all errors of one of ``count`` samples, with some room."""
    largest = np.max(np.abs(signals), axis=0)
    variance = errors.white**2 + errors.offsets**2 + errors.hidden_bias**2
    for k, p in enumerate(errors.processes):
        last = np.trace(p.start) + count * float(np.sum(p.step_variance[p.decay >= 1.0]))
        variance[k] += last
    for entry in errors.mixing:
        shown = max(largest[entry.source], abs(entry.calibrated))
        variance[entry.target] += (entry.deviation * shown) ** 2
    if errors.time_jitter > 0.0 and len(signals) > 1:
        steps = np.max(np.abs(np.diff(signals[:, : len(variance)], axis=0)), axis=0)
        variance += steps**2
    return np.asarray(np.sqrt(variance) + errors.resolutions / math.sqrt(12.0), float)
