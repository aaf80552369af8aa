"""``sensor.yaml``: what was found, in the words of a scenario's sensor block."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from io import StringIO
from typing import Any

import numpy as np

from mcsim.characterisation.analysis import ChannelResult, Characterisation
from mcsim.characterisation.bias import BiasTracking
from mcsim.characterisation.coefficients import Coefficient
from mcsim.characterisation.comparison import DECIDES
from mcsim.characterisation.fit import NoiseFit
from mcsim.characterisation.problem import TERMS
from mcsim.characterisation.process import GaussMarkovFit
from mcsim.logs.model import ACCELEROMETER, GYROSCOPE
from mcsim.units import KINDS, density_from_random_walk, in_unit
from mcsim.version import __version__

#: Per element and term: key of the sensor block, kind of quantity, unit that is written.
KEYS = {
    ACCELEROMETER: {
        "N": ("velocity_random_walk", "velocity random walk", "m/s/√h"),
        "B": ("bias_instability", "acceleration", "m/s/h"),
        "K": ("acceleration_random_walk", "acceleration random walk", "m/s/h^1.5"),
    },
    GYROSCOPE: {
        "N": ("angle_random_walk", "angle random walk", "°/√h"),
        "B": ("bias_instability", "angular rate", "°/h"),
        "K": ("rate_random_walk", "rate random walk", "°/h^1.5"),
    },
}
#: Kind and unit of a sample, and of a one-sided noise density.
SAMPLE = {ACCELEROMETER: ("acceleration", "m/s²"), GYROSCOPE: ("angular rate", "°/s")}
DENSITY = {
    ACCELEROMETER: ("acceleration noise density", "µg/√Hz"),
    GYROSCOPE: ("angular rate noise density", "°/s/√Hz"),
}
CONVENTION = (
    "Allan's N (velocity_random_walk, angle_random_walk) belongs to a two-sided density: one "
    "sample at rate fs has the variance N² fs. A data sheet's one-sided noise density is √2 N. "
    "The Allan deviation's floor is 0.664 B."
)


def written(value: float, unit: str, kind: str) -> str:
    """An SI value with its unit, to six digits."""
    return f"{in_unit(value, unit, KINDS[kind]):.6g} {unit}"


def sensor_file(found: Characterisation) -> str:
    """The YAML text of a characterised log."""
    log = found.log
    confidence = f"{found.settings.confidence:.6g}"
    document: dict[str, Any] = {
        "description": f"characterised from {log.path.name}",
        "origin": "measured",
        "source": f"static log {log.path.name}, {log.duration:.6g} s at {log.rate:.6g} Hz",
    }
    for element in KEYS:
        results = found.of(element)
        if results:
            document[element] = _element(element, results, log.rate)
    document["fit"] = {
        "confidence": float(confidence),
        "intervals": found.settings.intervals,
        **{result.channel.name: _fit_details(result) for result in found.channels},
        "findings": [f"{f.channel}: {f.text}" if f.channel else f.text for f in found.findings],
    }
    return _text(
        document,
        [
            CONVENTION,
            "Values of an element are root mean squares over its axes; a term that an axis does "
            "not show counts as 0 there. `fit` holds the intervals and what was found.",
        ],
    )


def _element(element: str, results: list[ChannelResult], rate: float) -> dict[str, Any]:
    per_axis = [_found_terms(result.fit) for result in results]
    means = _root_mean_squares(per_axis)
    block = _terms(element, means)
    kind, unit = SAMPLE[element]
    steps = [r.inspection.resolution for r in results if r.inspection.resolution is not None]
    if steps:
        block["resolution"] = written(max(steps), unit, kind)
    block["rate"] = f"{rate:.6g} Hz"
    # A term that another axis has is written as zero: absent, it would be that of all axes.
    none = {term: means["Tc"] if term == "Tc" else 0.0 for term in means}
    block["axes"] = {
        result.channel.axis: _terms(element, {**none, **terms})
        for result, terms in zip(results, per_axis, strict=True)
    }
    return block


def _found_terms(fit: NoiseFit) -> dict[str, float]:
    """N, B and K as fitted together; with a Gauss-Markov bias its σ and Tc beside what is left.

    Also those whose interval includes zero: without them the others would not make the curve.
    """
    process = fit.gauss_markov
    if process is not None:
        found = {name: process.coefficient(TERMS.index(name)) for name in ("B", "K")}
        found |= {
            "N": fit["N"].value,
            "σ": process.model.deviation,
            "Tc": process.model.correlation_time,
        }
        return {term: value for term, value in found.items() if value > 0.0}
    return {term: fit[term].value for term in ("N", "B", "K") if fit[term].value > 0.0}


def _root_mean_squares(axes: Iterable[Mapping[str, float]]) -> dict[str, float]:
    """Of each term over all axes; an axis without the term counts as 0.

    Correlation times are averaged on the logarithmic axis, over the axes that have one.
    """
    axes = list(axes)
    terms = [term for term in ("N", "B", "K", "σ") if any(term in axis for axis in axes)]
    means = {
        term: float(np.sqrt(np.mean([axis.get(term, 0.0) ** 2 for axis in axes]))) for term in terms
    }
    times = [axis["Tc"] for axis in axes if "Tc" in axis]
    return means | ({"Tc": float(np.exp(np.mean(np.log(times))))} if times else {})


def _terms(element: str, terms: Mapping[str, float]) -> dict[str, Any]:
    block: dict[str, Any] = {}
    for term, (key, kind, unit) in KEYS[element].items():
        if term in terms:
            block[key] = written(terms[term], unit, kind)
    if "Tc" in terms:
        kind, unit = SAMPLE[element]
        block["gauss_markov"] = {
            "deviation": written(terms["σ"], unit, kind),
            "correlation_time": f"{terms['Tc']:.6g} s",
        }
    return block


def _fit_details(result: ChannelResult) -> dict[str, Any]:
    element, fit = result.channel.element, result.fit
    details: dict[str, Any] = {
        "cluster_times": f"{fit.tau_from:.4g} s to {fit.tau_to:.4g} s",
        "chi_square": f"{fit.chi_square:.3g} of {fit.times} cluster times",
        "model_error": f"{100 * fit.model_error:.2g} % of the Allan variance",
    }
    for term, (key, kind, unit) in KEYS[element].items():
        details[key] = _interval(fit[term], unit, kind)
    kind, unit = DENSITY[element]
    density = density_from_random_walk
    details["one_sided_noise_density"] = written(density(fit["N"].value), unit, kind)
    details["one_sided_noise_density_from_spectrum"] = written(density(result.floor), unit, kind)
    details |= _other_terms(element, fit)
    details |= _comparison_details(element, fit)
    if result.bias is not None:
        details["bias_tracking"] = _bias_details(element, result.bias, fit)
    return details


def _comparison_details(element: str, fit: NoiseFit) -> dict[str, Any]:
    """The best model with a Gauss-Markov bias, and what the log can tell of it."""
    found: dict[str, Any] = {}
    model, alike = fit.comparison.process, fit.comparison.shortest_alike
    if model is not None:
        kind, unit = SAMPLE[element]
        found["with_gauss_markov_bias"] = {
            "correlation_time": f"{model.model.correlation_time:.4g} s",
            **_process_interval(model, "correlation_time_interval"),
            "deviation": written(model.model.deviation, unit, kind),
            **_deviation_interval(model, unit, kind),
            "chi_square": f"{model.chi_square:.3g} of {fit.times} cluster times",
            "akaike_gain": f"{fit.comparison.gain:.3g} (decides above {DECIDES:g})",
        }
    if alike is not None and fit.gauss_markov is None and fit["K"].seen:
        found["random_walk_or"] = f"Gauss-Markov bias with a correlation time above {alike:.3g} s"
    return found


def _process_interval(model: GaussMarkovFit, key: str) -> dict[str, str]:
    """Of the correlation time; nothing where the process is not worth one."""
    if math.isinf(model.deviation_high):
        return {}
    if math.isinf(model.time_high):
        return {key: f"above {model.time_low:.4g} s"}
    return {key: f"{model.time_low:.4g} s to {model.time_high:.4g} s"}


def _deviation_interval(model: GaussMarkovFit, unit: str, kind: str) -> dict[str, str]:
    if math.isinf(model.deviation_high):
        return {}
    ends = (written(x, unit, kind) for x in (model.deviation_low, model.deviation_high))
    return {"deviation_interval": " to ".join(ends)}


def _interval(coefficient: Coefficient, unit: str, kind: str) -> str:
    low, high = (written(v, unit, kind) for v in (coefficient.low, coefficient.high))
    if not coefficient.value:
        return f"not seen; below {high}"
    if not coefficient.seen:
        return f"{written(coefficient.value, unit, kind)}, uncertain; below {high}"
    return f"{written(coefficient.value, unit, kind)}, between {low} and {high}"


def _other_terms(element: str, fit: NoiseFit) -> dict[str, str]:
    """Quantisation and ramp, where the data demand them; in SI units (Q with a further s)."""
    base = "m/s" if element == ACCELEROMETER else "rad"
    found = {}
    if "Q" in fit.coefficients:
        c = fit["Q"]
        found["quantisation_noise"] = (
            f"{c.value:.4g} {base}, between {c.low:.4g} and {c.high:.4g} {base}"
        )
    if "R" in fit.coefficients:
        found["rate_ramp"] = f"{ramp(element, fit['R'])}; a sensor block has no ramp"
    if fit.memory:
        found["filter_memory"] = f"{fit.memory:.3g} s (the output is low-passed, held or averaged)"
    return found


def ramp(element: str, c: Coefficient) -> str:
    """A ramp with its interval, per second and per hour."""
    kind, unit = SAMPLE[element]
    si = "rad/s²" if element == GYROSCOPE else "m/s³"
    hourly = f"{in_unit(3600.0 * c.value, unit, KINDS[kind]):.3g} {unit} per hour"
    return f"{c.value:.4g} {si}, between {c.low:.4g} and {c.high:.4g} {si} ({hourly})"


def _bias_details(element: str, bias: BiasTracking, fit: NoiseFit) -> dict[str, str]:
    """What tracking leaves of the bias; by the fitted process, or by a stand-in without one."""
    kind, unit = SAMPLE[element]
    fitted = fit.gauss_markov is not None
    return {
        "model": "the fit's Gauss-Markov bias"
        if fitted
        else "a stand-in from the autocorrelation: the fit has no Gauss-Markov bias",
        "correlation_time": f"{bias.model.correlation_time:.4g} s",
        "deviation": written(bias.model.deviation, unit, kind),
        "moving_average": f"{bias.smoothing:.4g} s",
        "kalman_rmse": written(bias.kalman_expected, unit, kind),
        "mean_rmse": written(bias.mean_expected, unit, kind),
        "mean_over": f"{bias.mean_length:.4g} s",
        "kalman_rms_from_smoothed_log": written(bias.kalman_measured, unit, kind),
        "mean_rms_from_smoothed_log": written(bias.mean_measured, unit, kind),
    }


def _text(document: Mapping[str, Any], comments: list[str]) -> str:
    from textwrap import wrap

    from ruamel.yaml import YAML

    yaml = YAML()
    yaml.width = 4096
    stream = StringIO()
    yaml.dump(dict(document), stream)
    head = [f"Written by mcsim {__version__}.", *(line for c in comments for line in wrap(c, 90))]
    return "".join(f"# {line}\n" for line in head) + "\n" + stream.getvalue()
