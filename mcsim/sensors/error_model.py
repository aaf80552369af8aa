"""Sensor errors of a scenario as numbers per measured channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.scenario.sensor_block import AccelerometerErrors, GyroscopeErrors
from mcsim.scenario.sensors import BiasCalibration, Sensors
from mcsim.scenario.temperature import Temperature
from mcsim.sensor_terms.channel import ACCELEROMETER, GYROSCOPE, Channel
from mcsim.sensor_terms.mechanisms import event, linear_filter, mixing, offset, process, shaped
from mcsim.sensor_terms.mechanisms.digitise import Quantisation, Saturation
from mcsim.sensor_terms.mechanisms.linear_filter import Filters
from mcsim.sensor_terms.mechanisms.mechanism import Acts, of_kind, only
from mcsim.sensor_terms.mechanisms.mixing import Mixing
from mcsim.sensor_terms.mechanisms.process import NO_PROCESSES, Process, Processes
from mcsim.sensor_terms.mechanisms.shaped import Column
from mcsim.sensor_terms.mechanisms.white import White
from mcsim.sensors.coloured import after_calibration
from mcsim.sensors.rest import spread_at_rest
from mcsim.sensors.schedule import Schedule

Array = NDArray[np.float64]
Blocks = Mapping[str, AccelerometerErrors | GyroscopeErrors]
#: Times of a rest at which a temperature is looked at.
_TIMES_AT_REST = 4096


@dataclass(frozen=True)
class Conditions:
    """What goes before a run and around it.

    Biases are calibrated, then the attitude is levelled for ``levelling`` (s); the ``temperature``
    begins with both.
    """

    calibration: BiasCalibration | None = None
    levelling: float = 0.0
    temperature: Temperature | None = None

    def calibration_samples(self, rate: float) -> int:
        """Samples that calibrate biases, zero for none."""
        return _samples(self.calibration.duration, rate) if self.calibration is not None else 0

    def levelling_samples(self, rate: float) -> int:
        """Samples whose mean levels the attitude, zero for none."""
        return _samples(self.levelling, rate) if self.levelling > 0.0 else 0


@dataclass(frozen=True)
class ChannelErrors:
    """Error parameters of the channels; arrays (c,) in SI units.

    ``elements`` names each channel's element.
    ``white`` is the deviation of one sample's white noise.  ``constants`` are the deviations (c,)
    of the constant offsets, by the names of their terms.  ``processes`` are the in-run noise, from
    the first sample at rest on where the attitude is levelled.  ``ranges`` (infinite for none),
    ``resolutions`` and ``spike_amplitudes`` (zero for none); ``spike_rates`` in Hz.
    ``filters`` are what the true signals are behind.  ``columns`` are courses that stand among the
    signals behind the channels; they follow the channels and the ``temperature``.
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
    filters: tuple[Filters, ...]
    time_jitter: float
    interval: float
    at_rest: Array
    hidden_bias: Array
    calibration_spread: Array
    calibration: int = 0
    levelling: int = 0
    columns: tuple[Column, ...] = ()
    temperature: Temperature | None = None
    schedule: Schedule | None = None

    @property
    def offsets(self) -> Array:
        """Standard deviation of all constant offsets together (c,)."""
        return offset.together(self.constants, len(self.white))

    def with_columns(self, signals: Array, first: int = 0) -> Array:
        """The signals (n, s) of a run with what follows from them behind: (n, s + v).

        They begin with its sample ``first``.
        """
        if not self.columns:
            return signals
        temperature = _temperatures(self.temperature, self._times(first, len(signals)))
        return np.column_stack(
            [signals, *(column.of(signals, temperature) for column in self.columns)]
        )

    def _times(self, first: int, count: int) -> Array:
        """Times (count,) since the sensor's first sample at rest, of samples of the run (s)."""
        rest = (self.calibration + self.levelling) * self.interval
        plan = self.schedule
        if plan is None or plan.instants is None:
            return np.asarray(rest + np.arange(first, first + count) * self.interval)
        return np.asarray(rest + plan.instants.true[first : first + count])

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
            filters=self.filters,
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
    conditions = Conditions(sensors.calibration, levelling, sensors.temperature)
    errors = element_errors(
        {ACCELEROMETER: sensors.accelerometer, GYROSCOPE: sensors.gyroscope},
        sensors.rate,
        channels,
        duration,
        at_rest,
        further,
        conditions,
    )
    return replace(errors, time_jitter=sensors.instant_jitter)


def _filters(blocks: Blocks, channel: Channel) -> Filters:
    """A channel's filters; the force that shows in a gyroscope alone is behind none."""
    block = blocks.get(channel.element)
    return () if block is None else linear_filter.filters_of(block.acts_on(channel.axis))


def element_errors(
    blocks: Blocks,
    rate: float,
    channels: Sequence[Channel],
    duration: float,
    at_rest: Array | None = None,
    further: Sequence[Channel] = (),
    conditions: Conditions = Conditions(),
) -> ChannelErrors:
    """The same from the elements' blocks and the sampling ``rate`` (Hz)."""
    everything = (*channels, *further)
    acts = [blocks[c.element].acts_on(c.axis) for c in channels]
    filters = tuple(_filters(blocks, channel) for channel in everything)
    at_rest = _behind(np.zeros(len(everything)) if at_rest is None else at_rest, filters)
    columns = shaped.columns_of(acts)
    held = _columns_at_rest(columns, at_rest, conditions, rate)
    calibration = conditions.calibration
    white = np.array([only(own, White, White(0.0)).deviation(rate) for own in acts])
    spikes = [only(own, event.Event, event.Event()) for own in acts]
    at_work = [
        _processes(own, rate, calibration, float(deviation), duration + conditions.levelling)
        for own, deviation in zip(acts, white, strict=True)
    ]
    calibrated = calibration is not None
    constants = _constants(acts)
    return ChannelErrors(
        elements=tuple(c.element for c in channels),
        white=white,
        constants={} if calibrated else constants,
        processes=tuple(processes for processes, _ in at_work),
        mixing=(
            *mixing.mixed(acts, everything, at_rest, calibrated),
            *shaped.shares(acts, everything, columns, held, calibrated),
        ),
        ranges=np.array([only(own, Saturation, Saturation()).largest for own in acts]),
        resolutions=np.array([only(own, Quantisation, Quantisation()).step for own in acts]),
        spike_rates=np.array([own.rate for own in spikes]),
        spike_amplitudes=np.array([own.amplitude for own in spikes]),
        filters=filters[: len(channels)],
        time_jitter=0.0,
        interval=1.0 / rate,
        at_rest=at_rest[: len(channels)],
        hidden_bias=offset.together(constants if calibrated else {}, len(white)),
        calibration_spread=np.array([spread for _, spread in at_work]),
        calibration=conditions.calibration_samples(rate),
        levelling=conditions.levelling_samples(rate),
        columns=columns,
        temperature=conditions.temperature,
    )


def _columns_at_rest(
    columns: Sequence[Column], at_rest: Array, conditions: Conditions, rate: float
) -> tuple[Array, Array]:
    """What the columns hold (v,) while biases are calibrated, and in the levelling after it."""
    calibrated = conditions.calibration_samples(rate) / rate
    levelled = calibrated + conditions.levelling_samples(rate) / rate
    return (
        _mean_columns(columns, at_rest, conditions.temperature, (0.0, calibrated)),
        _mean_columns(columns, at_rest, conditions.temperature, (calibrated, levelled)),
    )


def _mean_columns(
    columns: Sequence[Column],
    at_rest: Array,
    temperature: Temperature | None,
    between: tuple[float, float],
) -> Array:
    """Means (v,) of the columns of a sensor at rest between two times since it was switched on."""
    first, last = between
    times = np.linspace(first, last, 2 * _TIMES_AT_REST + 1)[1::2]
    still = np.broadcast_to(at_rest, (len(times), len(at_rest)))
    degrees = _temperatures(temperature, times)
    return np.array([float(column.of(still, degrees).mean()) for column in columns])


def _temperatures(temperature: Temperature | None, times: Array) -> Array:
    return np.zeros(len(times)) if temperature is None else temperature.at(times)


def _behind(at_rest: Array, filters: Sequence[Filters]) -> Array:
    """True signals (s,) at rest behind the channels' filters."""
    passed = [linear_filter.passed(float(v), own) for v, own in zip(at_rest, filters, strict=True)]
    return np.array(passed)


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
    columns = tuple(
        replace(column, factor=column.factor * float(factors[column.channel]))
        for column in errors.columns
    )
    everything = np.append(factors, [factors[column.channel] for column in columns])
    return replace(
        errors,
        white=factor * errors.white,
        constants={name: factor * own for name, own in errors.constants.items()},
        processes=tuple(p.scaled(float(f)) for p, f in zip(errors.processes, factor, strict=True)),
        mixing=mixing.rescaled(errors.mixing, everything),
        ranges=factor * errors.ranges,
        resolutions=factor * errors.resolutions,
        spike_amplitudes=factor * errors.spike_amplitudes,
        at_rest=factor * errors.at_rest,
        hidden_bias=factor * errors.hidden_bias,
        calibration_spread=factor * errors.calibration_spread,
        columns=columns,
    )
