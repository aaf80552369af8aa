"""What a characterisation says, in plain sentences."""

from __future__ import annotations

import numpy as np

from mcsim.characterisation.analysis import ChannelResult, Characterisation
from mcsim.characterisation.coefficients import Coefficient
from mcsim.characterisation.fit import NoiseFit
from mcsim.characterisation.problem import TERMS
from mcsim.characterisation.sensor_file import DENSITY, KEYS
from mcsim.logs.model import ACCELEROMETER
from mcsim.units import KINDS, density_from_random_walk, in_unit

NAMES = {
    ACCELEROMETER: {
        "N": "velocity random walk",
        "B": "bias instability",
        "K": "acceleration random walk",
    },
    "gyroscope": {"N": "angle random walk", "B": "bias instability", "K": "rate random walk"},
}
#: Half the interval's width, as a part of the value, that still counts as known.
_WELL, _ROUGHLY = 0.1, 0.4

#: Logs below this length (s) say little about the slow terms.
_SHORT = 3600.0
#: What is said of the channels that share a kind of finding.
_WORDS = {
    "spikes": "Isolated spikes in {}: fitted without them.",
    "outliers": "Outliers in {} that are too many to be spikes: the noise is not Gaussian.",
    "handling": "Disturbances in {}: log again, or cut them off with --start and --end.",
    "stuck": "The output of {} is stuck for a while.",
    "held": "Values of {} are held or repeated: the sensor is slower than the log.",
    "saturates": "{} saturates: N may be too small.",
    "level": "The noise of {} does not keep its level: one N is not the sensor's.",
    "warm-up": "A warm-up in {}: fitted without it; see the time from which it is over.",
    "ramp": "A ramp in {}: the output drifts steadily; no term of a sensor block stands for it.",
    "oscillation": "A slow oscillation in {}: not at rest, or not at a constant temperature; "
    "fitted without it.",
    "coarse": "Quantisation of {} is too coarse for the noise to carry slow changes over the "
    "steps: B and K are not to be trusted.",
    "quantisation": "Quantisation steps show in {}; the noise carries the signal over them.",
    "bandwidth": "Short clusters of {} do not follow the model: left out of the fit.",
    "spectrum": "The spectrum of {} is not flat up to 2/5 of the rate: a filter, or aliasing.",
    "bias": "The bias of {} has no correlation time of its own: the longer the log, the longer.",
    "process": "A Gauss-Markov bias explains {} better than bias instability and random walk: "
    "sensor.yaml has it.",
    "undecided": "Undecided on {}: a Gauss-Markov bias explains the curve as well as bias "
    "instability and random walk, which sensor.yaml has; a longer log would tell.",
    "misfit": "The model misses the curve of {} by more than 10 %.",
}


def verdict(found: Characterisation) -> list[str]:
    """A few sentences: how well each term is known, what the log lacks, what was found."""
    sentences = []
    for element in KEYS:
        results = found.of(element)
        if results:
            sentences += [_element(element, results)]
    sentences += _log_sentences(found)
    return sentences


def number(fit: NoiseFit, element: str, term: str) -> str:
    """Value and uncertainty in the sensor block's unit: ``0.0833 m/s/√h ± 0.4 %``."""
    _, kind, unit = KEYS[element][term]
    if fit.gauss_markov is not None and _is_replaced(fit, term):
        beside = fit.gauss_markov.coefficient(TERMS.index(term))
        if not beside:
            return "Gauss-Markov"
        return f"{in_unit(beside, unit, KINDS[kind]):.3g} {unit} beside Gauss-Markov"
    coefficient = fit[term]
    if not coefficient.value:
        return f"not seen (below {in_unit(coefficient.high, unit, KINDS[kind]):.3g} {unit})"
    value = f"{in_unit(coefficient.value, unit, KINDS[kind]):.3g} {unit}"
    if not coefficient.seen:
        return f"{value}, uncertain (below {in_unit(coefficient.high, unit, KINDS[kind]):.3g})"
    return f"{value} ± {_per_cent(half_width(coefficient))}"


def _is_replaced(fit: NoiseFit, term: str) -> bool:
    """Whether a Gauss-Markov bias stands for this term."""
    return fit.gauss_markov is not None and term != "N"


def half_width(coefficient: Coefficient) -> float:
    """Half the width of the interval in per cent of the value."""
    return 50.0 * (coefficient.high - coefficient.low) / coefficient.value


def _per_cent(value: float) -> str:
    return f"{value:.2g} %" if value < 99.5 else f"{value:.0f} %"


def noise_density(result: ChannelResult) -> str:
    """The one-sided noise density of a channel, as a data sheet prints it."""
    kind, unit = DENSITY[result.channel.element]
    density = density_from_random_walk(result.fit["N"].value)
    return f"{in_unit(density, unit, KINDS[kind]):.3g} {unit}"


def _element(element: str, every: list[ChannelResult]) -> str:
    """How well each term of an element is known, over the axes that are described by it."""
    parts = []
    for term, name in NAMES[element].items():
        results = [r for r in every if not _is_replaced(r.fit, term)]
        if not results:
            continue
        unseen = [r.channel.axis for r in results if not r.fit[term].seen]
        widths = [half_width(r.fit[term]) for r in results if r.fit[term].seen]
        if len(unseen) == len(results):
            parts.append(f"{name} does not clearly show in this log")
            continue
        worst = max(widths)
        known = "well known" if worst <= 100 * _WELL else "roughly known"
        if worst > 100 * _ROUGHLY:
            known = "hardly known"
        also = f"; uncertain on {', '.join(unseen)}" if unseen else ""
        parts.append(f"{name} {known} (±{_per_cent(worst)}{also})")
    return f"{element}: {', '.join(parts)}."


def _log_sentences(found: Characterisation) -> list[str]:
    sentences = [_line_sentence(found)]
    groups = {kind: [f.channel for f in found.findings if f.kind == kind] for kind in _WORDS}
    results = found.channels
    groups["process"] = [r.channel.name for r in results if r.fit.gauss_markov]
    groups["undecided"] = [r.channel.name for r in results if r.fit.comparison.is_undecided]
    groups["misfit"] = [r.channel.name for r in results if misfit(r) > _WELL]
    sentences += [
        words.format(_listed(found, groups[kind])) for kind, words in _WORDS.items() if groups[kind]
    ]
    sentences.append(_walk_sentence(found))
    if found.log.duration < _SHORT:
        sentences.append("The log is short: bias instability and random walk need hours.")
    told = [f"{f.text[0].upper()}{f.text[1:]}." for f in found.findings if f.kind == "log"]
    return [*filter(None, sentences), *told] or ["Nothing disturbs this log."]


def _listed(found: Characterisation, channels: list[str]) -> str:
    names = list(dict.fromkeys(channels))
    if 1 < len(names) == len(found.channels):
        return "all channels"
    return ", ".join(names)


def _line_sentence(found: Characterisation) -> str:
    channels = [f.channel for f in found.findings if f.kind == "line"]
    if not channels:
        return ""
    lines = (line for result in found.channels for line in result.inspection.lines)
    strongest = max(lines, key=lambda line: line.raises)
    raised = f"{strongest.peak:.3g} Hz, raise the Allan deviation by up to"
    return (
        f"Spectral lines in {_listed(found, channels)}, the strongest at {raised} "
        f"{strongest.raises - 1.0:.0%}; N, B and K are fitted without them."
    )


def _walk_sentence(found: Characterisation) -> str:
    """From which correlation time on a Gauss-Markov bias passes for the random walks found."""
    alike = {
        result.channel.name: result.fit.comparison.shortest_alike
        for result in found.channels
        if result.fit["K"].seen and not _is_replaced(result.fit, "K")
    }
    times = [time for time in alike.values() if time is not None]
    if not times:
        return ""
    return (
        f"Random walk of {_listed(found, list(alike))}: a Gauss-Markov bias with a correlation "
        f"time above {float(f'{max(times):.2g}'):g} s would look the same in this log."
    )


def misfit(result: ChannelResult) -> float:
    """Largest relative distance of curve and model where the curve is known to 5 %."""
    fit, curve = result.fit, result.fitted
    known = (curve.tau >= fit.tau_from) & (curve.tau <= fit.tau_to)
    known &= (result.high - result.low) < 0.1 * result.curve.deviation
    if not np.any(known):
        return 0.0
    ratio = curve.deviation[known] / fit.deviation(curve.tau[known])
    return float(np.max(np.abs(ratio - 1.0)))
