"""A coefficient drawn once, times a course that is the same in every realization.

What the course is follows from the channel's own true signal and from the sensor's temperature:
the signal's square or its amount, the temperature's difference, their product.  Among the
signals such a course stands as one more column, from which mixing takes a drawn share.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.channel import Channel
from mcsim.sensor_terms.mechanisms.mechanism import Acts, Mechanism, of_kind
from mcsim.sensor_terms.mechanisms.mixing import Mixing

Array = NDArray[np.float64]
#: The course of true signals (n,), SI, and temperature differences (n,), K: an error (n,) in the
#: signal's unit per unit of the coefficient.
Course = Callable[[Array, Array], Array]


@dataclass(frozen=True)
class Shaped(Mechanism):
    """A coefficient, normal with mean zero, times the ``course`` of its channel.

    ``course`` takes the true signal (n,) in SI units and the sensor's temperature difference (n,)
    in K; ``deviation`` is in SI units of the channel per unit of the course.
    """

    deviation: float
    course: Course


@dataclass(frozen=True)
class Column:
    """A course as a column among the signals.

    ``channel`` is the column of the signal that it follows, ``factor`` the unit of both: what a
    value of one in SI units is there.
    """

    channel: int
    course: Course
    factor: float = 1.0

    def of(self, signals: Array, temperature: Array) -> Array:
        """The column (n,) for signals (n, s) and temperature differences (n,)."""
        own = signals[:, self.channel] / self.factor
        return np.asarray(self.factor * self.course(own, temperature), float)


def columns_of(acts: Sequence[Acts]) -> tuple[Column, ...]:
    """The further columns that channels ask for."""
    asked = [(target, act) for target, own in enumerate(acts) for act in _shaped(own).values()]
    return tuple(dict.fromkeys(Column(target, act.course) for target, act in asked))


def shares(
    acts: Sequence[Acts],
    channels: Sequence[Channel],
    columns: Sequence[Column],
    at_rest: tuple[Array, Array],
    calibrated: bool,
) -> Iterator[Mixing]:
    """What channels take of these columns, which stand behind all ``channels``.

    ``at_rest`` is what the columns hold (v,) while biases are calibrated, and while the attitude
    is levelled; where they are ``calibrated`` that goes with the bias.
    """
    calibrating, levelling = at_rest
    for target, own in enumerate(acts):
        for name, act in _shaped(own).items():
            number = columns.index(Column(target, act.course))
            yield Mixing(
                target,
                len(channels) + number,
                act.deviation,
                f"{channels[target].element} {name}",
                float(calibrating[number]) if calibrated else 0.0,
                float(levelling[number]),
            )


def _shaped(acts: Acts) -> dict[str, Shaped]:
    return {name: act for name, act in of_kind(acts, Shaped).items() if act.deviation > 0.0}
