"""How a body leans under acceleration: roll and pitch of a vehicle over its wheels.

The angle answers the acceleration like a damped oscillator,
``phi'' + 2 zeta omega phi' + omega^2 phi = omega^2 K u(t)``; without a natural frequency it
follows at once, ``phi = K u``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline, PPoly
from scipy.linalg import expm

from mcsim.errors import InputError
from mcsim.trajectory.curves import Array

#: Longest panel (s), and share of an oscillation; the input is a cubic on each panel.
_LONGEST_PANEL, _SHARE_OF_PERIOD = 5e-3, 0.02
_NODES, _ = np.polynomial.legendre.leggauss(4)
#: Values at the nodes to the coefficients of a cubic in 0 ... 1.
_TO_CUBIC = np.linalg.inv(np.vander(0.5 * (1.0 + _NODES), 4, increasing=True))
#: Amplitudes to which an oscillation is followed after the drive, as a logarithm.
_FADED = 30.0
#: Half-width (s) of the look to both sides of a kink.
_BESIDE = 1e-7
#: A larger jump of the angle (rad) is no rounding.
_JUMP = 1e-7
#: Panels of one drive: some 20 s of work, and 0.1 GB.
_MOST_PANELS = 1_000_000
#: Panels whose force is asked for at once: what that takes in memory does not grow with the drive.
_AT_ONCE = 1 << 16


@dataclass(frozen=True)
class Lean:
    """An angle (rad) over time, a piecewise polynomial, constant before and after."""

    polynomial: PPoly
    kinks: tuple[float, ...] = ()
    """Times at which the rate jumps."""

    def angle(self, t: Array) -> Array:
        """Angle at times ``t`` (rad)."""
        return self.polynomial(self._within(t))

    def rate(self, t: Array, width: float = 0.0) -> Array:
        """Its derivative (rad/s), or the mean over a cell of ``width`` (s) about each time.

        Means add up to the angle's own change, however it bends inside a cell: a momentary
        rate beside a kink would leave an error of the angle that stays.
        """
        if width > 0.0:
            half = 0.5 * width
            return (self.angle(t + half) - self.angle(t - half)) / width
        first, last = self.polynomial.x[[0, -1]]
        rate = np.where((t >= first) & (t <= last), self.polynomial(self._within(t), 1), 0.0)
        for kink in self.kinks:
            near = np.abs(t - kink) < _BESIDE
            if np.any(near):
                sides = self.angle(t[near] + _BESIDE) - self.angle(t[near] - _BESIDE)
                rate[near] = sides / (2.0 * _BESIDE)
        return rate

    def bend(self, t: Array) -> Array:
        """Its second derivative (rad/s^2); at a jump the value after it."""
        first, last = self.polynomial.x[[0, -1]]
        return np.where((t >= first) & (t <= last), self.polynomial(self._within(t), 2), 0.0)

    def _within(self, t: Array) -> Array:
        return np.clip(t, self.polynomial.x[0], self.polynomial.x[-1])


def constant_lean(angle: float) -> Lean:
    """An angle that never changes."""
    return Lean(PPoly(np.array([[angle]]), np.array([0.0, 1.0])))


def recorded_lean(spline: BSpline) -> Lean:
    """An angle that was recorded; it stands still before and after."""
    pieces = PPoly.from_spline((spline.t, spline.c, spline.k))
    inner = slice(spline.k, -spline.k)
    knots = pieces.x[inner]
    polynomial = PPoly.construct_fast(pieces.c[:, inner], knots)
    return Lean(polynomial, (float(knots[0]), float(knots[-1])))


def leaning(
    force: Callable[[Array], Array],
    before: float,
    after: float,
    breaks: tuple[float, ...],
    gain: float,
    natural_frequency: float,
    damping: float,
) -> Lean:
    """``oscillator``, or ``follower`` where the natural frequency is zero; parameters as there.

    Raises
    ------
    InputError
        A body without inertia cannot follow a force that jumps.
    """
    if gain == 0.0:
        return constant_lean(0.0)
    if natural_frequency == 0.0:
        return follower(force, before, after, breaks, gain)
    return oscillator(force, before, after, breaks, gain, natural_frequency, damping)


def oscillator(
    force: Callable[[Array], Array],
    before: float,
    after: float,
    breaks: tuple[float, ...],
    gain: float,
    natural_frequency: float,
    damping: float,
) -> Lean:
    """The answer of a damped oscillator that was settled before.

    Parameters
    ----------
    force : callable
        Times (k,) strictly between ``breaks`` to what drives it, smooth there.
    before, after : float
        What drives it before the first and after the last break.
    breaks : tuple of float
        Ascending times (s).
    gain : float
        Steady angle per force.
    natural_frequency, damping : float
        Undamped frequency (Hz, above 0) and share of the critical damping.
    """
    omega = 2.0 * math.pi * natural_frequency
    longest = _longest_panel(natural_frequency)
    slowest = omega * (damping - math.sqrt(damping**2 - 1.0)) if damping > 1.0 else omega * damping
    state = (gain * before, 0.0)
    parts = []
    for start, end in pairwise(breaks):
        knots = _knots(start, end, longest)
        part, state = _answer(knots, gain * _cubics(force, knots), state, omega, damping)
        parts.append(part)
    knots = _knots(breaks[-1], breaks[-1] + _FADED / slowest, _SHARE_OF_PERIOD / natural_frequency)
    steady = np.zeros((4, len(knots) - 1))
    steady[0] = gain * after
    part, state = _answer(knots, steady, state, omega, damping)
    return Lean(_joined([*parts, part]))


def follower(
    force: Callable[[Array], Array],
    before: float,
    after: float,
    breaks: tuple[float, ...],
    gain: float,
) -> Lean:
    """The answer of a body without inertia; parameters as in ``oscillator``.

    Raises
    ------
    InputError
        The force jumps, and the angle would.
    """
    refuse_jumps(force, before, after, breaks, gain)
    parts = []
    for start, end in pairwise(breaks):
        knots = _knots(start, end, _LONGEST_PANEL)
        cubics = gain * _cubics(force, knots)
        h = np.diff(knots)
        value = _shared(cubics[0], np.sum(cubics, axis=0))
        slope = _shared(cubics[1] / h, (cubics[1] + 2.0 * cubics[2] + 3.0 * cubics[3]) / h)
        parts.append(_hermite(knots, value, slope))
    return Lean(_joined(parts), breaks)


def refuse_jumps(
    force: Callable[[Array], Array],
    before: float,
    after: float,
    breaks: tuple[float, ...],
    gain: float,
) -> None:
    """Refuse a force that a body without inertia cannot follow; only its breaks are looked at.

    Raises
    ------
    InputError
        The force jumps, and the angle would.
    """
    last = gain * before
    for start, end in pairwise(breaks):
        knots = _knots(start, end, _LONGEST_PANEL)
        first_cubic, last_cubic = (
            gain * _cubics(force, panel)[:, 0] for panel in (knots[:2], knots[-2:])
        )
        _refuse_jump(last, float(first_cubic[0]), start)
        last = float(np.sum(last_cubic))
    _refuse_jump(last, gain * after, breaks[-1])


def refuse_long(duration: float, natural_frequency: float) -> None:
    """Refuse a drive (s) over which the lean would take more panels than are worked out.

    Raises
    ------
    InputError
        See above.
    """
    panel = _longest_panel(natural_frequency)
    if duration / panel > _MOST_PANELS:
        slower = " or lower `natural_frequency`" if panel < _LONGEST_PANEL else ""
        raise InputError(
            f"body: the drive lasts {duration:.4g} s; how the body leans is worked out over at "
            f"most {_MOST_PANELS * panel:.4g} s: shorten the drive{slower}, or leave out the "
            "gradients"
        )


def _longest_panel(natural_frequency: float) -> float:
    """Longest panel (s) of a drive; a frequency of zero is a body that follows at once."""
    if natural_frequency == 0.0:
        return _LONGEST_PANEL
    return min(_LONGEST_PANEL, _SHARE_OF_PERIOD / natural_frequency)


def _refuse_jump(left: float, right: float, t: float) -> None:
    if abs(left - right) > _JUMP:
        raise InputError(
            f"body: the acceleration jumps at {t:.4g} s, and a body that follows at once would "
            "jump with it; give `natural_frequency`, or a motion without jumps "
            "(`quintic`, `curve` with `clothoid`, no deceleration under a pitch gradient; of a "
            "straight run `s_curve`)"
        )


def _knots(start: float, end: float, longest: float) -> Array:
    return np.linspace(start, end, max(2, math.ceil((end - start) / longest)) + 1)


def _cubics(force: Callable[[Array], Array], knots: Array) -> Array:
    """Coefficients (4, m) of the force on each panel, as cubics in 0 ... 1."""
    h = np.diff(knots)
    nodes = knots[:-1, None] + 0.5 * h[:, None] * (1.0 + _NODES)
    values = [force(nodes[i : i + _AT_ONCE].ravel()) for i in range(0, len(nodes), _AT_ONCE)]
    return _TO_CUBIC @ np.concatenate(values).reshape(nodes.shape).T


def _answer(
    knots: Array, driven: Array, state: tuple[float, float], omega: float, damping: float
) -> tuple[PPoly, tuple[float, float]]:
    """Exact answer to a cubic on each panel at the knots, and a quintic between them."""
    h = float(knots[1] - knots[0])
    k0, k1, k2, k3 = driven / h ** np.arange(4)[:, None]
    lag, stiff = 2.0 * damping / omega, 1.0 / omega**2
    p3 = k3
    p2 = k2 - 3.0 * lag * p3
    p1 = k1 - 2.0 * lag * p2 - 6.0 * stiff * p3
    p0 = k0 - lag * p1 - 2.0 * stiff * p2
    end = p0 + h * (p1 + h * (p2 + h * p3))
    end_rate = p1 + h * (2.0 * p2 + 3.0 * h * p3)
    system = np.array([[0.0, 1.0], [-(omega**2), -2.0 * damping * omega]])
    (a, b), (c, d) = expm(system * h).tolist()
    angle, rate = state
    angles, rates = [angle], [rate]
    for q0, q1, e0, e1 in zip(
        p0.tolist(), p1.tolist(), end.tolist(), end_rate.tolist(), strict=True
    ):
        x, v = angle - q0, rate - q1
        angle, rate = e0 + a * x + b * v, e1 + c * x + d * v
        angles.append(angle)
        rates.append(rate)
    value, slope = np.array(angles), np.array(rates)
    force = np.stack([driven[0], np.sum(driven, axis=0)])

    def acceleration(side: int) -> Array:
        at = slice(None, -1) if side == 0 else slice(1, None)
        return omega**2 * (force[side] - value[at]) - 2.0 * damping * omega * slope[at]

    return _hermite(knots, value, slope, acceleration(0), acceleration(1)), (angle, rate)


def _shared(left: Array, right: Array) -> Array:
    """Values (m + 1,) at knots from those at both ends of the panels, halfway between two."""
    values = np.append(left, right[-1])
    values[1:-1] = 0.5 * (left[1:] + right[:-1])
    return values


def _hermite(
    knots: Array,
    value: Array,
    slope: Array,
    bend: Array | None = None,
    bend_at_end: Array | None = None,
) -> PPoly:
    """Polynomials through values and slopes at the knots, and through second derivatives."""
    h = np.diff(knots)
    if bend is None or bend_at_end is None:
        rise = np.diff(value) / h
        c2 = (3.0 * rise - 2.0 * slope[:-1] - slope[1:]) / h
        c3 = (slope[:-1] + slope[1:] - 2.0 * rise) / h**2
        zero = np.zeros_like(h)
        return PPoly(np.stack([zero, zero, c3, c2, slope[:-1], value[:-1]]), knots)
    c2 = 0.5 * bend
    rest = value[1:] - value[:-1] - h * (slope[:-1] + h * c2)
    rest1 = h * (slope[1:] - slope[:-1] - 2.0 * h * c2)
    rest2 = h**2 * (bend_at_end - bend)
    c3 = (10.0 * rest - 4.0 * rest1 + 0.5 * rest2) / h**3
    c4 = (-15.0 * rest + 7.0 * rest1 - rest2) / h**4
    c5 = (6.0 * rest - 3.0 * rest1 + 0.5 * rest2) / h**5
    return PPoly(np.stack([c5, c4, c3, c2, slope[:-1], value[:-1]]), knots)


def _joined(parts: list[PPoly]) -> PPoly:
    knots = np.concatenate([parts[0].x, *(part.x[1:] for part in parts[1:])])
    return PPoly(np.concatenate([part.c for part in parts], axis=1), knots)
