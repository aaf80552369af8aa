"""Does the log look like what its header says?"""

from __future__ import annotations

import numpy as np

from mcsim.errors import InputError
from mcsim.logs.model import ACCELEROMETER, AXES, Channel
from mcsim.units import STANDARD_GRAVITY

#: Gravity at rest, scale errors of cheap sensors included.
_TOLERANCE = 0.1
#: Units that an accelerometer's numbers may truly have, with the gravity they show.
_TRUE_UNITS = {"g": 1.0, "mg": 1000.0, "m/s²": STANDARD_GRAVITY, "mm/s²": 9806.65, "µg": 1e6}
#: Means (m/s²) that show no gravity, and those that no rest shows, whatever the scale error.
_NO_GRAVITY, _BEYOND_REST = 0.5, 5.0 * STANDARD_GRAVITY


def check_gravity(channels: list[Channel], unit: str, unit_si: float, where: str) -> str | None:
    """A sentence about gravity, where three accelerometer axes show it.

    ``unit`` is what the header says and ``unit_si`` its value in m/s².

    Raises
    ------
    InputError
        The numbers have the magnitude of gravity in another unit, or are far beyond it.
    """
    means = [float(c.samples.mean()) for c in channels if c.element == ACCELEROMETER]
    if len(means) < len(AXES):
        return None
    magnitude = float(np.linalg.norm(means))
    if _near(magnitude, STANDARD_GRAVITY):
        return None
    if magnitude < _NO_GRAVITY:
        return "no gravity in the accelerations: their unit cannot be checked"
    shown = magnitude / unit_si
    for other, gravity in _TRUE_UNITS.items():
        if other != unit and _near(shown, gravity):
            raise InputError(
                f"{where}: the accelerometer's unit is said to be {unit}, but its mean at rest "
                f"is {shown:.4g}: that is gravity in {other}; state it by --units "
                f"accelerometer={other}"
            )
    if magnitude > _BEYOND_REST:
        raise InputError(
            f"{where}: the accelerometer's mean is {magnitude:.4g} m/s², where rest shows "
            f"9.81 m/s²; its unit is said to be {unit}: state the right one by --units "
            f"accelerometer=…, for counts of the converter with the data sheet's sensitivity, near "
            f"--units 'accelerometer={shown:.3g} counts/g'"
        )
    return (
        f"the accelerometer's mean is {magnitude:.4g} m/s², where rest shows 9.81 m/s²: "
        "check its unit and scale"
    )


def _near(value: float, wanted: float) -> bool:
    return abs(value / wanted - 1.0) < _TOLERANCE
