"""Algorithms of a user's own on the channels, the truth and the errors of a shipped system.

An algorithm is three scalar functions over a state of its own, a named tuple of floats:

* ``start(system, motion, read) -> State``: the initial motion as it is believed, and what the
  channels measure at sample 0;
* ``step(system, state, read) -> State``: one sample on; ``read`` are the channels in the system's
  order, forces in m/s^2 and turns in rad per interval, ``system.interval`` is the interval in s;
  where intervals vary both are those of the sample's own interval, and lost samples make no step;
* ``end(system, state) -> Motion``: the motion that the state stands for.

They run in the frame like the shipped systems, four samples at a time.  Their linear model is
``adjoint``'s.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mcsim.kernels.adjoint import MOST_VARIED
from mcsim.kernels.compilation import scalar
from mcsim.kernels.lane_steps import is_timed
from mcsim.kernels.lanes import LANES, NORMALS
from mcsim.kernels.parts import loader, made, of, store, take
from mcsim.kernels.system import Step, add_linear, begin, finish, keep, record, remembers, rows_of

__all__ = ["MOST_VARIED", "Custom", "system_of"]


class Custom:
    """Marks the systems made here."""

    __slots__ = ()


def system_of(
    base: type[Any],
    name: str,
    state: type[Any],
    start: Callable[..., Any],
    step: Callable[..., Any],
    end: Callable[..., Any],
) -> type[Any]:
    """A system like ``base``, moved by an algorithm of three scalar functions."""
    timed = is_timed(base)
    taken = Step(_timed(scalar(step), base) if timed else scalar(step), state)
    members = {
        "STEPS": (taken,),
        "FOURS": {} if timed else {0: taken},
        "STATE": len(state._fields),
        "START": staticmethod(scalar(start)),
        "END": staticmethod(scalar(end)),
        "__slots__": (),
        "__module__": __name__,
    }
    made_here = type(name, (Custom, base), members)
    # Where numba finds it again when it reads what it has kept.
    globals()[name] = made_here
    return made_here


def _timed(step, base):
    """The same step over the sample's own interval, which is the last that is read."""
    own, turned = _over(base), _turned(base.CHANNELS, base.TURNS)

    @scalar
    def over_interval(system, state, read):
        r = read[-1]
        if r == 0.0:
            return state
        return step(own(system, r), state, turned(read, r))

    return over_interval


def _over(base):
    """The numbers of a system of another interval."""
    numbers = base.__mro__[[kind._fields is base._fields for kind in base.__mro__[:-2]].index(True)]
    place, kind = base._fields.index("interval"), numbers

    @scalar
    def over(system, r):
        return kind(*system[:place], r * system[place], *system[place + 1 :])

    return over


def _turned(count, turns):
    """The channels, with turns over the interval in the place of those per sampling interval."""
    last = count - 1
    if last in turns:
        own = scalar(lambda read, r: r * read[last])
    else:
        own = scalar(lambda read, r: read[last])
    if not last:
        return scalar(lambda read, r: (own(read, r),))
    before = _turned(last, turns)
    return scalar(lambda read, r: (*before(read, r), own(read, r)))


@of(begin, Custom)
def _begin(system, constants, sensors, scratch, rows):
    """Nothing: the state begins with what is measured at sample 0."""


@made(remembers, Custom)
def _make_remembers(system):
    return lambda system: True


@made(keep, Custom)
def _make_keep(system):
    initial, start, count = system.INITIAL, system.START, system.CHANNELS

    def keep(system, constants, measured, rows):
        for j in range(LANES):
            motion = initial(system, constants, j)
            store(rows, j, start(system, motion, take(measured, j, count)))

    return keep


@made(record, Custom)
def _make_record(system):
    load, end, recorded = loader(system.STEPS[0].state), system.END, system.RECORDED

    def record(system, number, asked, start, filled, rows, errors, linear, history):
        for j in range(filled):
            values = recorded(system, end(system, load(rows, j)))
            for row in range(len(values)):
                history[row, asked, start + j] = values[row]

    return record


@made(finish, Custom)
def _make_finish(system):
    load, end, of_motion = loader(system.STEPS[0].state), system.END, system.ERRORS_OF

    def finish(system, rows, start, filled, errors):
        for j in range(filled):
            values = of_motion(system, end(system, load(rows, j)))
            for row in range(len(values)):
                errors[row, start + j] = values[row]

    return finish


@made(add_linear, Custom)
def _make_add_linear(system):
    """Every channel may act on every error."""
    channels, count, linear = system.CHANNELS, len(system.LINEAR), rows_of(system)[1]

    def add(system, way, i, k, until, normals, weights, rows):
        for sample in range(k, until):
            for error in range(count):
                own = rows[linear + error * LANES : linear + (error + 1) * LANES]
                for channel in range(channels):
                    at = (channel // 3 * NORMALS + 3 * sample + channel % 3) * LANES
                    weight, drawn = (
                        weights[i + sample, error * channels + channel],
                        normals[at : at + LANES],
                    )
                    for j in range(LANES):
                        own[j] += weight * drawn[j]

    return add
