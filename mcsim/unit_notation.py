"""The notation of units: from ``(m/s)/√h`` or ``m s^-1.5`` to powers of its signs.

Two spellings of one unit have the same powers; what the signs are worth is none of this
module's business.  ``Hz`` and ``1/s`` stay apart, since a data sheet's ``m/s²/√Hz`` and Allan's
``m/s/√s`` are different quantities of one dimension.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction

#: Powers of signs, in the order of the signs: ``m/s²`` is (("m", 1), ("s", -2)).
Powers = tuple[tuple[str, Fraction], ...]

_RAISED = str.maketrans("⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹⁄ᐟ·⋅", "-+0123456789//..")
_EXPONENT = re.compile(r"\^?([⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+(?:[⁄ᐟ/·⋅.][⁰¹²³⁴⁵⁶⁷⁸⁹]+)?|½)")
#: An exponent in plain digits: ``^-1/2``, ``^(3/2)``, ``^{1.5}``, and the 2 of ``m/s2``.
_POWER = re.compile(
    r"\^\s*(?:[({]\s*([-+−]?\d+(?:\.\d+)?(?:\s*/\s*\d+)?)\s*[)}]"
    r"|([-+−]?(?:[13]\s*/\s*2(?![\w.])|\d+(?:\.\d+)?)))"
)
_WORD = re.compile(r"[A-Za-zµσ°%]+")
#: ``root-Hz``, ``rt(Hz)``, ``sqrt Hz``.
_ROOT = re.compile(
    r"(?<![A-Za-zµ])(?:square[\s-]*root|sqrt|root|rt)[\s-]*(?:of\s+)?"
    r"(?=[({√]|hz|hr|hour|h(?![A-Za-zµ])|sec|s(?![A-Za-zµ]))",
    re.I,
)
#: What a deviation may be called beside its unit.
_QUALIFIER = re.compile(r"[\s,;(\[-]*(?<![A-Za-zµ])(?:rms|1\s*(?:σ|sigma|-sigma))[\s)\]]*$", re.I)


def plain_quantity(unit: str) -> str:
    """The unit without ``rms`` or ``(1σ)``, which only say that it is a standard deviation's."""
    return _QUALIFIER.sub("", unit) if unit.strip() else unit


def powers(text: str, words: Mapping[str, str]) -> Powers | None:
    """The powers of the signs of a unit; None where it is not one or could be two.

    ``words`` maps other names of a sign to the sign, or to a unit of signs (``dps``: ``°/s``).
    A product after a stroke (``m/s·√h``) is refused: it is read in two ways.
    """
    text = _ROOT.sub("√", re.sub(r"(?<![A-Za-zµ])per(?![A-Za-zµ])", "/", text))
    text = re.sub(r"√[\s-]+", "√", text).replace("−", "-")
    parser = _Parser(text, words)
    found = parser.product()
    if found is None or parser.rest.strip():
        return None
    return tuple(sorted((sign, power) for sign, power in found.items() if power))


class _Parser:
    """Recursive descent over ``rest``; every method gives None where it does not fit."""

    def __init__(self, rest: str, words: Mapping[str, str]) -> None:
        self.rest = rest
        self.words = words

    def _take(self, pattern: str | re.Pattern[str]) -> re.Match[str] | None:
        match = re.match(pattern, self.rest)
        if match is not None:
            self.rest = self.rest[match.end() :]
        return match

    def product(self, depth: int = 0) -> dict[str, Fraction] | None:
        if depth > 5:
            return None
        found: dict[str, Fraction] = {}
        divided = False
        sign = 1
        while True:
            factor = self._factor(depth)
            if factor is None:
                return None
            for name, power in factor.items():
                found[name] = found.get(name, Fraction(0)) + sign * power
            if self._take(r"\s*/\s*"):
                sign, divided = -1, True
            elif re.match(r"\s*[)}\]]|\s*$", self.rest):
                return found
            elif divided:
                return None
            else:
                self._take(r"\s*[*·⋅×.-]?\s*")

    def _factor(self, depth: int) -> dict[str, Fraction] | None:
        self._take(r"\s+")
        root = Fraction(1, 2) if self._take("√") else Fraction(1)
        base = self._base(depth)
        if base is None:
            return None
        exponent = self._exponent()
        return {name: power * root * exponent for name, power in base.items()}

    def _base(self, depth: int) -> dict[str, Fraction] | None:
        if self._take(r"[(\[{]\s*"):
            inner = self.product(depth + 1)
            return inner if self._take(r"\s*[)\]}]") else None
        word = self._take(_WORD)
        if word is None:
            return None
        sign = self.words.get(word[0], word[0])
        if re.fullmatch(_WORD, sign):
            return {sign: Fraction(1)}
        return _Parser(sign, {}).product(depth + 1)

    def _exponent(self) -> Fraction:
        raised = self._take(_EXPONENT)
        if raised is not None:
            return Fraction(1, 2) if raised[1] == "½" else Fraction(raised[1].translate(_RAISED))
        written = self._take(_POWER)
        if written is not None:
            text = re.sub(r"\s", "", written[1] or written[2]).replace("−", "-")
            numerator, _, denominator = text.partition("/")
            if denominator and not int(denominator):
                return Fraction(0)
            return Fraction(numerator) / Fraction(denominator or 1)
        behind = self._take(r"[23](?![\d.])")  # m/s2
        return Fraction(behind[0]) if behind is not None else Fraction(1)
