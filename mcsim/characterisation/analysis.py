"""From a static log to everything that is said about its sensor."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import (
    AllanCurve,
    allan_curve,
    degrees_of_freedom,
    intervals,
)
from mcsim.characterisation.bias import BiasTracking, analyse_bias
from mcsim.characterisation.findings import Inspection, check_length, inspect
from mcsim.characterisation.fit import Intervals, NoiseFit, fit_noise
from mcsim.characterisation.health import Finding
from mcsim.characterisation.peak_rule import find_peak
from mcsim.characterisation.spectrum import white_floor
from mcsim.errors import InputError
from mcsim.logs.model import ACCELEROMETER, AXES, GYROSCOPE, Channel, Log

Array = NDArray[np.float64]

#: Spectrum and Allan fit may differ by this part in N before it is worth a word.
_FLAT = 0.05
#: A correlation time beyond this part of the log says more about the log than the sensor.
_OWN_TIME = 0.02


@dataclass(frozen=True)
class Settings:
    """How to analyse.

    ``estimator`` of the reported curve, ``fit_range`` in s, ``confidence`` as probability,
    ``intervals`` of the fitted coefficients.
    """

    estimator: Literal["overlapping", "non-overlapping"] = "overlapping"
    fit_range: tuple[float, float] | None = None
    confidence: float = 0.95
    intervals: Intervals = "bootstrap"


@dataclass(frozen=True)
class ChannelResult:
    """One axis: ``curve`` is that of the log as recorded, with its interval (k,) each.

    ``fitted`` is the overlapping curve without spikes and lines, to which ``fit``
    belongs; ``floor`` is Allan's N from the flat part of the spectrum.
    """

    inspection: Inspection
    curve: AllanCurve
    low: Array
    high: Array
    fitted: AllanCurve
    fit: NoiseFit
    floor: float
    bias: BiasTracking | None

    @property
    def channel(self) -> Channel:
        return self.inspection.channel


@dataclass(frozen=True)
class Characterisation:
    """All channels of a log, in the order accelerometer, gyroscope, x, y, z."""

    log: Log
    settings: Settings
    channels: tuple[ChannelResult, ...]
    findings: tuple[Finding, ...]

    def of(self, element: str) -> list[ChannelResult]:
        """The channels of an accelerometer or a gyroscope."""
        return [result for result in self.channels if result.channel.element == element]


def characterise(
    log: Log, settings: Settings | None = None, step: Callable[[str], None] = lambda _: None
) -> Characterisation:
    """Analyse a static log, its channels at the same time; ``step`` is told what is being done.

    Raises
    ------
    InputError
        The log is too short, moves, or holds a constant channel, or nothing lies in the
        range of the fit.
    """
    settings = settings or Settings()
    check_length(log)
    for channel in log.channels:
        step(f"{channel.name}: {len(channel.samples):,} samples")
    with ThreadPoolExecutor(min(len(log.channels), os.cpu_count() or 1)) as pool:
        results = list(pool.map(lambda channel: _analyse(channel, log, settings), log.channels))
    return Characterisation(
        log, settings, tuple(results), (*_of_log(log), *_of_channels(results, log.duration))
    )


def _analyse(channel: Channel, log: Log, settings: Settings) -> ChannelResult:
    where, rate = str(log.path), log.rate
    seen = inspect(channel, rate, where)
    overlapping = allan_curve(channel.samples, rate)
    changed = seen.samples is not channel.samples
    fitted = allan_curve(seen.samples, rate) if changed else overlapping
    try:
        fit = fit_noise(fitted, settings.fit_range, settings.confidence, settings.intervals)
    except ValueError as error:
        raise InputError(f"{where}: {channel.name}: {error}") from None
    curve = overlapping
    if settings.estimator == "non-overlapping":
        curve = allan_curve(channel.samples, rate, overlapping.factors, overlapping=False)
    degrees = degrees_of_freedom(curve, np.maximum(fit.squares, 0.0))
    low, high = intervals(curve, degrees, settings.confidence)
    return ChannelResult(
        seen, curve, low, high, fitted, fit, white_floor(seen.spectrum), _bias(seen, rate, fit)
    )


def _bias(seen: Inspection, rate: float, fit: NoiseFit) -> BiasTracking | None:
    """Of the fitted process, if any; None where no bias, or a ramp alone, stands out."""
    process = fit.gauss_markov
    if process is None and "R" in fit.coefficients:
        return None
    try:
        return analyse_bias(
            seen.samples, rate, fit["N"].value, process.model if process is not None else None
        )
    except InputError:
        return None


def _of_log(log: Log) -> list[Finding]:
    found = [Finding("log", "", note) for note in log.notes]
    found += [Finding("remark", "", remark) for remark in log.remarks]
    longest = log.duration / 9.0
    found.append(
        Finding(
            "length",
            "",
            f"{_duration(log.duration)} at {log.rate:.6g} Hz: clusters up to {longest:.3g} s are "
            "known to 25 % or better (nine of them, Eq. 3.24)",
        )
    )
    elements = {channel.element for channel in log.channels}
    if len(log.channels) == 1:
        found.append(Finding("channels", "", f"one channel only: {log.channels[0].name}"))
    for element in (ACCELEROMETER, GYROSCOPE):
        axes = [channel.axis for channel in log.channels if channel.element == element]
        if element in elements and len(axes) < len(AXES) and len(log.channels) > 1:
            found.append(Finding("channels", "", f"{element}: axes {', '.join(axes)} only"))
    if GYROSCOPE in elements:
        found.append(
            Finding("units", "", "the gyroscope's unit is as stated: rest cannot tell ° from rad")
        )
    return found


def _of_channels(results: list[ChannelResult], duration: float) -> list[Finding]:
    found: list[Finding] = []
    for result in results:
        found += [*result.inspection.findings, *_of_fit(result, duration)]
    return found


def _of_fit(result: ChannelResult, duration: float) -> list[Finding]:
    """What shows only after the fit: spectrum, bandwidth, and a bias that never repeats."""
    name, fit, bias = result.channel.name, result.fit, result.bias
    found = []
    ratio = result.floor / fit["N"].value if fit["N"].value else 1.0
    if abs(ratio - 1.0) > max(_FLAT, 1.5 * (fit["N"].high - fit["N"].low) / fit["N"].value):
        text = (
            f"the spectrum's floor (1/50 to 2/5 of the rate) gives an N {ratio - 1.0:+.0%} from "
            "that of the fit: the noise is not white up to there (filter, aliasing)"
        )
        found.append(Finding("spectrum", name, text))
    if fit.tau_from > 1.5 * result.fitted.interval and not fit.stated_range:
        text = (
            f"clusters below {fit.tau_from:.3g} s do not follow the model (filter, values held, "
            f"coloured noise): the fit begins there, and N is that of low frequencies"
        )
        found.append(Finding("bandwidth", name, text))
    if "R" in fit.coefficients:
        found.append(Finding("ramp", name, _ramp(result, duration)))
    if fit.gauss_markov is not None:
        found.append(Finding("peak", name, _peak(result)))
    slow = bias is not None and bias.model.correlation_time > _OWN_TIME * duration
    if bias is not None and slow and fit.gauss_markov is None:
        text = (
            f"the autocorrelation falls to 1/e after {bias.model.correlation_time:.3g} s, more "
            f"than {_OWN_TIME:.0%} of the log: flicker, a random walk or a drift rather than a "
            "Gauss-Markov bias"
        )
        found.append(Finding("bias", name, text))
    return found


def _peak(result: ChannelResult) -> str:
    """What the thesis' peak rule reads off the curve, beside the fitted process."""
    from mcsim.characterisation.sensor_file import SAMPLE, written

    process = result.fit.gauss_markov
    assert process is not None
    kind, unit = SAMPLE[result.channel.element]
    fitted = f"{process.model.correlation_time:.3g} s"
    peak = find_peak(result.fitted.tau, result.fitted.variance, result.fit["N"].value)
    if peak is None:
        return f"no peak stands out of the Allan deviation; the fit has a Tc of {fitted}"
    return (
        f"the Allan deviation less its white noise peaks at {peak.tau:.3g} s: by the peak rule "
        f"(τ/1.89, σ/(0.437 √Tc)) Tc {peak.correlation_time:.3g} s and a deviation of "
        f"{written(peak.model.deviation, unit, kind)}; by the fit {fitted} and "
        f"{written(process.model.deviation, unit, kind)}"
    )


def _ramp(result: ChannelResult, duration: float) -> str:
    from mcsim.characterisation.sensor_file import ramp

    c = result.fit["R"]
    return (
        f"the output drifts by a ramp R of {ramp(result.channel.element, c)}, "
        f"{duration:.4g} s long; a scenario has no ramp: sensor.yaml names it, and its noise "
        "terms are those beside it"
    )


def _duration(seconds: float) -> str:
    return f"{seconds / 3600.0:.3g} h" if seconds >= 3600.0 else f"{seconds:.4g} s"
