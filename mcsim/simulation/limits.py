"""Bounds of sensors and of models that a point reaches: each is looked for and said.

A check is a function that yields limits.  What a realization may or may not reach (a range) is
counted by running the same realizations without it; what the point itself reaches needs no count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from mcsim.sensor_terms import bias_instability
from mcsim.sensor_terms.channel import GYROSCOPE
from mcsim.sensors.error_model import ChannelErrors
from mcsim.sensors.measurement import Measurement
from mcsim.simulation.problem import Array, Limit

#: Share of a signal's power above half the sampling rate that is worth saying.
_BEYOND_RATE = 0.01
#: Second term of the sampling instant's error in units of the first.
_SECOND_ORDER = 0.1
#: Samples of a run from which on flicker noise has clusters that it is accurate for: it is
#: from five samples to a tenth of the run.
_FLICKER_SAMPLES = 50
#: Time (s) for which a level frame holds that neither turns nor curves.
_LEVEL_FRAME = 600.0
#: Angles (rad): of a tilt that is no longer small, of a pitch where roll and heading merge.
SMALL_TILT, STEEP_PITCH = 0.2, np.radians(85.0)
#: Deviations of the linear model that practically no realization exceeds.
_WIDE = 7.0

Simulate = Callable[[Measurement], Array]


@dataclass(frozen=True)
class Units:
    """What values of channels are multiplied by for words, and their units."""

    factors: Array
    names: tuple[str, ...]


def units_of(errors: ChannelErrors, interval: float) -> Units:
    """m/s² and °/s of channels that hold accelerations and turns per interval."""
    turns = [element == GYROSCOPE for element in errors.elements]
    return Units(
        np.where(turns, np.degrees(1.0) / interval, 1.0),
        tuple("°/s" if turn else "m/s²" for turn in turns),
    )


def sensor_limits(
    measurement: Measurement,
    signals: Array,
    units: Units,
    interval: float,
    simulate: Simulate,
) -> Iterator[Limit]:
    """What any case's sensors reach.

    ``signals`` (n, c or more) are undisturbed; ``simulate`` gives the errors (e, r) that some
    realizations have with a measurement.
    """
    yield from _ranges(measurement, signals, units, simulate)
    yield from _resolutions(measurement.errors, signals, units)
    yield from _jitter(measurement.errors, signals, interval)
    yield from _flicker(measurement.errors, len(signals))


def _ranges(
    measurement: Measurement, signals: Array, units: Units, simulate: Simulate
) -> Iterator[Limit]:
    """Ranges that can be reached, with the realizations that differ from those without them."""
    elements = np.array(measurement.errors.elements)
    ranges = measurement.ranges
    if not measurement.ranged:
        return
    disturbed = simulate(measurement)
    largest = np.max(np.abs(signals[:, : len(elements)]), axis=0)
    for element in dict.fromkeys(elements):
        own = (elements == element) & np.isfinite(ranges)
        if not own.any():
            continue
        # So large that it acts as none, and takes the same way through the kernel.
        free = simulate(replace(measurement, ranges=np.where(own, 1e300, ranges)))
        differs = np.any((disturbed != free) & np.isfinite(disturbed), axis=0)
        reached, count = int(differs.sum()), len(differs)
        beyond = np.flatnonzero(own & (largest > ranges))
        # Of several channels the one that is asked for most beyond its range.
        asked = np.flatnonzero(own)[np.argmax((largest / ranges)[own])]
        text = ""
        if reached or len(beyond):
            text = (
                f"{element}: its range of {_words(ranges, asked, units)} is reached in "
                f"{reached:,} of {count:,} realizations"
            )
        if len(beyond):
            text += f"; the undisturbed motion alone asks for {_words(largest, asked, units)}"
        yield Limit(text, reached, count, certain=len(beyond) > 0, abrupt=True)


def _words(values: Array, channel: int, units: Units) -> str:
    return f"{values[channel] * units.factors[channel]:.4g} {units.names[channel]}"


def _resolutions(errors: ChannelErrors, signals: Array, units: Units) -> Iterator[Limit]:
    """Steps that neither the signal nor the noise spans."""
    own = signals[:, : len(errors.white)]
    moves = np.ptp(own, axis=0)
    for element in dict.fromkeys(errors.elements):
        coarse = [
            k
            for k, name in enumerate(errors.elements)
            if name == element and moves[k] + 2.0 * errors.white[k] < errors.resolutions[k]
        ]
        if coarse:
            k = coarse[0]
            yield Limit(
                f"{element}: its resolution of {_words(errors.resolutions, k, units)} is coarser "
                "than what it measures: signal and noise stay within a step, and the error of "
                "rounding is no noise, as the linear model has it"
            )


def _jitter(errors: ChannelErrors, signals: Array, interval: float) -> Iterator[Limit]:
    """Sampling instants that err so much that their signal's slope does not tell its change."""
    if errors.time_jitter == 0.0 or len(signals) < 3:
        return
    own = signals[:, : len(errors.white)]
    slope = np.sqrt(np.mean(np.gradient(own, axis=0) ** 2, axis=0))
    bend = np.sqrt(np.mean(np.diff(own, 2, axis=0) ** 2, axis=0))
    if np.any(0.5 * bend * errors.time_jitter / interval > _SECOND_ORDER * slope):
        yield Limit(
            "time_jitter: between samples the signals bend as much as they rise, and its effect is "
            "modelled to first order only; raise `sensors.rate`"
        )


def _flicker(errors: ChannelErrors, samples: int) -> Iterator[Limit]:
    if samples < _FLICKER_SAMPLES and any(
        bias_instability.TERM.name in p.terms for p in errors.processes
    ):
        yield Limit(
            f"bias_instability: a run of {samples} samples is too short for the model of flicker "
            f"noise, which is accurate from five samples to a tenth of the run; it needs "
            f"{_FLICKER_SAMPLES}"
        )


def rate_limits(beyond: Array, rate: float, channels: tuple[str, ...]) -> Iterator[Limit]:
    """Signals with power ``beyond`` (c,), a share, half the sampling ``rate`` (Hz)."""
    worst = int(np.argmax(beyond))
    if beyond[worst] > _BEYOND_RATE:
        yield Limit(
            f"sensors.rate: {beyond[worst]:.0%} of the power of the {channels[worst]} lies above "
            f"{0.5 * rate:.4g} Hz, half the sampling rate, and is lost or folded"
        )


def duration_limits(duration: float) -> Iterator[Limit]:
    """A drive in space that is longer (s) than its frame holds."""
    if duration > _LEVEL_FRAME:
        yield Limit(
            f"the drive lasts {duration / 60.0:.3g} min: the level frame neither turns nor curves "
            f"with the earth, which holds for minutes; {_of_a_tilt(duration)}"
        )


def _of_a_tilt(duration: float) -> str:
    """What a level frame makes of a constant tilt, beside the round earth (Schuler)."""
    from mcsim.simulation.attitude_drift import SCHULER_PERIOD, TILT, excess

    if duration > 0.5 * SCHULER_PERIOD:
        return "an error of tilt would grow no further on the round earth"
    return f"it makes {excess(TILT, duration):.0%} too much of an error of tilt"


def tilt_limits(tilt: float) -> Iterator[Limit]:
    """A levelling whose offsets (1 σ, rad) are beyond small angles."""
    if tilt > SMALL_TILT:
        yield Limit(
            f"levelling: offsets of the accelerometer tilt the attitude by {np.degrees(tilt):.3g}° "
            "(one standard deviation), beyond small angles: the linear model and the budget "
            "underestimate"
        )


def pitch_limits(pitch: Array, ends: Array, deviation: float) -> Iterator[Limit]:
    """A true pitch (n,) or reconstructed ones at the end (r,), in rad, near 90°.

    ``deviation`` is that of the pitch at the end by the linear model.
    """
    if np.max(np.abs(pitch)) + _WIDE * deviation < STEEP_PITCH:
        return
    steep = int(np.sum(np.abs(ends) > STEEP_PITCH))
    certain = bool(np.max(np.abs(pitch)) > STEEP_PITCH)
    text = ""
    if steep or certain:
        text = (
            f"pitch: beyond 85° in {steep:,} of {len(ends):,} realizations at the end"
            + (", and on the true drive" if certain else "")
            + ": roll and heading merge there, and their errors say little"
        )
    yield Limit(text, steep, len(ends), certain, abrupt=True)


def angle_limits(
    names: tuple[str, ...], angles: tuple[str, ...], centre: Array, deviation: Array
) -> Iterator[Limit]:
    """Angles whose errors wrap at half a turn; ``centre`` and ``deviation`` (e,) of all errors."""
    for name in angles:
        k = names.index(name)
        if not may_wrap(centre[k], deviation[k]):
            continue
        from scipy.special import ndtr

        below, above = (np.array([-np.pi, np.pi]) - centre[k]) / deviation[k]
        share = float(ndtr(below) + ndtr(-above))
        if share > 1e-3:
            yield Limit(
                f"{name}: errors wrap at ±180°, by the linear model in {share:.1%} of all "
                "realizations; mean and RMS say little"
            )


def passing(bound: float, centre: float, deviation: float) -> float:
    """Probability that a normal quantity lies beyond plus or minus ``bound``, if it may at all."""
    if abs(centre) + _WIDE * deviation < bound:
        return 0.0
    from scipy.special import ndtr

    if deviation == 0.0:
        return 1.0
    return float(ndtr(-(bound - centre) / deviation) + ndtr(-(bound + centre) / deviation))


def may_wrap(centre: float, deviation: float) -> bool:
    """Whether an angle's error may lie beyond half a turn in any realization."""
    return bool(abs(centre) + _WIDE * deviation > np.pi)
