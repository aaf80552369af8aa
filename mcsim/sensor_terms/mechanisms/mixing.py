"""How much of one channel's true signal shows in another: a coefficient drawn once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.channel import ACCELEROMETER, GYROSCOPE, Channel
from mcsim.sensor_terms.mechanisms.mechanism import Acts, Mechanism, of_kind, stream

Array = NDArray[np.float64]


class Source(Enum):
    """Whose signal shows in a channel."""

    ITSELF = "itself"
    OTHER_AXES = "other axes"
    """Those of the same element."""
    SPECIFIC_FORCE = "specific force"
    """All axes of the accelerometer, in a gyroscope."""


@dataclass(frozen=True)
class Coefficient(Mechanism):
    """A coefficient for each source, normal with mean zero, in units of the channel's per unit
    of the source's."""

    deviation: float
    source: Source


@dataclass(frozen=True)
class Mixing:
    """One coefficient drawn per realization: how much of channel ``source`` shows in ``target``.

    ``deviation`` is in units of the target's per unit of the source's; ``term`` its name in
    budgets.  A bias calibration at rest has taken away what ``calibrated`` of the source,
    its true signal there, makes of the target; ``levelled`` is its true signal while the attitude
    is levelled.
    """

    target: int
    source: int
    deviation: float
    term: str
    calibrated: float = 0.0
    levelled: float = 0.0


def _is(source: Source, target: Channel, other: Channel) -> bool:
    return {
        Source.ITSELF: target == other,
        Source.OTHER_AXES: target.element == other.element and target != other,
        Source.SPECIFIC_FORCE: (target.element, other.element) == (GYROSCOPE, ACCELEROMETER),
    }[source]


def mixed(
    acts: Sequence[Acts], channels: Sequence[Channel], at_rest: Array, calibrated: bool
) -> Iterator[Mixing]:
    """The entries of all channels, of which those with ``acts`` are measured and come first.

    What mixing makes of the true signals ``at_rest`` (s,) stands in the output of a sensor that is
    ``calibrated`` there as a bias does, and goes with it.
    """
    for target, own in enumerate(acts):
        channel = channels[target]
        for source, other in enumerate(channels):
            still = float(at_rest[source])
            for name, act in of_kind(own, Coefficient).items():
                if act.deviation > 0.0 and _is(act.source, channel, other):
                    term = f"{channel.element} {name}"
                    known = still if calibrated else 0.0
                    yield Mixing(target, source, act.deviation, term, known, still)


def rescaled(entries: Sequence[Mixing], factors: Array) -> tuple[Mixing, ...]:
    """The same with the channels in other units; ``factors`` (s,) of all of them."""
    return tuple(
        replace(
            entry,
            deviation=entry.deviation * float(factors[entry.target] / factors[entry.source]),
            calibrated=entry.calibrated * float(factors[entry.source]),
            levelled=entry.levelled * float(factors[entry.source]),
        )
        for entry in entries
    )


def mixer(entries: Sequence[Mixing], seed: int) -> Callable[[Array, Array], None]:
    """Draw the coefficients of a simulated log: ``add(signals, measured)`` adds what they mix.

    ``signals`` (n, s) are true, ``measured`` (n, c) is written.
    """
    streams = {entry.term: stream(seed, entry.term) for entry in entries}
    drawn = [entry.deviation * streams[entry.term].standard_normal() for entry in entries]

    def add(signals: Array, measured: Array) -> None:
        for entry, coefficient in zip(entries, drawn, strict=True):
            shown = signals[:, entry.source] - entry.calibrated
            measured[:, entry.target] += coefficient * shown

    return add


def weights_of(
    entries: Sequence[Mixing],
    weights: Array,
    signals: Array,
    at_rest: Array | None,
) -> Array:
    """Linear errors (e, m) per unit normal of each coefficient.

    ``weights`` (e, n, c) are those of the channels' errors, ``at_rest`` (e, c) those of the mean
    errors that level the attitude.
    """
    columns = []
    for m in entries:
        column = weights[:, :, m.target] @ (signals[:, m.source] - m.calibrated)
        if at_rest is not None:
            column = column + at_rest[:, m.target] * (m.levelled - m.calibrated)
        columns.append(column * m.deviation)
    return np.stack(columns, axis=1) if columns else np.zeros((len(weights), 0))
