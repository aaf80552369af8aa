"""Keys that a scenario writes and that change nothing: each is told, with the reason."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations, product
from typing import TYPE_CHECKING, Any

from mcsim.scenario.document import get_path
from mcsim.scenario.idle import IdleKey
from mcsim.scenario.paths import split_path
from mcsim.sensor_terms import TERMS, temperature
from mcsim.sensor_terms.channel import SIGNALS
from mcsim.systems import SYSTEMS
from mcsim.tracks import idle_keys

if TYPE_CHECKING:
    from mcsim.scenario_file.scenario import Scenario


def _beside_linear(key: str, reason: str) -> IdleKey:
    return IdleKey(
        f"monte_carlo.{key}",
        ("monte_carlo.estimator",),
        lambda model: model.monte_carlo.estimator == "linear",
        reason,
    )


def _off(element: str, block: str, deciding: str, idle: str) -> IdleKey:
    """A key of a block of ``element`` whose other key is zero."""

    def off(model: Any) -> bool:
        own = getattr(getattr(getattr(model, "sensors", None), element, None), block, None)
        values = getattr(own, deciding, None)
        return values is not None and not any(values if isinstance(values, tuple) else (values,))

    path = f"sensors.{element}.{block}"
    return IdleKey(f"{path}.{idle}", (f"{path}.{deciding}",), off, f"`{path}.{deciding}` is zero")


def of_terms() -> Iterator[IdleKey]:
    """Keys within sensor terms that are written beside a zero."""
    for element, term in product(SIGNALS, TERMS.values()):
        for scale, key in permutations(term.keys(element), 2):
            if term.inner and scale.scales:
                yield _off(element, term.inner.key, scale.name, key.name)


def _sensors_of(model: Any) -> Any:
    """The block of the sensors, whatever the case calls it."""
    return getattr(model, "sensors", None) or getattr(model, "sensor", None)


def _is_even(model: Any) -> bool:
    """Whether no sampling interval varies."""
    times = getattr(_sensors_of(model), "time", None)
    return times is not None and not times.varies


def _no_temperature(model: Any) -> bool:
    return getattr(_sensors_of(model), "temperature", None) is None


def _no_term_of_temperature(model: Any) -> bool:
    blocks = [getattr(_sensors_of(model), element, None) for element in SIGNALS]
    return not any(b and b.values_of(term) for b in blocks for term in temperature.TERMS)


def of_temperature() -> Iterator[IdleKey]:
    """A temperature that nothing goes with, and what goes with one that is not written."""
    for block in ("sensors", "sensor"):
        elements = tuple(f"{block}.{element}" for element in SIGNALS)
        reason = "no `temperature_offset` or `temperature_scale` is written"
        yield IdleKey(f"{block}.temperature", elements, _no_term_of_temperature, reason)
        for element, term in product(SIGNALS, temperature.TERMS):
            for key in term.keys(element):
                path = f"{block}.{element}.{key.name}"
                deciding = (f"{block}.temperature",)
                yield IdleKey(path, deciding, _no_temperature, f"no `{deciding[0]}` is written")


#: Keys of blocks that several cases have, beside those of sensor terms.
COMMON: tuple[IdleKey, ...] = (
    IdleKey(
        "monte_carlo.max_realizations",
        ("monte_carlo.precision",),
        lambda model: model.monte_carlo.precision is None,
        "it ends a run to a `precision`, which is not asked for",
    ),
    _beside_linear("precision", "a linear answer has no intervals to narrow"),
    _beside_linear("confidence", "a linear answer has no intervals"),
    _beside_linear("resamples", "a linear answer has no intervals"),
    _beside_linear("offsets", "a linear answer draws no offsets"),
    IdleKey(
        "trajectory.side_slip_profile",
        ("trajectory.side_slip", "trajectory.shape"),
        lambda model: getattr(getattr(model, "trajectory", None), "side_slip", None) == 0.0,
        "`trajectory.side_slip` is zero",
    ),
    IdleKey(
        "reconstruction.intervals",
        ("sensors.time", "sensor.time"),
        _is_even,
        "no sampling interval varies",
    ),
)


def without_effect(scenario: Scenario) -> list[str]:
    """What the scenario writes without effect, one sentence each, with file and line."""
    return list(_sentences(scenario))


def _sentences(scenario: Scenario) -> Iterator[str]:
    swept = [axis.path for axis in scenario.axes]
    document = scenario.document
    of_track = idle_keys(getattr(scenario.base, "trajectory", None))
    own = (*of_terms(), *of_temperature(), *of_track, *SYSTEMS[scenario.base.case].idle)
    for rule in (*COMMON, *own):
        keys = split_path(rule.path)
        written = get_path(document.tree, keys) is not None or rule.path in swept
        decided = any(path.startswith(rule.deciding) for path in swept if path != rule.path)
        if not written or (rule.deciding and decided):
            continue
        if rule.idle(scenario.base) and not _is_default(scenario.base, rule.path):
            yield f"{document.place(keys)}: {rule.path} has no effect: {rule.reason}"
    if scenario.base.monte_carlo.common_random_numbers and not scenario.axes:
        path = "monte_carlo.common_random_numbers"
        place = document.place(split_path(path))
        yield f"{place}: {path} has no effect: nothing is swept"


def _is_default(model: Any, path: str) -> bool:
    """Whether a key is written as it would be read without it, as resolved scenarios do."""
    *blocks, name = path.split(".")
    for block in blocks:
        model = getattr(model, block, None)
    if model is None:
        return True
    return bool(getattr(model, name) == type(model).model_fields[name].default)
