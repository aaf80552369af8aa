"""Numbers as text that come back the same from any unit and dialect."""

from __future__ import annotations

import math

#: (digits, tolerance in units of the last place): a result that is so near to a number of so
#: few digits was that number before its unit was converted.  The tolerance for few digits is
#: the larger one, so that a number that came near by chance on the way there (in 12 digits,
#: once in a thousand) is still recognised on the way back.
_TIERS = ((10, 16), (12, 6))


def tidy(value: float) -> float:
    """``value`` without the last-digit noise of unit conversions.

    A number of up to 12 digits that is converted to another unit and back is itself again;
    one of more digits keeps them all, and comes back within some units of the last place.
    """
    for digits, tolerance in _TIERS:
        short = float(f"{value:.{digits}g}")
        if abs(short - value) <= tolerance * math.ulp(value):
            return short
    return value


def number(value: float) -> str:
    """Shortest text that reads back as ``tidy(value)``, with a decimal point.

    YAML 1.1 readers (PyYAML, hence Kalibr) take ``1e-05`` for a word; ``1.0e-05`` is a number
    everywhere.
    """
    text = repr(tidy(value))
    mantissa, e, exponent = text.partition("e")
    if e and "." not in mantissa:
        mantissa += ".0"
    return mantissa + e + exponent
