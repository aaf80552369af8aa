"""Sensor errors of a scenario as numbers per measured channel."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.scenario.sensor_block import AccelerometerErrors, GyroscopeErrors
from mcsim.scenario.sensors import BiasCalibration, Sensors
from mcsim.sensors.coloured import NO_PROCESSES, Processes, after_calibration, processes_of
from mcsim.sensors.rest import spread_at_rest
from mcsim.sensors.signal_errors import SignalErrors, signal_errors
from mcsim.units import sample_deviation

Array = NDArray[np.float64]

ACCELEROMETER, GYROSCOPE = "accelerometer", "gyroscope"


@dataclass(frozen=True)
class Channel:
    """A measured channel: its element and its axis (0, 1, 2 for x, y, z)."""

    element: str
    axis: int


@dataclass(frozen=True)
class Mixing:
    """One coefficient drawn per realization: how much of channel ``source`` shows in ``target``.

    ``deviation`` is in units of the target's per unit of the source's; ``term`` its name in
    budgets.  A bias calibration at rest has taken away what ``calibrated`` of the source,
    its true signal there, makes of the target.
    """

    target: int
    source: int
    deviation: float
    term: str
    calibrated: float = 0.0


@dataclass(frozen=True)
class ChannelErrors:
    """Error parameters of the channels; arrays (c,) in SI units.

    ``elements`` names each channel's element.
    ``white`` is the deviation of one sample's white noise.  Constant offsets: ``miscalibration``
    and ``turn_on_bias``.  ``processes`` are the in-run noise, from the first sample at rest on
    where the attitude is levelled.  ``ranges`` (infinite for none), ``resolutions`` and
    ``spike_amplitudes`` (zero for none); ``spike_rates`` in Hz.
    ``interval`` is that of the samples (s).  ``at_rest`` are the true signals before the run,
    ``calibration`` and ``levelling`` the numbers of samples that calibrate biases and whose mean
    levels the attitude, zero for none.  After a bias calibration ``hidden_bias`` is the
    deviation of what was calibrated away, which the sensor's output still holds, and
    ``calibration_spread`` that of the samples that showed it.
    """

    elements: tuple[str, ...]
    white: Array
    miscalibration: Array
    turn_on_bias: Array
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

    @property
    def offsets(self) -> Array:
        """Standard deviation of all constant offsets together (c,)."""
        return np.hypot(self.miscalibration, self.turn_on_bias)

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
            miscalibration=nothing,
            turn_on_bias=nothing,
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
    return element_errors(
        {ACCELEROMETER: sensors.accelerometer, GYROSCOPE: sensors.gyroscope},
        sensors.rate,
        channels,
        duration,
        at_rest,
        further,
        sensors.time_jitter,
        sensors.calibration,
        levelling,
    )


def element_errors(
    blocks: Mapping[str, AccelerometerErrors | GyroscopeErrors],
    rate: float,
    channels: Sequence[Channel],
    duration: float,
    at_rest: Array | None = None,
    further: Sequence[Channel] = (),
    time_jitter: float = 0.0,
    calibration: BiasCalibration | None = None,
    levelling: float = 0.0,
) -> ChannelErrors:
    """The same from the elements' blocks and the sampling ``rate`` (Hz)."""
    elements = {name: signal_errors(block) for name, block in blocks.items()}
    everything = (*channels, *further)
    at_rest = np.zeros(len(everything)) if at_rest is None else at_rest

    def of(name: str) -> Array:
        return np.array([getattr(elements[c.element], name)[c.axis] for c in channels])

    def constant(name: str) -> Array:
        return np.array([_axis(getattr(blocks[c.element], name), c.axis) for c in channels])

    white = np.array([sample_deviation(density, rate) for density in of("noise_density")])
    calibrated = calibration is not None
    at_work = [
        _processes(elements[c.element], c.axis, rate, calibration, float(deviation),
                   duration + levelling)
        for c, deviation in zip(channels, white, strict=True)
    ]  # fmt: skip
    nothing = 0.0 * white
    return ChannelErrors(
        elements=tuple(c.element for c in channels),
        white=white,
        miscalibration=constant("miscalibration"),
        turn_on_bias=nothing if calibrated else constant("turn_on_bias"),
        processes=tuple(processes for processes, _ in at_work),
        mixing=tuple(_mixing(elements, channels, everything, at_rest if calibrated else None)),
        ranges=of("range"),
        resolutions=of("resolution"),
        spike_rates=np.array([elements[c.element].spike_rate for c in channels]),
        spike_amplitudes=np.array([elements[c.element].spike_amplitude for c in channels]),
        bandwidths=tuple(map(float, of("bandwidth"))),
        time_jitter=time_jitter,
        interval=1.0 / rate,
        at_rest=at_rest[: len(channels)],
        hidden_bias=constant("turn_on_bias") if calibrated else nothing,
        calibration_spread=np.array([spread for _, spread in at_work]),
        calibration=_samples(calibration.duration, rate) if calibration is not None else 0,
        levelling=_samples(levelling, rate) if levelling > 0.0 else 0,
    )


def _axis(values: tuple[float, ...] | None, axis: int) -> float:
    if values is None:
        return 0.0
    return values[axis] if len(values) > 1 else values[0]


def _processes(
    element: SignalErrors,
    axis: int,
    rate: float,
    calibration: BiasCalibration | None,
    white: float,
    duration: float,
) -> tuple[Processes, float]:
    """A channel's in-run noise after its calibration, and the samples' spread while it lasted."""
    at_rest = calibration.duration if calibration is not None else 0.0
    processes = processes_of(
        float(element.bias_instability[axis]),
        float(element.random_walk[axis]),
        float(element.drift[axis]),
        float(element.drift_time[axis]),
        1.0 / rate,
        duration + at_rest,
    )
    if calibration is None:
        return processes, 0.0
    samples = _samples(calibration.duration, rate)
    spread = spread_at_rest(processes, white, samples)
    noise = noise_at_rest(white, element.spike_rate / rate, element.spike_amplitude)
    if noise == 0.0 and processes.count == 0:
        return NO_PROCESSES, 0.0  # nothing hides the bias
    return after_calibration(processes, noise, samples, calibration.method), spread


def noise_at_rest(white: float, spikes_per_sample: float, amplitude: float) -> float:
    """Deviation of all that a sensor adds anew to every sample: white noise and spikes."""
    spikes = min(spikes_per_sample, 1.0) * amplitude**2
    return white if spikes == 0.0 else math.sqrt(white**2 + spikes)


def _samples(duration: float, rate: float) -> int:
    return max(1, round(duration * rate))


def _mixing(
    elements: dict[str, SignalErrors],
    channels: Sequence[Channel],
    sources: Sequence[Channel],
    calibrated: Array | None,
) -> list[Mixing]:
    """Scale factors, angles between the axes of an element, g-sensitivity of gyroscopes.

    What they make of the true signals at rest stands in the output of a sensor that is
    ``calibrated`` there as a bias does, and goes with it.
    """
    entries = []
    for i, target in enumerate(channels):
        own = elements[target.element]
        name = target.element
        for k, source in enumerate(sources):
            if i == k:
                entry = Mixing(i, k, float(own.scale_factor[target.axis]), f"{name} scale factor")
            elif source.element == target.element:
                entry = Mixing(i, k, float(own.misalignment[target.axis]), f"{name} misalignment")
            elif target.element == GYROSCOPE:
                entry = Mixing(i, k, float(own.g_sensitivity[target.axis]), f"{name} g-sensitivity")
            else:
                continue
            if entry.deviation > 0.0:
                known = 0.0 if calibrated is None else float(calibrated[k])
                entries.append(replace(entry, calibrated=known))
    return entries


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
        miscalibration=factor * errors.miscalibration,
        turn_on_bias=factor * errors.turn_on_bias,
        processes=tuple(p.scaled(float(f)) for p, f in zip(errors.processes, factor, strict=True)),
        mixing=tuple(
            replace(
                m,
                deviation=m.deviation * float(factors[m.target] / factors[m.source]),
                calibrated=m.calibrated * float(factors[m.source]),
            )
            for m in errors.mixing
        ),
        ranges=factor * errors.ranges,
        resolutions=factor * errors.resolutions,
        spike_amplitudes=factor * errors.spike_amplitudes,
        at_rest=factor * errors.at_rest,
        hidden_bias=factor * errors.hidden_bias,
        calibration_spread=factor * errors.calibration_spread,
    )
