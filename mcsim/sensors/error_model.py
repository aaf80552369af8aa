"""Sensor errors of a scenario as numbers per measured channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.scenario.sensor_block import AccelerometerErrors, GyroscopeErrors
from mcsim.scenario.sensors import BiasCalibration, Sensors
from mcsim.sensors.coloured import NO_PROCESSES, Processes, after_calibration, processes_of
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
    budgets.
    """

    target: int
    source: int
    deviation: float
    term: str


@dataclass(frozen=True)
class ChannelErrors:
    """Error parameters of the channels; arrays (c,) in SI units.

    ``elements`` names each channel's element.
    ``white`` is the deviation of one sample's white noise.  Constant offsets: ``miscalibration``,
    ``turn_on_bias`` and ``gravity_bias`` (what a g-sensitive gyroscope makes of a gravity that
    no channel measures).  ``processes`` are the in-run noise.  ``ranges`` (infinite for none),
    ``resolutions`` and ``spike_amplitudes`` (zero for none); ``spike_rates`` in Hz.
    """

    elements: tuple[str, ...]
    white: Array
    miscalibration: Array
    turn_on_bias: Array
    gravity_bias: Array
    processes: tuple[Processes, ...]
    mixing: tuple[Mixing, ...]
    ranges: Array
    resolutions: Array
    spike_rates: Array
    spike_amplitudes: Array
    bandwidths: tuple[float, ...]
    time_jitter: float

    @property
    def offsets(self) -> Array:
        """Standard deviation of all constant offsets together (c,)."""
        return np.sqrt(self.miscalibration**2 + self.turn_on_bias**2 + self.gravity_bias**2)

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
            gravity_bias=nothing,
            processes=(NO_PROCESSES,) * len(self.white),
            mixing=(),
            ranges=np.full_like(self.white, np.inf),
            resolutions=nothing,
            spike_rates=nothing,
            spike_amplitudes=nothing,
            bandwidths=self.bandwidths,
            time_jitter=0.0,
        )


def channel_errors(
    sensors: Sensors,
    channels: Sequence[Channel],
    duration: float,
    gravity: float = 0.0,
    further: Sequence[Channel] = (),
) -> ChannelErrors:
    """The error parameters of the channels of a case.

    ``duration`` (s) is that of the run, which flicker noise has to span; ``gravity`` (m/s^2) is
    the constant specific force that no channel measures.  ``further`` channels are not measured
    but show in those that are, by misalignment and g-sensitivity.
    """
    return element_errors(
        {ACCELEROMETER: sensors.accelerometer, GYROSCOPE: sensors.gyroscope},
        sensors.rate,
        channels,
        duration,
        gravity,
        further,
        sensors.time_jitter,
        sensors.calibration,
    )


def element_errors(
    blocks: Mapping[str, AccelerometerErrors | GyroscopeErrors],
    rate: float,
    channels: Sequence[Channel],
    duration: float,
    gravity: float = 0.0,
    further: Sequence[Channel] = (),
    time_jitter: float = 0.0,
    calibration: BiasCalibration | None = None,
) -> ChannelErrors:
    """The same from the elements' blocks and the sampling ``rate`` (Hz)."""
    elements = {name: signal_errors(block) for name, block in blocks.items()}

    def of(name: str) -> Array:
        return np.array([getattr(elements[c.element], name)[c.axis] for c in channels])

    def constant(name: str) -> Array:
        return np.array([_axis(getattr(blocks[c.element], name), c.axis) for c in channels])

    white = np.array([sample_deviation(density, rate) for density in of("noise_density")])
    processes = tuple(
        _processes(elements[c.element], c.axis, rate, calibration, float(deviation), duration)
        for c, deviation in zip(channels, white, strict=True)
    )
    calibrated = calibration is not None
    return ChannelErrors(
        elements=tuple(c.element for c in channels),
        white=white,
        miscalibration=constant("miscalibration"),
        turn_on_bias=0.0 * white if calibrated else constant("turn_on_bias"),
        # At rest gravity is there as well: calibration takes its effect away.
        gravity_bias=0.0 * white if calibrated else gravity * _sensitivities(elements, channels),
        processes=processes,
        mixing=tuple(_mixing(elements, channels, (*channels, *further))),
        ranges=of("range"),
        resolutions=of("resolution"),
        spike_rates=np.array([elements[c.element].spike_rate for c in channels]),
        spike_amplitudes=np.array([elements[c.element].spike_amplitude for c in channels]),
        bandwidths=tuple(map(float, of("bandwidth"))),
        time_jitter=time_jitter,
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
) -> Processes:
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
        return processes
    samples = max(1, round(calibration.duration * rate))
    if white == 0.0 and processes.count == 0:
        return NO_PROCESSES  # nothing hides the bias
    return after_calibration(processes, white, samples, calibration.method)


def _sensitivities(elements: dict[str, SignalErrors], channels: Sequence[Channel]) -> Array:
    return np.array(
        [
            elements[c.element].g_sensitivity[c.axis] if c.element == GYROSCOPE else 0.0
            for c in channels
        ]
    )


def _mixing(
    elements: dict[str, SignalErrors], channels: Sequence[Channel], sources: Sequence[Channel]
) -> list[Mixing]:
    """Scale factors, angles between the axes of an element, g-sensitivity of gyroscopes."""
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
                entries.append(entry)
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
        gravity_bias=factor * errors.gravity_bias,
        processes=tuple(p.scaled(float(f)) for p, f in zip(errors.processes, factor, strict=True)),
        mixing=tuple(
            replace(m, deviation=m.deviation * float(factors[m.target] / factors[m.source]))
            for m in errors.mixing
        ),
        ranges=factor * errors.ranges,
        resolutions=factor * errors.resolutions,
        spike_amplitudes=factor * errors.spike_amplitudes,
    )
