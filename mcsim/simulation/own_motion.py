"""Dead reckoning of a user's own: a motion, a state, three functions, and a problem of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mcsim.errors import InputError
from mcsim.sensors.measurement import Measurement
from mcsim.simulation.linear_errors import length_of
from mcsim.simulation.own import digest_of
from mcsim.simulation.planar_samples import wrap
from mcsim.simulation.problem import Array, History
from mcsim.simulation.reckoning import Description, Reckoning

#: Channels that have random numbers of their own, and lengths that an algorithm may report.
_MOST_CHANNELS, _MOST_LENGTHS = 6, 2


@dataclass(frozen=True)
class Algorithm:
    """A reconstruction that kernels run: what it errs in, and its compiled system.

    See ``algorithm``, which makes them.
    """

    description: Description
    kernel: Any
    timed: Any


def algorithm(
    name: str,
    *,
    signals: tuple[str, ...],
    motion: type[Any],
    state: type[Any],
    functions: tuple[Callable[..., Any], Callable[..., Any], Callable[..., Any]],
    angles: tuple[str, ...] = (),
    lengths: Mapping[str, tuple[str, ...]] | None = None,
) -> Algorithm:
    """Compile a reconstruction of one's own, for a case of one's own.

    Parameters
    ----------
    name : str
        Tells its kernel apart, and begins messages.
    signals : tuple of str
        What the channels measure, in words; three or six of them.
    motion : type
        A named tuple of floats, SI: what is believed at the start and compared at the end.  Its
        fields are the names of the errors.
    state : type
        A named tuple of floats: what the algorithm knows between two samples.
    functions : start, step, end
        Small functions that numba compiles: ``start(system, motion, read) -> state`` at sample 0,
        ``step(system, state, read) -> state`` one sample on, ``end(system, state) -> motion``.
        ``read`` are the channels; ``system.interval`` (s) and ``system.parameters`` are numbers.
        Where intervals vary, ``interval`` and turns are those of the sample's own.
    angles : tuple of str, optional
        Fields (rad) whose errors wrap at half a turn.
    lengths : mapping, optional
        Errors that are the length of the errors of some fields together: at most two.

    Returns
    -------
    Algorithm
        For ``OwnReckoning``; ``description.errors`` are the names of its errors, in order.

    Raises
    ------
    InputError
        Types that are no named tuples, names that are no fields, or too many of something.
    """
    from mcsim.kernels import custom
    from mcsim.kernels.own_motion import motion_class

    lengths = dict(lengths or {})
    fields = _fields(motion, f"{name}: `motion`")
    variables = _fields(state, f"{name}: `state`")
    channels = len(signals)
    if channels % 3 or not 0 < channels <= _MOST_CHANNELS:
        raise InputError(f"{name}: three or six `signals` are measured, not {channels}")
    if len(variables) + channels > custom.MOST_VARIED or len(fields) > custom.MOST_VARIED:
        most = custom.MOST_VARIED - channels
        raise InputError(f"{name}: a state of more than {most} variables has no linear model here")
    for of in (angles, *lengths.values()):
        unknown = [field for field in of if field not in fields]
        if unknown:
            raise InputError(f"{name}: `motion` has no field {unknown[0]}; {', '.join(fields)}")
    if len(lengths) > _MOST_LENGTHS:
        raise InputError(f"{name}: at most {_MOST_LENGTHS} errors may be lengths")
    own = f"{name}_{digest_of(motion, state, *functions)}"
    base = motion_class(own, channels, motion, angles, lengths)
    return Algorithm(
        Description(
            errors=(*fields, *lengths),
            signals=signals,
            lengths=lengths,
            wrapping=angles,
            initial={f"initial {f} error": (channels + k,) for k, f in enumerate(fields)},
        ),
        custom.system_of(base, own, state, functions),
        custom.system_of(base, own, state, functions, timed=True),
    )


def _fields(kind: type[Any], what: str) -> tuple[str, ...]:
    fields = tuple(getattr(kind, "_fields", ()))
    if not (isinstance(kind, type) and issubclass(kind, tuple) and fields):
        raise InputError(f"{what} must be a named tuple with a field per variable")
    return fields


@dataclass(frozen=True, kw_only=True)
class OwnReckoning(Reckoning):
    """A point of a case that brings its own algorithm: what the case's ``problem`` returns.

    Attributes
    ----------
    algorithm : Algorithm
        See ``algorithm``, which makes it.
    signals : float64 (n + 1, c, or more)
        What the c channels would measure at the samples 0 ... n: m/s^2, and rad per interval in the
        place of angular rates; further columns show in them by misalignment.
    sensor_errors : ChannelErrors
        Of the channels, in the same units; of ``driven``.
    truth : float64 (f, n + 1)
        The true motion at the samples, a row for each of its f fields, SI.
    initial : float64 (f,)
        Standard deviations of what is believed of the motion at the start.
    interval : float
        Of the samples (s).
    parameters : tuple of float
        Numbers for the algorithm: ``system.parameters``.
    tracks : tuple of str
        The fields that a picture of the track shows, along first.
    missing : mapping
        Errors that are undefined, with the reason.
    beyond_rate : float64 (c,)
        Of each channel the share of power that the sampling rate does not hold.
    percentiles : tuple of float
        Of the errors, that tables hold.
    """

    algorithm: Algorithm
    truth: Array
    initial: Array
    initial_deviations: Array = field(init=False)
    parameters: tuple[float, ...] = (0.0,)
    tracks: tuple[str, str] = ("along", "across")

    def __post_init__(self) -> None:
        deviations = np.zeros(self.kernel.CONSTANTS)
        first = self.kernel.CHANNELS
        deviations[first : first + len(self.initial)] = self.initial
        object.__setattr__(self, "initial_deviations", deviations)

    @property
    def description(self) -> Description:
        return self.algorithm.description

    @property
    def kernel(self) -> Any:
        return self.algorithm.timed if self.timed else self.algorithm.kernel

    def system(self, measurement: Measurement, disturbed: bool) -> Any:
        kernel = self.kernel
        drawn = self.deviations(measurement, disturbed)[: kernel.CHANNELS + len(self.truth)]
        truth = self.truth.copy()
        for row, name in enumerate(kernel.MOTION._fields):
            if name in self.missing:
                truth[row, -1] = np.nan
        return kernel(
            way=0,
            interval=self.interval,
            draws=True,
            deviations=kernel.DEVIATIONS(*map(float, drawn)),
            start=kernel.MOTION(*map(float, truth[:, 0])),
            end=kernel.MOTION(*map(float, truth[:, -1])),
            parameters=self.parameters,
        )

    def history(self, key: int, first: int, count: int, net: int = 0) -> History:
        fields = self.kernel.MOTION._fields
        states, then = self.late(self.states(key, first, count, net), self.truth)
        errors = states - then
        for name in self.description.wrapping:
            errors[fields.index(name)] = wrap(errors[fields.index(name)])
        for name in self.missing.keys() & set(fields):
            errors[fields.index(name), -1] = np.nan
        lengths = [
            length_of(errors[[fields.index(name) for name in of]])
            for of in self.description.lengths.values()
        ]
        drawn = [fields.index(name) for name in self.tracks if name in fields]
        return History(
            time=self.times,
            tracks=states[drawn],
            truth=self.truth[drawn],
            errors=np.concatenate([errors, np.array(lengths).reshape(-1, *errors.shape[1:])]),
            coordinates=tuple(f"{name} [m]" for name in self.tracks if name in fields),
        )
