"""White noise, as data sheets or as an Allan deviation tell it."""

from mcsim.sensor_terms.mechanisms.white import NOISE, White
from mcsim.sensor_terms.term import SensorKey, SensorTerm
from mcsim.units import density_from_random_walk

_DENSITY = SensorKey(
    "noise_density",
    "{signal} noise density",
    "White noise, one-sided density as data sheets print it.",
)
_AS_WALK = "White noise as Allan's N (two-sided), instead of `noise_density`."


def _acts(noise_density: float = 0.0, walk: float | None = None) -> White:
    return White(noise_density if walk is None else density_from_random_walk(1.0) * walk)


TERM = SensorTerm(
    NOISE,
    _acts,
    (_DENSITY, SensorKey("velocity_random_walk", "velocity random walk", _AS_WALK, "walk")),
    (_DENSITY, SensorKey("angle_random_walk", "angle random walk", _AS_WALK, "walk")),
    alternatives=True,
)
