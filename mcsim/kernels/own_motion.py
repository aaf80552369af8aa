"""Systems whose motion a user defines: what is believed at the start, and what errs at the end.

The motion is a named tuple of floats.  A realization believes each of its fields with an error of
its own at the start, and errs in each at the end; lengths of some of them together may be errors
too.  The algorithm between start and end is three functions (see ``custom``).
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Mapping
from typing import Any

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import LANES, WHITE_NOISE, draw_constants
from mcsim.kernels.parts import of
from mcsim.kernels.rotation import wrap
from mcsim.kernels.strapdown_system import SPATIAL_NOISE, TURNS
from mcsim.kernels.system import draw_once

#: Streams of the samples' noise, one for each three channels.
STREAMS = (WHITE_NOISE, SPATIAL_NOISE)


class OwnMotion:
    """Marks the systems made here."""

    __slots__ = ()


@of(draw_once, OwnMotion)
def _draw_once(system, key, first, rows, constants):
    draw_constants(key, first, rows, constants)


def motion_class(
    name: str,
    channels: int,
    motion: type[Any],
    angles: tuple[str, ...] = (),
    lengths: Mapping[str, tuple[str, ...]] | None = None,
) -> type[Any]:
    """The class of a system without its algorithm, for ``custom.system_of``.

    ``channels`` is a multiple of three; ``angles`` are fields whose errors wrap, ``lengths`` errors
    that are the length of the errors of some fields.  Errors come in the order of the fields, then
    the lengths; a realization draws the channels' offsets, the fields' errors and the noise of
    sample 0.
    """
    fields = motion._fields
    count = len(fields)
    places = [tuple(map(fields.index, of)) for of in (lengths or {}).values()]
    wraps = tuple(field in angles for field in fields)
    members = {
        "CHANNELS": channels,
        "TURNS": TURNS[: channels // 3 * 2 - 1],
        "STREAMS": STREAMS[: channels // 3],
        "CONSTANTS": -(-(2 * channels + count) // 4) * 4,
        "FIXED": tuple(range(0, channels, 3)),
        "FIRST": tuple(range(channels + count, 2 * channels + count, 3)),
        "ERRORS": count + len(places),
        "LINEAR": tuple(range(count)),
        "HISTORY": count,
        "SPARE": 0,
        "DEVIATIONS": _named(f"{name}_deviations", (*_channel_names(channels), *fields)),
        "MOTION": motion,
        "INITIAL": _initial_of(motion, channels),
        "ERRORS_OF": _errors_of(wraps, places),
        "RECORDED": scalar(lambda system, motion: motion),
        "__slots__": (),
        "__module__": __name__,
    }
    numbers = _named(
        f"{name}_numbers",
        ("way", "interval", "draws", "deviations", "start", "end", "parameters"),
    )
    made_here = type(f"{name}_motion", (OwnMotion, numbers), members)
    globals()[made_here.__name__] = made_here
    return made_here


def _channel_names(channels):
    return tuple(f"channel_{k}" for k in range(channels))


def _named(name, fields):
    """A named tuple that numba finds again when it reads what it has kept."""
    made_here = namedtuple(name, fields)  # type: ignore[misc]
    made_here.__module__ = __name__
    globals()[name] = made_here
    return made_here


def _initial_of(motion, channels):
    """The motion that a realization believes to start with."""
    believed = _believed(len(motion._fields), channels)

    @scalar
    def initial(system, constants, j):
        return motion(*believed(system.start, system.deviations, constants, j))

    return initial


def _believed(count, channels):
    """The first ``count`` fields, each with the error that is drawn for it."""
    last, row = count - 1, channels + count - 1

    @scalar
    def own(start, deviations, constants, j):
        return start[last] + deviations[row] * constants[row * LANES + j]

    if not last:
        return scalar(
            lambda start, deviations, constants, j: (own(start, deviations, constants, j),)
        )
    before = _believed(last, channels)

    @scalar
    def believed(start, deviations, constants, j):
        return (*before(start, deviations, constants, j), own(start, deviations, constants, j))

    return believed


def _errors_of(wraps, places):
    """Differences of the fields from the truth, then the lengths."""
    differences = _differences(wraps)
    lengths = _lengths(places)

    @scalar
    def errors(system, motion):
        found = differences(motion, system.end)
        return (*found, *lengths(found))

    return errors


def _differences(wraps):
    last = len(wraps) - 1
    if wraps[last]:
        own = scalar(lambda motion, end: wrap(motion[last] - end[last]))
    else:
        own = scalar(lambda motion, end: motion[last] - end[last])
    if not last:
        return scalar(lambda motion, end: (own(motion, end),))
    before = _differences(wraps[:last])
    return scalar(lambda motion, end: (*before(motion, end), own(motion, end)))


def _lengths(places):
    if not places:
        return scalar(lambda found: ())
    square = _square(places[-1])
    before = _lengths(places[:-1])
    return scalar(lambda found: (*before(found), math.sqrt(square(found))))


def _square(components):
    last = components[-1]
    if len(components) == 1:
        return scalar(lambda found: found[last] * found[last])
    before = _square(components[:-1])
    return scalar(lambda found: before(found) + found[last] * found[last])
