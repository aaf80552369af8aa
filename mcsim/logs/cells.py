"""Numbers as tables write them: decimal point or comma, groups of thousands, minus signs."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

#: What separates groups of three digits beside the sign that is not the decimal one.
_BLANKS = " '\N{RIGHT SINGLE QUOTATION MARK}\N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}"
_EXPONENT = r"(?:[eE][-+]?\d+)?"
_PLAIN = re.compile(rf"[-+]?(?:\d+\.?\d*|\.\d+){_EXPONENT}")
#: A comma that can only be a decimal one: not before exactly three digits, after a zero, after
#: more than three digits, or after groups that a point separates.
_DECIMAL_COMMA = re.compile(
    rf"[-+]?(?:(?:\d*,(?!\d{{3}}$)\d*|(?:0\d*|\d{{4,}}),\d+){_EXPONENT}"
    rf"|\d+,\d+[eE][-+]?\d+|\d{{1,3}}(?:\.\d{{3}})+,\d*)"
)
#: Groups that a comma separates, known by the point after them or by there being two.
_GROUPS = re.compile(r"[-+]?[1-9]\d{0,2}(?:(?:,\d{3})+\.\d*|(?:,\d{3}){2,})")
#: One comma before three digits: 1,234 is either.
_EITHER = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}")
_BLANK_GROUP = re.compile(rf"(?<=\d)[{_BLANKS}](?=\d{{3}})")
#: What programs write besides that for a value that they do not know.
WRITTEN = ("--", "---", "***", "?", "n.a.", "#NV", "#nv", "unknown", "invalid")
_NOTHING = ("", "-", "nan", "null", "none", "na", "n/a", "#n/a", "inf", "+inf", "-inf", *WRITTEN)


class Notation(Enum):
    """Which sign stands before the fraction."""

    POINT = "."
    COMMA = ","

    @property
    def groups(self) -> str:
        """Signs that may separate groups of three digits."""
        return _BLANKS + ("," if self is Notation.POINT else ".")


@dataclass(frozen=True)
class Seen:
    """What cells say about their notation.

    ``certain`` where one of them shows it; ``open`` where 1,234 could be either number.
    """

    notation: Notation
    certain: bool = False
    open: bool = False


def notation_of(cells: Iterable[str]) -> Seen:
    """The notation that the cells of a table show."""
    comma = point = either = False
    for cell in map(plain_signs, cells):
        cell = _BLANK_GROUP.sub("", cell)
        if "," in cell:
            comma = comma or _DECIMAL_COMMA.fullmatch(cell) is not None
            point = point or _GROUPS.fullmatch(cell) is not None
            either = either or _EITHER.fullmatch(cell) is not None
        elif "." in cell and not point:
            # 1.234 may be a group; 0.1, 12.34 and 1234.567 may not.
            point = _number(cell, Notation.POINT) is not None and not re.fullmatch(
                r"[-+]?[1-9]\d{0,2}(\.\d{3})+", cell
            )
    if comma and not point:
        return Seen(Notation.COMMA, certain=True)
    return Seen(Notation.POINT, certain=point, open=either and not point)


def plain_signs(cell: str) -> str:
    """A cell without blanks around it, its minus sign as programs write it."""
    return cell.strip().replace("\N{MINUS SIGN}", "-")


def number(cell: str, notation: Notation) -> float | None:
    """The number that a cell holds, perhaps with groups of thousands; None if it is none."""
    return _number(plain_signs(cell), notation)


def holds_nothing(cell: str) -> bool:
    """Whether a cell is empty or says that there is no value."""
    return cell.strip().casefold() in _NOTHING


def _number(text: str, notation: Notation) -> float | None:
    if notation is Notation.POINT and _PLAIN.fullmatch(text):
        return float(text)
    whole, sign, fraction = text.partition(notation.value)
    for group in notation.groups:
        if group in whole:
            if not re.fullmatch(rf"[-+]?[1-9]\d{{0,2}}(?:{re.escape(group)}\d{{3}})+", whole):
                return None
            whole = whole.replace(group, "")
            break
    text = f"{whole}.{fraction}" if sign else whole
    return float(text) if _PLAIN.fullmatch(text) else None
