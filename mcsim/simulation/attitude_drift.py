"""How errors of the attitude grow into position: in a level frame, and on the round earth.

A level system with a tilt ``phi`` takes ``g phi`` of gravity for an acceleration.  In a frame that
neither turns nor curves the position error is ``h(t) = g t^2 / 2`` per unit of a tilt that is there
at ``t = 0``.  On a sphere of radius R the system that moves by mistake turns its own vertical with
it: ``dv/dt = -g phi``, ``dphi/dt = v / R + b`` (Titterton & Weston, *Strapdown Inertial Navigation
Technology*, sect. 12.3), and the response is that of Schuler's pendulum,
``h(t) = R (1 - cos(w t))`` with ``w^2 = g / R``.  Whatever makes the tilt grow follows from ``h``
alone: a bias of the gyroscope by its integral, an angle random walk by that of its square.

Both leave out the earth's rate, which couples the axes within hours, and which a gyroscope that is
not told of it takes for a bias (``EARTH_RATE``).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcsim.simulation.limits import SMALL_TILT
from mcsim.units import STANDARD_GRAVITY

Array = NDArray[np.float64]
#: A time (s), or several, to position per unit of the tilt (m/rad).
Response = Callable[[Array], Array]

#: Mean radius of the earth (m), and its rate against the stars (rad/s): 15.04 degrees per hour.
EARTH_RADIUS, EARTH_RATE = 6_371_000.0, 7.292115e-5
#: Frequency (rad/s) and period (s) of a Schuler pendulum: 84.4 minutes.
SCHULER = math.sqrt(STANDARD_GRAVITY / EARTH_RADIUS)
SCHULER_PERIOD = 2.0 * math.pi / SCHULER
#: Nodes of the integrals; the integrands have few waves within hours.
_NODES = 48
#: A share of disagreement with the round earth that is worth a word.
STATED = 0.05


def on_level_ground(time: Array) -> Array:
    """Position (m) per unit tilt (rad) after ``time`` (s), in a level frame: ``g t^2 / 2``."""
    return 0.5 * STANDARD_GRAVITY * np.square(time)


def on_round_earth(time: Array) -> Array:
    """The same on a sphere: ``R (1 - cos(w t))``, written so that short times keep their digits."""
    return np.asarray(2.0 * EARTH_RADIUS * np.sin(0.5 * SCHULER * np.asarray(time)) ** 2)


@dataclass(frozen=True)
class Growth:
    """How one kind of error of the attitude grows.

    Attributes
    ----------
    position : callable
        ``position(response, time)``: what it has become after ``time`` (s), a number, per unit.
    tilt : callable
        Tilt after ``time`` per unit.
    """

    position: Callable[[Response, float], float]
    tilt: Callable[[float], float]


def _at_once(response: Response, time: float) -> float:
    return float(response(np.asarray(time)))


def _half_way(response: Response, time: float) -> float:
    return 2.0 * _at_once(response, 0.5 * time)


def _summed(response: Response, time: float) -> float:
    nodes, weights = _quadrature(time)
    return float(weights @ response(nodes))


def _walked(response: Response, time: float) -> float:
    nodes, weights = _quadrature(time)
    return math.sqrt(float(weights @ response(nodes) ** 2))


def _quadrature(time: float) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights over 0 ... ``time``."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    return 0.5 * time * (nodes + 1.0), 0.5 * time * weights


#: A tilt (rad): ``g t^2 / 2``.
TILT = Growth(_at_once, lambda _: 1.0)
#: A turn rate (rad/s) that the gyroscope reads and that is none: ``g t^3 / 6``.
TURN_RATE = Growth(_summed, lambda time: time)
#: An angle random walk (rad/sqrt(s), two-sided): ``g sqrt(t^5 / 20)``.
ANGLE_RANDOM_WALK = Growth(_walked, math.sqrt)
#: An accelerometer's offset that levelling has turned into a tilt (rad), which cancels it for as
#: long as the vehicle does not turn; then the same after turning round half-way.
LEVELLED = Growth(lambda _, __: 0.0, lambda _: 1.0)
LEVELLED_AND_TURNED = Growth(_half_way, lambda _: 1.0)


def excess(growth: Growth, time: float) -> float:
    """By which share the level frame makes more of an error than the round earth; zero for none."""
    level = growth.position(on_level_ground, time)
    if level == 0.0:
        return 0.0
    return level / growth.position(on_round_earth, time) - 1.0


def lasts(growth: Growth, share: float) -> float:
    """The time (s) up to which the level frame makes at most this ``share`` more of an error.

    Looked for within half a Schuler period, where that of a tilt has grown to 147 %.
    """
    from scipy.optimize import brentq

    ends = (1.0, 0.5 * SCHULER_PERIOD)
    return float(brentq(lambda time: excess(growth, time) - share, *ends, xtol=1e-6))


@dataclass(frozen=True)
class Source:
    """One way of being tilted.

    Attributes
    ----------
    group, name : str
        For people.
    growth : Growth
    size : float
        SI; what ``growth`` is multiplied by.
    written : mapping
        What the scenario ``attitude_drift`` takes for it.
    printed : mapping
        Positions (m) that the note prints, by time (s).
    turned : bool
        Whether the vehicle turns round half-way.
    """

    group: str
    name: str
    growth: Growth
    size: float
    written: dict[str, Any] = field(default_factory=dict)
    printed: dict[float, float] = field(default_factory=dict)
    turned: bool = False


@dataclass(frozen=True)
class Drift:
    """One entry: a source after some time (s); position errors in m, tilt in rad.

    ``low`` and ``high`` bound ``simulated``; these three are NaN where nothing was simulated, and
    ``printed`` where the note prints nothing.
    """

    source: Source
    time: float
    printed: float
    simulated: float
    low: float
    high: float

    @property
    def tilt(self) -> float:
        """One standard deviation by then."""
        return self.source.size * self.source.growth.tilt(self.time)

    @property
    def flat(self) -> float:
        """The closed form in the level frame."""
        return self.source.size * self.source.growth.position(on_level_ground, self.time)

    @property
    def round_earth(self) -> float:
        """The closed form on a sphere."""
        return self.source.size * self.source.growth.position(on_round_earth, self.time)

    @property
    def note(self) -> str:
        """What a closed form is not to be trusted with."""
        if self.tilt > SMALL_TILT:
            return "tilt no longer small: both closed forms fail"
        more = excess(self.source.growth, self.time)
        if more > 1.0:
            return f"flat {1.0 + more:.1f} times as large"
        return f"flat {more:.0%} too large" if more > STATED else ""
