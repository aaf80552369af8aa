"""Options of ``mcsim.velocity``, written with units, as what the measurement needs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal, TypedDict

from mcsim.api.bounded import not_negative, positive
from mcsim.errors import InputError
from mcsim.measured_velocity.correction_file import CorrectionInput
from mcsim.measured_velocity.group import STAMPS_BELOW, TimeBase
from mcsim.measured_velocity.propagation import Inputs
from mcsim.measured_velocity.reference import Reference
from mcsim.measured_velocity.run_log import Layout
from mcsim.measured_velocity.segments import SAMPLES, STILL, Length, Rule
from mcsim.units import KINDS, STANDARD_GRAVITY, degrees

#: Gravity on the earth's surface at sea level (m/s²): what is known where nothing is stated.
_EARTH = (9.780, 9.833)
#: No vehicle's tilt changes by more (rad), and no gravity is stated worse (share).
_LARGEST_TILT, _LARGEST_SHARE = 0.2, 0.1
_ORDERS = ("first", "second", "exact")


class ReadOptions(TypedDict, total=False):
    """What the logs themselves do not say."""

    columns: str | None
    units: str | None
    run_column: str | None


class MotionOptions(TypedDict, total=False):
    """Where the motion begins and ends: ``10 s`` or ``1000 samples``."""

    rest: str | None
    duration: str | None
    still: str | None
    runs: int | None
    align: Literal["auto", "samples", "time"]


class KnownOptions(TypedDict, total=False):
    """What is known beside the runs, with units."""

    gravity: str | None
    gravity_uncertainty: str | None
    tilt_change: str | None
    unevenness: str | None
    axle_distance: str | None
    nonlinearity: str | None
    interval_uncertainty: str | None
    time_errors: Literal["independent", "stamps"] | None
    tilt_order: Literal["first", "second", "exact"] | None


class ReferenceOptions(TypedDict, total=False):
    """What the velocity is compared with."""

    columns: Sequence[str]
    files: Sequence[str | Path]
    wheel_radius: str | None
    ticks_per_turn: float | None
    uncertainty: str | None


class MonteCarloOptions(TypedDict, total=False):
    """Of the Monte Carlo."""

    draws: int | None
    seed: int


def layout_of(read: ReadOptions, reference: Reference | None) -> Layout:
    """How logs are read."""
    return Layout(read.get("columns"), read.get("units"), read.get("run_column"), reference)


def rule_of(motion: MotionOptions) -> Rule:
    """How rest and motion are told.

    Raises
    ------
    InputError
        A length that is none.
    """
    still = motion.get("still")
    return Rule(
        _length("rest", motion.get("rest")),
        _length("duration", motion.get("duration")),
        STILL if still is None else _positive("still", still, "time"),
    )


def _length(name: str, text: str | None) -> Length | None:
    if text is None:
        return None
    number, _, unit = text.strip().partition(" ")
    if unit.strip() == SAMPLES:
        if not number.isdecimal() or int(number) == 0:
            raise InputError(f'--{name}: "{text}": write a whole number, such as 1000 samples')
        return Length(float(number), samples=True)
    return Length(_positive(name, text, "time"))


def reference_of(given: ReferenceOptions) -> Reference | None:
    """The reference, if one is named.

    Raises
    ------
    InputError
        Options without a column, or quantities that are none.
    """
    columns = tuple(given.get("columns") or ())
    if not columns:
        lone = [key for key, value in given.items() if value and key != "columns"]
        if lone:
            option = "--reference-file" if lone[0] == "files" else f"--{lone[0].replace('_', '-')}"
            raise InputError(f"{option}: needs a column, --reference 'NAME in UNIT'")
        return None
    radius, ticks = given.get("wheel_radius"), given.get("ticks_per_turn")
    if ticks is not None and not 0.0 < ticks < 1e9:
        raise InputError(f"--ticks-per-turn {ticks:g}: must be above zero")
    absolute, relative = _speed_or_share(given.get("uncertainty"))
    return Reference(
        columns,
        None if radius is None else _positive("wheel-radius", radius, "length"),
        ticks,
        absolute,
        relative,
    )


def _speed_or_share(text: str | None) -> tuple[float, float]:
    if text is None:
        return 0.0, 0.0
    if text.strip().endswith(("%", "ppm")):
        return 0.0, _not_negative("reference-uncertainty", text, "ratio")
    return _not_negative("reference-uncertainty", text, "speed"), 0.0


def inputs_of(
    correction: CorrectionInput, known: KnownOptions, base: TimeBase, note: Callable[[str], None]
) -> Inputs:
    """What is known beside the runs; options go before what the calibration's file says.

    Raises
    ------
    InputError
        Quantities that are none, or options that say the same thing twice.
    """
    if (share := known.get("nonlinearity")) is not None:
        correction = correction.with_nonlinearity(_not_negative("nonlinearity", share, "ratio"))
        note(f"u(lxx) by Eq. (34): {correction.deviations[0]:.3g}")
    gravity, gravity_error = _gravity(correction, known, note)
    return Inputs(
        correction=correction,
        tilt_change=_tilt_change(correction, known, note),
        gravity=gravity,
        gravity_error=gravity_error,
        interval_error=_interval_error(known, base, note),
        stamps=_stamps_err(known, base, note),
        order=_order(correction, known),
    )


def _order(correction: CorrectionInput, known: KnownOptions) -> int:
    stated = known.get("tilt_order")
    if stated is None and correction.tilt is not None:
        stated = correction.tilt.order
    return _ORDERS.index(stated or "first")


def _gravity(
    correction: CorrectionInput, known: KnownOptions, note: Callable[[str], None]
) -> tuple[float, float]:
    stated, error = known.get("gravity"), known.get("gravity_uncertainty")
    if stated is not None:
        value = _positive("gravity", stated, "acceleration")
        u = 0.0 if error is None else _not_negative("gravity-uncertainty", error, "acceleration")
        if u > _LARGEST_SHARE * value:
            raise InputError(f"--gravity-uncertainty: {error} is no uncertainty of {stated}")
        unstated = ", as no --gravity-uncertainty is given" if error is None else ""
        note(f"g = {value:.7g} m/s², u = {u:.2g} m/s², of --gravity{unstated}")
        return value, u
    if error is not None:
        raise InputError("--gravity-uncertainty: needs --gravity")
    if correction.gravity is not None:
        g = correction.gravity
        note(f"g = {g.estimate:.7g} m/s², u = {g.uncertainty:.2g} m/s², of the calibration's file")
        return g.estimate, g.uncertainty
    u = (_EARTH[1] - _EARTH[0]) / math.sqrt(12.0)
    note(
        f"no --gravity: standard gravity, {STANDARD_GRAVITY} m/s², with u = {u:.2g} m/s², as it "
        f"varies over the earth between {_EARTH[0]} and {_EARTH[1]} m/s² (rectangular)"
    )
    return STANDARD_GRAVITY, u


def _tilt_change(
    correction: CorrectionInput, known: KnownOptions, note: Callable[[str], None]
) -> float:
    stated, step = known.get("tilt_change"), known.get("unevenness")
    distance = known.get("axle_distance")
    if stated is not None and (step is not None or distance is not None):
        raise InputError(
            "--tilt-change: says what --unevenness over --axle-distance does; keep one"
        )
    if (step is None) != (distance is None):
        raise InputError("--unevenness and --axle-distance go together: one axle rises by the "
                         "first against the other, the second away")  # fmt: skip
    if stated is not None:
        return _tilt("tilt-change", _not_negative("tilt-change", stated, "angle"))
    if step is not None and distance is not None:
        rise = _not_negative("unevenness", step, "length")
        angle = math.atan(rise / _positive("axle-distance", distance, "length"))
        note(f"u(δα) = {degrees(angle):.3g}°, {step} over {distance}")
        return _tilt("unevenness", angle)
    if correction.tilt is not None:
        u = correction.tilt.change
        note(f"u(δα) = {degrees(u):.3g}°, of the calibration's file")
        return u
    note(
        "no --tilt-change, nor --unevenness and --axle-distance: the tilt while moving counts as "
        "that at rest, u(δα) = 0"
    )
    return 0.0


def _tilt(name: str, angle: float) -> float:
    if angle > _LARGEST_TILT:
        raise InputError(f"--{name}: {degrees(angle):.3g}° is more than the model's small angles")
    return angle


def _interval_error(known: KnownOptions, base: TimeBase, note: Callable[[str], None]) -> float:
    stated = known.get("interval_uncertainty")
    if stated is not None:
        return _not_negative("interval-uncertainty", stated, "time")
    if base.exact:
        note(
            "stamps are exactly regular and tell no errors: u(Δt) is taken as 0; give "
            "--interval-uncertainty"
        )
        return 0.0
    note(
        f"u(Δt) = {1e3 * base.deviation:.3g} ms, the standard deviation of {base.count} intervals "
        f"between stamps, {1e3 * base.interval:.5g} ms in the mean"
    )
    return base.deviation


def _stamps_err(known: KnownOptions, base: TimeBase, note: Callable[[str], None]) -> bool:
    stated = known.get("time_errors")
    if stated is not None:
        return stated == "stamps"
    if base.exact:
        if known.get("interval_uncertainty") is not None:
            note(
                "stamps are exactly regular and do not tell whether stamps or intervals err: "
                "intervals are taken to err independently; give --time-errors"
            )
        return False
    stamps = base.correlation < STAMPS_BELOW
    what = "it is stamps that err" if stamps else "intervals err independently"
    note(f"neighbouring intervals correlate by {base.correlation:.2f}: {what}")
    return stamps


def _positive(name: str, text: str, kind: str) -> float:
    return positive(f"--{name}", text, KINDS[kind])


def _not_negative(name: str, text: str, kind: str) -> float:
    return not_negative(f"--{name}", text, KINDS[kind])
