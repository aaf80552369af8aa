"""Rules of integration of a user's own: on the channels, truth and errors of a shipped case."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from typing import Any

from mcsim.errors import InputError
from mcsim.scenario import rules

#: Systems by case and name, and the kernels that they run in.
_SYSTEMS: dict[tuple[str, str], type[Any]] = {}


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
        roll turn, pitch turn; ``system.interval`` is the interval (s).
    end : callable
        ``end(system, state) -> motion``, of the type that ``start`` gets.

    Raises
    ------
    InputError
        No such case, a name that is taken, or a state that is no named tuple.
    """
    if case not in rules.SHIPPED:
        raise InputError(f"{case}: own rules are for the cases {', '.join(rules.SHIPPED)}")
    if name in rules.SHIPPED[case]:
        raise InputError(f"{name}: the case {case} has a rule of that name already")
    variables = len(getattr(state, "_fields", []))
    if not (issubclass(state, tuple) and variables):
        raise InputError(f"{name}: `state` must be a named tuple with a field per variable")
    from mcsim.kernels import custom, planar, strapdown

    base: type[Any] = planar.Planar if case == "planar" else strapdown.Strapdown
    if variables + base.CHANNELS > custom.MOST_VARIED:
        most = custom.MOST_VARIED - base.CHANNELS
        raise InputError(f"{name}: a state of more than {most} variables has no linear model here")
    digest = hashlib.blake2b(digest_size=8)
    for part in (state, start, step, end):
        digest.update(_source_of(part))
    own = f"{name}_{digest.hexdigest()}"
    _SYSTEMS[case, name] = custom.system_of(base, own, state, start, step, end)
    rules.add(case, name)


def own_system(case: str, name: str) -> type[Any] | None:
    """The system of a rule that a user has added; None for shipped rules."""
    return _SYSTEMS.get((case, name))


def _source_of(part: Any) -> bytes:
    """What a part is compiled from: the whole file, since functions call others in it."""
    try:
        return (inspect.getsource(inspect.getmodule(part) or part)).encode()
    except (OSError, TypeError):
        return repr(part).encode()
