"""Sensor errors of a scenario as numbers per measured channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.scenario.sensor_block import AccelerometerErrors, GyroscopeErrors
from mcsim.scenario.sensors import BiasCalibration, Sensors
from mcsim.sensor_terms.channel import ACCELEROMETER, GYROSCOPE, Channel
from mcsim.sensor_terms.mechanisms import event, mixing, offset, process
from mcsim.sensor_terms.mechanisms.digitise import Quantisation, Saturation
from mcsim.sensor_terms.mechanisms.low_pass import LowPass
from mcsim.sensor_terms.mechanisms.mechanism import Acts, of_kind, only
from mcsim.sensor_terms.mechanisms.mixing import Mixing
from mcsim.sensor_terms.mechanisms.process import NO_PROCESSES, Process, Processes
from mcsim.sensor_terms.mechanisms.white import White
from mcsim.sensors.coloured import after_calibration
from mcsim.sensors.rest import spread_at_rest
from mcsim.sensors.schedule import Schedule

Array = NDArray[np.float64]
Blocks = Mapping[str, AccelerometerErrors | GyroscopeErrors]


@dataclass(frozen=True)
class ChannelErrors:
    """Error parameters of the channels; arrays (c,) in SI units.

    ``elements`` names each channel's element.
    ``white`` is the deviation of one sample's white noise.  ``constants`` are the deviations (c,)
    of the constant offsets, by the names of their terms.  ``processes`` are the in-run noise, from
    the first sample at rest on where the attitude is levelled.  ``ranges`` (infinite for none),
    ``resolutions`` and ``spike_amplitudes`` (zero for none); ``spike_rates`` in Hz.
    ``interval`` is that of the samples (s).  ``at_rest`` are the true signals before the run,
    ``calibration`` and ``levelling`` the numbers of samples that calibrate biases and whose mean
    levels the attitude, zero for none.  After a bias calibration ``hidden_bias`` is the
    deviation of what was calibrated away, which the sensor's output still holds, and
    ``calibration_spread`` that of the samples that showed it.  ``schedule`` tells when the samples
    are taken; None where that is known and even.
    """

    elements: tuple[str, ...]
    white: Array
    constants: Mapping[str, Array]
    processes: tuple[Processes, ...]
    mixing: tuple[Mixing, ...]
    ranges: Array
    resolutions: Array
    spike_rates: Array
    spike_amplitudes: Array
    bandwidths: tuple[float, ...]
    time_jitter: float
    interval: float
    at_rest: Array
    hidden_bias: Array
    calibration_spread: Array
    calibration: int = 0
    levelling: int = 0
    schedule: Schedule | None = None

    @property
    def offsets(self) -> Array:
        """Standard deviation of all constant offsets together (c,)."""
        return offset.together(self.constants, len(self.white))

    def levels(self, channel: int) -> bool:
        """Whether the mean of a channel at rest levels the attitude, where that is done."""
        return self.elements[channel] == ACCELEROMETER

    def silent(self) -> ChannelErrors:
        """No errors at all, for the same channels."""
        return replace(self.white_alone(), white=np.zeros_like(self.white))

    def white_alone(self) -> ChannelErrors:
        """White noise alone, for the same channels."""
        nothing = np.zeros_like(self.white)
        return ChannelErrors(
            elements=self.elements,
            white=self.white,
            constants={},
            processes=(NO_PROCESSES,) * len(self.white),
            mixing=(),
            ranges=np.full_like(self.white, np.inf),
            resolutions=nothing,
            spike_rates=nothing,
            spike_amplitudes=nothing,
            bandwidths=self.bandwidths,
            time_jitter=0.0,
            interval=self.interval,
            at_rest=self.at_rest,
            hidden_bias=nothing,
            calibration_spread=nothing,
            schedule=self.schedule,
        )


def channel_errors(
    sensors: Sensors,
    channels: Sequence[Channel],
    duration: float,
    at_rest: Array,
    further: Sequence[Channel] = (),
    levelling: float = 0.0,
) -> ChannelErrors:
    """The error parameters of the channels of a case.

    ``duration`` (s) is that of the run.  ``further`` channels are not measured but show in those
    that are, by misalignment and g-sensitivity.  ``at_rest`` (s,) are the true signals of all
    channels, measured ones first, of the vehicle that stands before the run.  Before it the
    attitude is levelled for ``levelling`` (s), and before that biases are calibrated.
    """
    errors = element_errors(
        {ACCELEROMETER: sensors.accelerometer, GYROSCOPE: sensors.gyroscope},
        sensors.rate,
        channels,
        duration,
        at_rest,
        further,
        sensors.calibration,
        levelling,
    )
    return replace(errors, time_jitter=sensors.instant_jitter)


def element_errors(
    blocks: Blocks,
    rate: float,
    channels: Sequence[Channel],
    duration: float,
    at_rest: Array | None = None,
    further: Sequence[Channel] = (),
    calibration: BiasCalibration | None = None,
    levelling: float = 0.0,
) -> ChannelErrors:
    """The same from the elements' blocks and the sampling ``rate`` (Hz)."""
    everything = (*channels, *further)
    at_rest = np.zeros(len(everything)) if at_rest is None else at_rest
    acts = [blocks[c.element].acts_on(c.axis) for c in channels]
    white = np.array([only(own, White, White(0.0)).deviation(rate) for own in acts])
    spikes = [only(own, event.Event, event.Event()) for own in acts]
    at_work = [
        _processes(own, rate, calibration, float(deviation), duration + levelling)
        for own, deviation in zip(acts, white, strict=True)
    ]
    calibrated = calibration is not None
    constants = _constants(acts)
    return ChannelErrors(
        elements=tuple(c.element for c in channels),
        white=white,
        constants={} if calibrated else constants,
        processes=tuple(processes for processes, _ in at_work),
        mixing=tuple(mixing.mixed(acts, everything, at_rest if calibrated else None)),
        ranges=np.array([only(own, Saturation, Saturation()).largest for own in acts]),
        resolutions=np.array([only(own, Quantisation, Quantisation()).step for own in acts]),
        spike_rates=np.array([own.rate for own in spikes]),
        spike_amplitudes=np.array([own.amplitude for own in spikes]),
        bandwidths=tuple(only(own, LowPass, LowPass()).bandwidth for own in acts),
        time_jitter=0.0,
        interval=1.0 / rate,
        at_rest=at_rest[: len(channels)],
        hidden_bias=offset.together(constants if calibrated else {}, len(white)),
        calibration_spread=np.array([spread for _, spread in at_work]),
        calibration=_samples(calibration.duration, rate) if calibration is not None else 0,
        levelling=_samples(levelling, rate) if levelling > 0.0 else 0,
    )


def _constants(acts: Sequence[Acts]) -> dict[str, Array]:
    """Deviations (c,) of the constant offsets by term."""
    offsets = [of_kind(own, offset.Offset) for own in acts]
    names = dict.fromkeys(name for own in offsets for name in own)
    nothing = offset.Offset(0.0)
    return {name: np.array([own.get(name, nothing).deviation for own in offsets]) for name in names}


def _processes(
    acts: Acts,
    rate: float,
    calibration: BiasCalibration | None,
    white: float,
    duration: float,
) -> tuple[Processes, float]:
    """A channel's in-run noise after its calibration, and the samples' spread while it lasted."""
    at_rest = calibration.duration if calibration is not None else 0.0
    processes = process.processes_of(of_kind(acts, Process), 1.0 / rate, duration + at_rest)
    if calibration is None:
        return processes, 0.0
    samples = _samples(calibration.duration, rate)
    spread = spread_at_rest(processes, white, samples)
    spikes = only(acts, event.Event, event.Event())
    noise = event.with_spikes(white, spikes.rate / rate, spikes.amplitude)
    if noise == 0.0 and processes.count == 0:
        return NO_PROCESSES, 0.0  # nothing hides the bias
    return after_calibration(processes, noise, samples, calibration.method), spread


def _samples(duration: float, rate: float) -> int:
    return max(1, round(duration * rate))


def saturates(errors: ChannelErrors, signals: Array, spread: Array) -> bool:
    """Whether a channel's range can matter: signals (n, c), ``spread`` (c,) what errors may add."""
    reach = np.max(np.abs(signals), axis=0) + spread + errors.spike_amplitudes
    return bool(np.any(reach > errors.ranges))


def per_interval(errors: ChannelErrors, rates: Sequence[bool], interval: float) -> ChannelErrors:
    """The same errors with increments per sampling interval in the place of angular rates.

    ``rates`` tells which of the channels, measured ones first, are angular rates.
    """
    return scaled(errors, np.where(rates, interval, 1.0))


def scaled(errors: ChannelErrors, factors: Array) -> ChannelErrors:
    """The same errors in other units; ``factors`` (s,) of the channels, measured ones first."""
    factor = factors[: len(errors.white)]
    return replace(
        errors,
        white=factor * errors.white,
        constants={name: factor * own for name, own in errors.constants.items()},
        processes=tuple(p.scaled(float(f)) for p, f in zip(errors.processes, factor, strict=True)),
        mixing=mixing.rescaled(errors.mixing, factors),
        ranges=factor * errors.ranges,
        resolutions=factor * errors.resolutions,
        spike_amplitudes=factor * errors.spike_amplitudes,
        at_rest=factor * errors.at_rest,
        hidden_bias=factor * errors.hidden_bias,
        calibration_spread=factor * errors.calibration_spread,
    )
