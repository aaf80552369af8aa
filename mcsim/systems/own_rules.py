"""Rules of integration of a user's own: on the channels, truth and errors of a shipped case."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mcsim.errors import InputError
from mcsim.simulation.own import add_system, digest_of
from mcsim.systems import SYSTEMS


def add_rule(
    case: str,
    name: str,
    *,
    state: type[Any],
    start: Callable[..., Any],
    step: Callable[..., Any],
    end: Callable[..., Any],
) -> None:
    """Let scenarios write ``reconstruction: {integration: NAME}`` for an algorithm of your own.

    It is compiled by numba and runs in the engine's kernel, with its linear model, control
    variates and budget from the steps themselves.

    Parameters
    ----------
    case : str
        ``planar`` or ``strapdown``: which channels are measured, and which motion is believed.
    name : str
        What scenarios call it.
    state : type
        A named tuple of floats: what is known between two samples.
    start : callable
        ``start(system, motion, read) -> state`` from the motion believed at sample 0 (along,
        across, speed, heading, course in m, m/s, rad; in space also height, climb, roll, pitch)
        and from what is measured there.
    step : callable
        ``step(system, state, read) -> state``, one sample on.  ``read`` are the channels: forward
        and left acceleration (m/s^2), yaw turn (rad per interval), in space then upward force,
        roll turn, pitch turn; ``system.interval`` is the interval (s).  Where intervals vary
        (``sensors.time``), both are those of the sample's own interval, and a sample that is lost
        makes no step.
    end : callable
        ``end(system, state) -> motion``, of the type that ``start`` gets.

    Raises
    ------
    InputError
        No such case, a name that is taken, or a state that is no named tuple.
    """
    rules = SYSTEMS[case].rules if case in SYSTEMS else None
    kernel = SYSTEMS[case].kernel if case in SYSTEMS else None
    if rules is None or kernel is None:
        takes = [name for name, known in SYSTEMS.items() if known.rules is not None]
        raise InputError(f"{case}: own rules are for the cases {', '.join(takes)}")
    if name in rules.shipped:
        raise InputError(f"{name}: the case {case} has a rule of that name already")
    variables = len(getattr(state, "_fields", []))
    if not (issubclass(state, tuple) and variables):
        raise InputError(f"{name}: `state` must be a named tuple with a field per variable")
    from mcsim.kernels import custom

    base = kernel()
    if variables + base.CHANNELS > custom.MOST_VARIED:
        most = custom.MOST_VARIED - base.CHANNELS
        raise InputError(f"{name}: a state of more than {most} variables has no linear model here")
    own = f"{name}_{digest_of(state, start, step, end)}"
    even, timed = (
        custom.system_of(base, own, state, (start, step, end), timed) for timed in (False, True)
    )
    add_system(case, name, even, timed)
    rules.add(name)
