"""A proof mass on its spring: a second-order low-pass with a resonance.

Equations (2.1) to (2.5) of the vibration thesis, with the damping that its text adds: the mass'
displacement d obeys ``d'' + 2 ζ ω d' + ω² d = x`` with ``ω² = k / m``, and the output is
``(k / m) d``.  It is exact for a signal that is linear between its dense samples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.linear_filter import LinearFilter, in_intervals

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Resonance(LinearFilter):
    """Natural frequency (Hz), and damping in shares of the critical one.

    The gain at the natural frequency is 1/(2ζ), that at rest one.
    """

    natural_frequency: float
    damping: float
    alone: ClassVar[bool] = True

    @property
    def fastest(self) -> float:
        return self.natural_frequency

    def settled(self, value: float, rate: float) -> Array:  # noqa: ARG002
        return np.array([value, 0.0, value])

    def apply(self, signal: Array, state: Array, rate: float) -> tuple[Array, Array]:
        """``state`` holds the output, its derivative over ω, and the signal's last value."""
        before = np.append(state[2], signal)
        output, slope = self._steps(rate).moved(before[:-1], before[1:], state[:2])
        if len(signal):
            state = np.array([output[-1], slope[-1], signal[-1]])
        return output[1:], state

    def over_intervals(
        self, dense: Array, means: Array, rest: float, rate: float
    ) -> tuple[Array, Array]:
        olds, news = dense[:, :-1].ravel(), dense[:, 1:].ravel()
        states = self._steps(rate).moved(olds, news, np.array([rest, 0.0]))
        output, slope = (in_intervals(own, len(dense)) for own in states)
        # y'' + 2 ζ ω y' + ω² y = ω² x, integrated over an interval.
        duration = (dense.shape[1] - 1) / rate
        inert = 2.0 * self.damping * (output[:, -1] - output[:, 0]) + slope[:, -1] - slope[:, 0]
        return output, means - inert / (2.0 * math.pi * self.natural_frequency * duration)

    def _steps(self, rate: float) -> Steps:
        return Steps.of(2.0 * math.pi * self.natural_frequency / rate, self.damping)


@dataclass(frozen=True)
class Steps:
    """``s[k+1] = turn s[k] + old x[k] + new x[k+1]`` of the output and its derivative over ω."""

    turn: Array
    old: Array
    new: Array

    @classmethod
    @lru_cache(maxsize=64)
    def of(cls, angle: float, damping: float) -> Steps:
        """``angle`` is ω times the interval between the samples."""
        from scipy.linalg import expm

        # The signal and its rise are states as well: it is linear within the step.
        matrix = np.zeros((4, 4))
        matrix[0, 1] = angle
        matrix[1] = [-angle, -2.0 * damping * angle, angle, 0.0]
        matrix[2, 3] = 1.0
        moved = expm(matrix)
        return cls(moved[:2, :2], moved[:2, 2] - moved[:2, 3], moved[:2, 3])

    def moved(self, olds: Array, news: Array, start: Array) -> tuple[Array, Array]:
        """States (n + 1,) and (n + 1,) from ``start`` on under signals that are linear
        from ``olds`` (n,) to ``news`` (n,).

        By Cayley and Hamilton each state obeys the second-order recursion of the matrix'
        trace and determinant.
        """
        from scipy.signal import lfilter

        pushes = np.outer(self.old, olds) + np.outer(self.new, news)
        trace, determinant = np.trace(self.turn), np.linalg.det(self.turn)
        driving = np.column_stack([start, pushes])
        driving[:, 1:] += (self.turn - trace * np.eye(2)) @ driving[:, :-1]
        states = lfilter([1.0], [1.0, -trace, determinant], driving, axis=1)
        return states[0], states[1]
