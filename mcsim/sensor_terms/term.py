"""A sensor term: what a block may say of it, and the mechanism by which it acts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from mcsim.errors import InputError
from mcsim.sensor_terms.channel import ACCELEROMETER, SIGNALS
from mcsim.sensor_terms.mechanisms.mechanism import Mechanism
from mcsim.units import KINDS


@dataclass(frozen=True)
class SensorKey:
    """A quantity that an element's block may hold.

    Parameters
    ----------
    name : str
        The key in scenarios and sensor files.
    kind : str
        Kind of quantity, one of ``mcsim.units.KINDS``; ``"{signal}"`` stands for what the element
        measures, an acceleration or an angular rate.
    text : str
        What it is, for the schema.
    role : str
        The parameter of the term's ``acts`` that takes it; that of its own name if empty.
    positive : bool
        Whether zero is no value of it.
    per_axis : bool
        Whether it may be a list [x, y, z].
    scales : bool
        Whether zero leaves nothing of the term, so that its other keys have no effect.
    """

    name: str
    kind: str
    text: str = ""
    role: str = ""
    positive: bool = False
    per_axis: bool = True
    scales: bool = False

    def kind_for(self, element: str) -> str:
        """The kind of quantity in the block of an element."""
        return self.kind.format(signal=SIGNALS[element])


@dataclass(frozen=True)
class InnerBlock:
    """The block within an element's block that holds the keys of a term.

    ``key`` is its name there, ``title`` names it in the schema, ``text`` says what it is.
    """

    key: str
    title: str
    text: str


@dataclass(frozen=True)
class SensorTerm:
    """A term of a sensor's error model.

    Parameters
    ----------
    name : str
        What budgets call it, behind the element's name: ``"turn-on bias"``.
    acts : callable
        The mechanism on one channel from the values written for its axis, by the roles of their
        keys, SI.  It is not asked where none is written.
    accelerometer, gyroscope : tuple of SensorKey
        The keys in each element's block; none if the element has no such term.
    inner : InnerBlock, optional
        The block within the element's that holds all keys, which are all needed then.
    alternatives : bool
        Whether the keys are ways to write one quantity, of which a block may use one.
    """

    name: str
    acts: Callable[..., Mechanism]
    accelerometer: tuple[SensorKey, ...] = ()
    gyroscope: tuple[SensorKey, ...] = ()
    inner: InnerBlock | None = None
    alternatives: bool = False

    def keys(self, element: str) -> tuple[SensorKey, ...]:
        """The keys in the block of an element."""
        return self.accelerometer if element == ACCELEROMETER else self.gyroscope

    def paths(self, element: str) -> Iterator[tuple[str, SensorKey]]:
        """The keys with their dotted paths below the element's block."""
        for key in self.keys(element):
            yield (f"{self.inner.key}.{key.name}" if self.inner else key.name), key


def check(term: SensorTerm) -> None:
    """Refuse a term whose keys no block can hold.

    Raises
    ------
    InputError
        A kind of quantity that does not exist, or no key at all.
    """
    if not (term.accelerometer or term.gyroscope):
        raise InputError(f"{term.name}: a sensor term needs a key in an element's block")
    for element in SIGNALS:
        for key in term.keys(element):
            if key.kind_for(element) not in KINDS:
                raise InputError(
                    f"{term.name}: `{key.name}`: there is no kind of quantity "
                    f'"{key.kind_for(element)}" (known: {", ".join(KINDS)})'
                )
