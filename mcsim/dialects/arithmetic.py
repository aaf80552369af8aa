"""Plain arithmetic that foreign files write in place of a number: never more than that.

Values are numbers or vectors of numbers.  Python and MATLAB differ in grammar and precedence,
which their readers keep; what an operator or a function does is said here, once.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence

Value = float | tuple[float, ...]

CONSTANTS: Mapping[str, float] = {"pi": math.pi, "inf": math.inf, "Inf": math.inf}
_OPERATORS: Mapping[str, Callable[[float, float], float]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "^": operator.pow,
}
_FUNCTIONS: Mapping[str, Callable[[float], float]] = {
    "deg2rad": math.radians,
    "radians": math.radians,
    "rad2deg": math.degrees,
    "degrees": math.degrees,
    "sqrt": math.sqrt,
    "abs": abs,
    "float": float,
}
_LARGEST_VECTOR = 9


class NotPlain(Exception):
    """What is written is not plain arithmetic; the message says what it is."""


def combine(sign: str, left: Value, right: Value) -> Value:
    """``left sign right``, element by element; a number counts for every element.

    Raises
    ------
    NotPlain
        Another operator, vectors of different length, or no finite real result.
    """
    if sign not in _OPERATORS:
        raise NotPlain(f"the operator {sign}")
    if isinstance(left, float) and isinstance(right, float):
        return _real(_OPERATORS[sign], left, right)
    n = max(len(v) for v in (left, right) if isinstance(v, tuple))
    vectors = [v if isinstance(v, tuple) else (v,) * n for v in (left, right)]
    if len(vectors[0]) != len(vectors[1]):
        raise NotPlain("vectors of different length")
    return tuple(_real(_OPERATORS[sign], a, b) for a, b in zip(*vectors, strict=True))


def call(name: str, arguments: Sequence[Value]) -> Value:
    """A function of the short list that both languages have.

    Raises
    ------
    NotPlain
        None of them, or not with such arguments.
    """
    if name in _FUNCTIONS and len(arguments) == 1:
        value = arguments[0]
        if isinstance(value, tuple):
            return tuple(_real(_FUNCTIONS[name], item) for item in value)
        return _real(_FUNCTIONS[name], value)
    if name in ("ones", "zeros") and len(arguments) in (1, 2):
        return (1.0 if name == "ones" else 0.0,) * _length(arguments)
    if name == "repmat" and len(arguments) == 3 and isinstance(arguments[0], float):
        return (arguments[0],) * _length(arguments[1:])
    if name == "full" and len(arguments) == 2 and isinstance(arguments[1], float):
        return (arguments[1],) * _length(arguments[:1])
    raise NotPlain(f"the function {name}")


def _length(sizes: Sequence[Value]) -> int:
    """Of a row or a column of that size."""
    plain = [size for size in sizes if isinstance(size, float)]
    length = math.prod(plain)
    if (
        len(plain) != len(sizes)
        or length not in range(1, _LARGEST_VECTOR + 1)
        or (len(plain) == 2 and 1.0 not in plain)
    ):
        raise NotPlain("a matrix")
    return int(length)


def _real(function: Callable[..., float], *arguments: float) -> float:
    try:
        value = function(*arguments)
    except (ArithmeticError, ValueError):
        raise NotPlain("a result that is no finite number") from None
    if isinstance(value, complex) or math.isnan(value):
        raise NotPlain("a result that is no real number")
    return value
