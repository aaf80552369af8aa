"""Words and signs of figures: labels of paths, errors and statistics."""

from __future__ import annotations

from mcsim.scenario.axes import Axis, Value
from mcsim.scenario.error_quantities import ERROR_QUANTITIES, SIGNS
from mcsim.statistics import Statistic

_WORDS = {
    "sensors.rate": "sampling rate",
    "sensors.time.interval_jitter": "jitter of the samples",
    "sensors.time.stamp_jitter": "jitter of the time stamps",
    "reconstruction.intervals": "intervals",
    "trajectory.length": "track length L",
    "trajectory.width": "track width D",
    "trajectory.speed": "speed",
    "trajectory.deceleration": "deceleration",
    "sensors.temperature.on_before": "time since switching on",
    "sensors.temperature.warm_up": "warm-up",
}


def path_words(path: str) -> str:
    """``sensors.accelerometer.noise_density`` as words: ``accelerometer noise density``."""
    if path in _WORDS:
        return _WORDS[path]
    block, _, rest = path.partition(".")
    words = rest if block in ("sensors", "trajectory", "monte_carlo") else path
    return words.replace(".", " ").replace("_", " ")


def unit_sign(unit: str) -> str:
    """A unit as print shows it: ``m/s²`` for ``m/s^2``."""
    return unit.replace("^2", "²").replace("sqrt(Hz)", "√Hz").replace("deg", "°")


def axis_label(axis: Axis) -> str:
    """Label of a swept quantity, with its unit."""
    words = path_words(axis.path)
    return f"{words} [{unit_sign(axis.unit)}]" if axis.unit else words


def value_label(axis: Axis, value: Value) -> str:
    """One value of a swept quantity, with its unit."""
    if isinstance(value, float):
        text = f"{value:.4g}"
        return f"{text} {unit_sign(axis.unit)}" if axis.unit else text
    return str(value)


def error_label(errors: tuple[str, ...], statistic: Statistic, unit: str) -> str:
    """Label of a vertical axis."""
    name = ERROR_QUANTITIES[errors[0]].words if len(errors) == 1 else "error"
    return f"{name}, {statistic.words} [{SIGNS[unit]}]"


def error_words(error: str) -> str:
    """The name of an error."""
    return ERROR_QUANTITIES[error].words


def confidence_words(sigmas: float) -> str:
    """The confidence of intervals: ``3σ``."""
    return f"{sigmas:.3g}σ"
