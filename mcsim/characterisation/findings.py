"""What is wrong with a log: looked for before anything is fitted, and named."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.health import CHECKS, Finding, Record
from mcsim.characterisation.health.oscillation import find_oscillations, oscillation_finding
from mcsim.characterisation.health.record import SHORTEST
from mcsim.characterisation.health.warm_up import WarmUp, check_warm_up
from mcsim.characterisation.spectrum import (
    Line,
    Spectrum,
    find_lines,
    spectrum_of,
    without_lines,
)
from mcsim.errors import InputError
from mcsim.logs.model import ACCELEROMETER, KIND, Channel, Log

Array = NDArray[np.float64]

_FEWEST_SAMPLES = 1000
#: Samples that stand out by more robust standard deviations are outliers; no Gaussian
#: log of any length reaches this.
_OUTLIER = 7.0
#: Values that a robust deviation is taken of, at most twice as many.
_ENOUGH = 1 << 20
#: Runs of outliers up to so many samples are spikes; longer ones are no longer isolated.
_LONGEST_SPIKE = 5
#: More outliers than this part are no spikes: the noise itself is not Gaussian.
_MOST_SPIKES = 1e-3
#: Lines that raise the Allan deviation by more than this part are taken out.
_RAISES = 0.01
#: Windows that tell rest from handling (s, samples), and what they may differ by.
_WINDOW, _WINDOW_SAMPLES = 1.0, 50
_LOUDER, _JUMP = 4.0, 12.0
#: The part of windows that may be disturbed, and the range of their means at rest.
_MOST_DISTURBED = 0.02
_RANGE_AT_REST = {ACCELEROMETER: 0.5, "gyroscope": np.deg2rad(3.0)}
_TURNING = np.deg2rad(20.0)
#: A slow change that rounding gives wrong by more than this part is not to be trusted.
_DISTORTED = 0.05
#: Steps smaller than this part of the noise do not show.
_FINEST_STEP = 0.02


@dataclass(frozen=True)
class Inspection:
    """A channel after the look at it: ``samples`` (n,) are free of spikes, lines and warm-up.

    ``spectrum`` and ``lines`` are of the log without its spikes and warm-up; ``resolution`` is
    the quantisation step in SI units, None where none shows; ``warm_up`` what was taken out.
    """

    channel: Channel
    samples: Array
    spectrum: Spectrum
    lines: tuple[Line, ...]
    resolution: float | None
    findings: tuple[Finding, ...]
    warm_up: WarmUp | None = None


def check_length(log: Log) -> None:
    """Refuse logs that are too short for any of this.

    Raises
    ------
    InputError
        Shorter than a minute or than 1000 samples.
    """
    n = len(log.channels[0].samples)
    if log.duration < SHORTEST or n < _FEWEST_SAMPLES:
        doubt = f" ({log.timing.doubt})" if log.timing.doubt else ""
        raise InputError(
            f"{log.path}: {n} sample{'s' * (n != 1)}, {log.duration:.4g} s: too short; at least "
            f"{SHORTEST:.0f} s and {_FEWEST_SAMPLES} samples are needed, hours for bias "
            f"instability and random walk{doubt}"
        )


def inspect(channel: Channel, rate: float, where: str) -> Inspection:
    """Look at a channel, take spikes and lines out, and say so.

    Raises
    ------
    InputError
        A constant channel, or one that moved.
    """
    name, samples = channel.name, channel.samples
    if np.ptp(samples) == 0.0:
        raise InputError(f"{where}: {name} is constant ({samples[0]:.6g}); is the sensor alive?")
    resolution = _resolution(samples)
    unit = {"acceleration": "m/s²", "angular rate": "°/s"}[KIND[channel.element]]
    clean, spikes, told = _without_spikes(samples, rate)
    record = Record(name, clean, rate, resolution, KIND[channel.element], unit, where)
    findings = [finding for check in CHECKS for finding in check(record)]
    if told:
        findings.append(Finding("spikes" if spikes else "outliers", name, told))
    findings += _check_rest(channel, clean, rate, where)
    if resolution is not None:
        findings.append(_quantisation(name, resolution, clean))
    warm_up, told_of_it = check_warm_up(record)
    findings += told_of_it
    if warm_up is not None:
        clean = clean - warm_up.output(len(clean), rate)
    oscillations, slow = find_oscillations(clean, rate)
    if oscillations:
        clean = without_lines(clean, rate, slow, oscillations)
        findings += [oscillation_finding(record, line) for line in oscillations]
    spectrum = spectrum_of(clean, rate)
    lines = find_lines(spectrum)
    strong = [line for line in lines if line.raises > 1.0 + _RAISES]
    if strong:
        clean = without_lines(clean, rate, spectrum, strong)
    findings += [_line_finding(name, line, lines, strong) for line in strong]
    every = (*oscillations, *lines)
    return Inspection(channel, clean, spectrum, every, resolution, tuple(findings), warm_up)


def _line_finding(name: str, line: Line, lines: list[Line], strong: list[Line]) -> Finding:
    weaker = len(lines) - len(strong)
    more = f" ({weaker} weaker lines stay)" if weaker and line is strong[-1] else ""
    return Finding(
        "line",
        name,
        f"a line at {line.low:.4g} … {line.high:.4g} Hz (peak {line.peak:.4g} Hz) raises the "
        f"Allan deviation by up to {line.raises - 1.0:.0%}, near {line.tau:.2g} s; "
        f"the fit goes without it{more}",
    )


def _without_spikes(samples: Array, rate: float) -> tuple[Array, int, str]:
    """Samples whose isolated outliers are replaced by the level around them."""
    level = _level(samples, rate)
    rest = samples - level
    deviation = _robust_deviation(rest)
    if deviation == 0.0:
        return samples, 0, ""
    outside = np.flatnonzero(np.abs(rest) > _OUTLIER * deviation)
    if not len(outside):
        return samples, 0, ""
    largest = float(np.max(np.abs(rest[outside]))) / deviation
    told = f"{len(outside)} samples stand out by up to {largest:.0f} σ"
    if len(outside) > _MOST_SPIKES * len(samples):
        return samples, 0, f"{told}: too many for spikes, they stay; the noise is not Gaussian"
    runs = np.split(outside, np.flatnonzero(np.diff(outside) > 1) + 1)
    isolated = [run for run in runs if len(run) <= _LONGEST_SPIKE]
    if not isolated:
        return samples, 0, ""
    clean = samples.copy()
    places = np.concatenate(isolated)
    clean[places] = level[places]
    return clean, len(places), f"{told}; the fit goes without {len(isolated)} isolated spikes"


def _level(samples: Array, rate: float) -> Array:
    """Medians of windows, interpolated between their middles; (n,)."""
    size = _window(rate, len(samples))
    count = len(samples) // size
    medians = np.median(samples[: count * size].reshape(count, size), axis=1)
    middles = (np.arange(count) + 0.5) * size
    return np.interp(np.arange(len(samples)), middles, medians)


def _robust_deviation(values: Array) -> float:
    """1.4826 times the median absolute deviation; where coarse steps leave none, the RMS."""
    # So many values know it to a part in a thousand.
    values = values[:: max(1, len(values) // _ENOUGH)]
    deviation = 1.4826 * float(np.median(np.abs(values)))
    # A quantised log has few distinct values: its median may lie a step off.
    spread = float(np.subtract(*np.percentile(values, [90.0, 10.0]))) / 2.563
    return max(deviation, spread)


def _window(rate: float, n: int) -> int:
    return int(min(max(_WINDOW * rate, _WINDOW_SAMPLES), n // 8))


def _check_rest(channel: Channel, samples: Array, rate: float, where: str) -> list[Finding]:
    size = _window(rate, len(samples))
    count = len(samples) // size
    windows = samples[: count * size].reshape(count, size)
    means, deviations = windows.mean(axis=1), windows.std(axis=1)
    seconds = size / rate
    if channel.element != ACCELEROMETER and abs(float(np.median(means))) > _TURNING:
        raise InputError(
            f"{where}: {channel.name} turns at {np.rad2deg(np.median(means)):.4g} °/s on average: "
            "not at rest, or its unit is wrong"
        )
    steps = np.abs(np.diff(means))
    usual_step = max(_robust_deviation(np.diff(means)), 1e-300)
    moved = deviations > _LOUDER * np.median(deviations)
    moved[1:] |= steps > _JUMP * usual_step
    limit = _RANGE_AT_REST[channel.element]
    # Means of windows wander at rest, but not as far as this.
    far = np.abs(means - np.median(means)) > limit
    if np.any(far) or moved.mean() > _MOST_DISTURBED:
        raise InputError(_moving(channel.name, moved | far, seconds, where))
    if not np.any(moved):
        return []
    first = float(np.argmax(moved)) * seconds
    return [
        Finding(
            "handling",
            channel.name,
            f"{np.count_nonzero(moved)} of {count} windows of {seconds:.3g} s are disturbed "
            f"(handling or shock), the first {first:.6g} s into the log; they stay in the fit",
        )
    ]


def _moving(name: str, moved: NDArray[np.bool_], seconds: float, where: str) -> str:
    edges = np.flatnonzero(np.diff(np.concatenate([[True], moved, [True]]).astype(int)))
    quiet = edges.reshape(-1, 2) if len(edges) else np.zeros((0, 2), int)
    told = f"{where}: {name} moves or is handled: first {np.argmax(moved) * seconds:.4g} s in"
    if len(quiet):
        begin, end = quiet[np.argmax(quiet[:, 1] - quiet[:, 0])] * seconds
        if end - begin >= SHORTEST:
            return f"{told}; at rest from --start {begin:.6g} to --end {end:.6g} (s)"
    return f"{told}, {moved.mean():.0%} of the log; a static log is needed"


def _resolution(samples: Array) -> float | None:
    """The step that all values are multiples of apart, if it is coarse enough to show."""
    values = np.unique(samples[: 1 << 17])
    if len(values) < 2:
        return None
    steps = np.diff(values)
    noise = float(np.std(samples))
    # Rounded decimals make steps of slightly different size.
    coarse = steps[steps > 1e-6 * noise]
    if not len(coarse) or np.min(coarse) < _FINEST_STEP * noise:
        return None
    step = float(np.median(coarse[coarse < 1.5 * np.min(coarse)]))
    multiples = coarse / step
    if np.mean(np.abs(multiples - np.round(multiples)) < 0.05 * np.maximum(multiples, 1)) < 0.95:
        return None
    return step


def _quantisation(name: str, step: float, samples: Array) -> Finding:
    """What rounding does to Gaussian noise of the deviation that is left of it.

    Rounding adds Δ²/12, which N holds; besides, the mean of the output depends on where between
    two steps the input lies, by up to Δ/π exp(-2 π² σ²/Δ²) (Widrow's theorem): a share of any
    slow change that is lost or doubled.
    """
    noise = float(np.std(samples))
    own = float(np.sqrt(max(noise**2 - step**2 / 12.0, (0.1 * step) ** 2)))
    added = 1.0 - own / noise
    # The largest slope of the mean output against the input, less one.
    distortion = 2.0 * float(np.exp(-2.0 * (np.pi * own / step) ** 2))
    coarse = distortion > _DISTORTED
    effect = (
        f"slow changes come out wrong by up to {distortion:.2g} of their size: B, K and a ramp "
        "are not to be trusted, and the noise depends on where between two steps the output lies"
        if coarse
        else f"the noise carries slow changes over them to within {max(distortion, 1e-3):.1g}"
    )
    if added > 0.005:
        effect += f"; rounding itself makes {added:.1%} of the noise"
    return Finding(
        "coarse" if coarse else "quantisation", name, f"steps of {step / noise:.2g} σ: {effect}"
    )
