"""What the frame knows of a system: its numbers, its class, and the parts that it fills in.

A system is a named tuple of numbers.  It fills in the parts ``begin``, ``keep``, ``add_linear``,
``record`` and ``finish`` (see ``parts``), and its class says

* ``STEPS``: the ways of taking one sample; ``system.way`` is the number of the one to take;
* ``FOURS``: by way, how the samples of a draw (four, or what ``BARE`` leaves of them) are taken at
  a time where nothing but noise disturbs them;
* ``SINGLY``, if any: whether single samples, too, are taken without keeping what was measured,
  which is worth its compile time where results are asked at many instants;
* ``LATE``, if any: the ways that read sample 0 in their first step, not before it;
* ``STATE``: the most rows that the state of any step has;
* ``CHANNELS``, a multiple of three: each three have streams of random numbers of their own;
* ``TIMED``, if any: whether its steps read, last of all, the interval before the sample in sampling
  intervals, none where the sample is lost (see ``intervals``); it then has no ``FOURS``;
* ``BARE``, if any: normals of a sample that its step reads as they are, after the channels; a
  draw of twelve normals then serves ``12 // (3 + BARE)`` samples;
* ``CONSTANTS``: rows of normals that a realization draws once, and among them, for each three
  channels, the rows ``FIXED`` where those of their offsets begin and ``FIRST`` where the noise
  of sample 0 does; ``system.deviations`` begins with those of the offsets;
* ``ERRORS``, ``HISTORY``: rows of the results; ``LINEAR``: the rows of the errors that have a
  linear error, in the order of those; ``SPARE``: rows of scratch.

A realization is one leg of samples, unless a system says otherwise: it then has as many as its
``legs``, each begun by ``seed`` and ``enter`` (a velocity group: the rest, then run after run).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import LANES
from mcsim.kernels.measurement import ErrorTerms
from mcsim.kernels.parts import part

Array = NDArray[np.float64]


class Clock(NamedTuple):
    """How time stamps err, and what becomes of them, where intervals vary; see ``intervals``.

    jitter, stamps : float
        Standard deviations, in sampling intervals, of the instants of the samples and of what
        stamps say beyond that.
    lost : float
        Samples whose normal lies below are lost: minus infinity for none.
    nominal : bool
        Whether one sampling interval is taken for each sample that arrives, whatever stamps say.
    """

    jitter: float
    stamps: float
    lost: float
    nominal: bool


#: Stamps that never err.
EXACT_CLOCK = Clock(0.0, 0.0, -math.inf, False)


class Sensors(NamedTuple):
    """What c channels measure at samples 0 ... n, and with which errors.

    signals : float64 (n + 1, c)
        Undisturbed forces (m/s^2) and turns per interval (rad); sample 0 is the known initial
        state.  Of a timed system the last column is the interval before each sample, in sampling
        intervals.
    white : float64 (c,)
        Standard deviation of the white noise of one sample.
    terms : ErrorTerms
        Everything beyond white noise and offsets.
    clock : Clock
        For timed systems.
    """

    signals: Array
    white: Array
    terms: ErrorTerms
    clock: Clock = EXACT_CLOCK


class Weights(NamedTuple):
    """Linear errors per unit normal.

    samples : float64 (n + 1, w)
        Of each sample's channels, laid out as the system's ``add_linear`` reads them.
    constants : float64 (e, k)
        Of what a realization draws once.
    states : float64 (i, e, c p) or (0, 0, 0)
        Where samples weigh until the next instant only: errors there per state of each channel's
        processes at the instant before.
    rest : float64 (e, c) or (0, 0)
        Of the mean of each channel at a rest that is measured.
    """

    samples: Array
    constants: Array
    states: Array = np.zeros((0, 0, 0))
    rest: Array = np.zeros((0, 0))


class Results(NamedTuple):
    """Where the results go; what is empty is not wanted.

    errors : float64 (ERRORS, count)
        Errors at the last sample; of systems that report more often, at every instant.
    linear : float64 (LINEAR, count) or (…, 0)
        Linear errors of the same realizations.
    history : float64 (HISTORY, i, count) or (0, 0, 0)
        Reconstructed states at the instants.
    instants : int64 (i,)
        Samples of a leg, ascending, after which states are recorded.
    """

    errors: Array
    linear: Array
    history: Array
    instants: NDArray[np.int64]


class Step(NamedTuple):
    """How a sample moves the state.

    function : callable
        ``function(system, state, read) -> State``; ``read`` holds the measured channels, then
        the normals that are read as they are.
    state : type
        A named tuple, the state variables of a lane; where several steps share a system, the
        first rows are the same.
    offsets : bool
        Whether channels have constant offsets (for steps that take several samples).
    moving : int
        How many state variables, the first ones, the step changes; all where it is zero.
    """

    function: Any
    state: type[Any]
    offsets: bool = True
    moving: int = 0


@scalar
def with_one(read):
    """What a step of even intervals reads: the channels, and one interval."""
    return (*read, 1.0)


@scalar
def as_read(read):
    """What a step of varying intervals reads, complete as it is."""
    return read


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
def legs(system):
    """How many legs a realization has."""


@part
def leg(system, number, n):
    """Of a leg: the way of its steps, the row of ``signals`` before its first sample, how many
    samples it has, how many normals each takes of a draw, and the first instant that is recorded;
    ``n`` is the last row."""


@part
def seed(system, number, key, first, streams, normals):
    """Put the streams of a leg's noise into place, and draw normals that it begins with."""


@part
def enter(system, number, constants, normals, rows):
    """State rows at the beginning of a leg."""


@part
def start_linear(system, constants, weights, rows):
    """Linear errors at the beginning, from what is drawn once."""


@part
def add_linear(system, way, i, k, until, normals, weights, rows):
    """Add the noise of samples to the linear errors: of those drawn at once, whose first is ``i``,
    from number ``k`` on, before number ``until``."""


@part
def record(system, number, asked, start, filled, rows, errors, linear, history):
    """States of leg ``number`` at instant ``asked``, for the realizations from ``start`` on."""


@part
def finish(system, rows, start, filled, errors):
    """Errors at the last sample, for the realizations ``start`` and following."""


@part
def finish_linear(system, constants, weights, start, filled, rows, linear):
    """Linear errors of the same."""


@part
def outcome(system, rows, errors):
    """The errors of all lanes as functions of their state, for derivatives."""


def rows_of(system: type[Any]) -> tuple[int, int, int, int]:
    """Where a block's rows begin: offsets, linear errors, spare rows; and their end."""
    offsets = LANES * system.STATE
    linear = offsets + LANES * system.CHANNELS
    spare = linear + LANES * len(system.LINEAR)
    return offsets, linear, spare, spare + LANES * system.SPARE


@part
def numbers(system):
    """Of the system's class: channels, what a step reads, streams of random numbers, rows of
    constants, linear errors, and ``rows_of``."""


@part
def linear_rows(system):
    """Rows of the errors that have a linear error, in the order of those."""


@part
def draw(system, streams, normals):
    """Draw twelve normals from each stream."""


@part
def start_offsets(system, constants, rows):
    """Offset rows, from what is drawn once."""


@part
def first_normals(system, constants, normals):
    """Put the normals of sample 0, which a realization draws once, where those of a group stand."""


@part
def advance(system, way, measured, rows):
    """One sample of every lane, with what was measured."""


@part
def advance_four(system, way, i, signals, white, normals, rows):
    """The samples of a draw, in every lane, which have white noise and offsets alone."""


@part
def advance_plainly(system, way, i, row, signals, white, normals, rows, measured):
    """One sample of every lane, with normals from ``row`` on, where noise and offsets are all."""


@part
def read_plainly(system, i, row, signals, white, normals, rows, measured):
    """Measure sample ``i``, with normals from ``row`` on, where noise and offsets are all."""


@part
def read_bare(system, width, row, normals, measured):
    """Put normals that a step reads as they are behind the channels; a leg may have none."""


@part
def start_times(system, key, first, streams, times):
    """Put the stream of the time stamps into place; nothing is late yet."""


@part
def read_interval(
    system, clock, number, last, place, i, deviations, signals, normals, times, measured
):
    """Put the interval before sample ``number`` of a leg, the ``last`` one or not, behind what else
    a step reads; ``i`` is its row of the signals, ``place`` that among the samples drawn, and
    ``deviations`` are normals of the instants."""


@part
def record_time(system, asked, start, filled, times, history):
    """How late (s) the samples are that states are recorded at."""


@part
def interval_place(system):
    """Which of the numbers that a step reads is the interval; -1 for none."""


@part
def goes_by_fours(system, way):
    """Whether steps of a way can be taken several samples at a time."""


@part
def reads_late(system):
    """Whether the system's step reads sample 0 in its first step, not before it."""


@part
def remembers(system):
    """Whether the system's step uses the sample before."""
