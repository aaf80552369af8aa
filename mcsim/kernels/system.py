"""What the frame knows of a system: its numbers, its class, and the parts that it fills in.

A system is a named tuple of numbers.  It fills in the parts ``begin``, ``keep``, ``add_linear``,
``record`` and ``finish`` (see ``parts``), and its class says

* ``STEPS``: the ways of taking one sample; ``system.way`` is the number of the one to take;
* ``FOURS``: by way, how four samples are taken at a time where nothing but noise disturbs them;
* ``LATE``, if any: the ways that read sample 0 in their first step, not before it;
* ``STATE``: the most rows that the state of any step has;
* ``CHANNELS``, a multiple of three: each three have streams of random numbers of their own;
* ``CONSTANTS``: rows of normals that a realization draws once, and among them, for each three
  channels, the rows ``FIXED`` where those of their offsets begin and ``FIRST`` where the noise
  of sample 0 does; ``system.deviations`` begins with those of the offsets;
* ``ERRORS``, ``HISTORY``: rows of the results; ``LINEAR``: the rows of the errors that have a
  linear error, in the order of those; ``SPARE``: rows of scratch.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy import float64
from numpy.typing import NDArray

from mcsim.kernels.lanes import LANES
from mcsim.kernels.measurement import ErrorTerms
from mcsim.kernels.parts import part

Array = NDArray[float64]


class Sensors(NamedTuple):
    """What c channels measure at samples 0 ... n, and with which errors.

    signals : float64 (n + 1, c)
        Undisturbed forces (m/s^2) and turns per interval (rad); sample 0 is the known initial
        state.
    white : float64 (c,)
        Standard deviation of the white noise of one sample.
    terms : ErrorTerms
        Everything beyond white noise and offsets.
    """

    signals: Array
    white: Array
    terms: ErrorTerms


class Weights(NamedTuple):
    """Linear errors per unit normal.

    samples : float64 (n + 1, w)
        Of each sample's channels, laid out as the system's ``add_linear`` reads them.
    constants : float64 (e, k)
        Of what a realization draws once.
    """

    samples: Array
    constants: Array


class Results(NamedTuple):
    """Where the results go; what is empty is not wanted.

    errors : float64 (ERRORS, count)
        Errors at the last sample.
    linear : float64 (LINEAR, count) or (…, 0)
        Linear errors of the same realizations.
    history : float64 (HISTORY, n + 1, count) or (0, 0, 0)
        Reconstructed states at every sample.
    """

    errors: Array
    linear: Array
    history: Array


class Step(NamedTuple):
    """How a sample moves the state.

    function : callable
        ``function(system, state, read) -> State``; ``read`` holds the measured channels.
    state : type
        A named tuple, the state variables of a lane; where several steps share a system, the
        first rows are the same.
    offsets : bool
        Whether channels have constant offsets (for steps that take four samples).
    """

    function: Any
    state: type[Any]
    offsets: bool = True


@part
def draw_once(system, key, first, rows, constants):
    """Draw the normals of what a realization draws once, ``rows`` of them for each lane."""


@part
def begin(system, constants, sensors, scratch, rows):
    """State rows at sample 0, from what is drawn once; the offsets' rows are there already."""


@part
def keep(system, constants, measured, rows):
    """Sample 0 as measured, for rules that use the previous sample."""


@part
def add_linear(system, i, size, normals, weights, rows):
    """Add the noise of ``size`` samples from ``i`` on to the linear errors."""


@part
def record(system, rows, sample, start, filled, history):
    """States after ``sample``, for the realizations ``start`` and following."""


@part
def finish(system, rows, start, filled, errors):
    """Errors at the last sample."""


def rows_of(system: type[Any]) -> tuple[int, int, int, int]:
    """Where a block's rows begin: offsets, linear errors, spare rows; and their end."""
    offsets = LANES * system.STATE
    linear = offsets + LANES * system.CHANNELS
    spare = linear + LANES * len(system.LINEAR)
    return offsets, linear, spare, spare + LANES * system.SPARE


@part
def numbers(system):
    """Of the system's class: channels, rows of constants, linear errors, and ``rows_of``."""


@part
def linear_rows(system):
    """Rows of the errors that have a linear error, in the order of those."""


@part
def seed(system, key, first, streams):
    """Put the streams of the samples' noise into place, one for each three channels."""


@part
def draw(system, streams, normals):
    """Draw the normals of four samples of all channels."""


@part
def start_offsets(system, constants, rows):
    """Offset rows, from what is drawn once."""


@part
def first_normals(system, constants, normals):
    """Put the normals of sample 0, which a realization draws once, where those of a group stand."""


@part
def advance(system, measured, rows):
    """One sample of every lane, with what was measured."""


@part
def advance_four(system, i, signals, white, normals, rows):
    """Four samples of every lane, which have white noise and offsets alone."""


@part
def read_plainly(system, i, k, signals, white, normals, rows, measured):
    """Measure sample ``i``, number ``k`` of its group, where white noise and offsets are all."""


@part
def goes_by_fours(system):
    """Whether the system's step can be taken four samples at a time."""


@part
def reads_late(system):
    """Whether the system's step reads sample 0 in its first step, not before it."""


@part
def remembers(system):
    """Whether the system's step uses the sample before."""
