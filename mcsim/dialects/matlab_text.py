"""MATLAB text: its tokens, its statements, and the plain arithmetic in them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from mcsim.dialects.arithmetic import CONSTANTS, NotPlain, Value, call, combine

_NUMBER = re.compile(r"(?:\d+(?:\.(?![*/^\\'])\d*)?|\.\d+)(?:[eEdD][-+]?\d+)?")
_NAME = re.compile(r"[A-Za-z]\w*")
_STRING = re.compile(r"'(?:[^'\n]|'')*'|\"(?:[^\"\n]|\"\")*\"")
_SIGN = re.compile(r"\.[*/^\\']|==|~=|<=|>=|&&|\|\||[^\s]")
_BLOCK_COMMENT = re.compile(r"(?ms)^[ \t]*%\{[ \t]*$.*?^[ \t]*%\}[ \t]*$")
_CONTINUATION = re.compile(r"\.\.\.[^\n]*\n?")
_OPENING, _CLOSING = "([{", ")]}"
#: What a value may end with: a quote right behind it transposes.
_ENDS_VALUE = (*_CLOSING, "'", ".'")
_DEEPEST = 50


class Token(NamedTuple):
    """``kind`` is number, name, string or sign; ``spaced`` whether a blank stands before it."""

    kind: str
    text: str
    line: int
    spaced: bool


def tokens(text: str) -> Iterator[Token]:
    """The tokens of a text; comments and continuations are left out, a line end is a sign."""
    text = _BLOCK_COMMENT.sub(lambda m: "\n" * m[0].count("\n"), text.replace("\r\n", "\n"))
    place, line, spaced = 0, 1, False
    previous: Token | None = None
    while place < len(text):
        character = text[place]
        if character in " \t":
            place, spaced = place + 1, True
            continue
        if character in "%#":
            end = text.find("\n", place)
            place = len(text) if end < 0 else end
            continue
        continued = _CONTINUATION.match(text, place)
        if continued is not None:
            place, line, spaced = continued.end(), line + 1, True
            continue
        kind, found = ("sign", "\n") if character == "\n" else _token(text, place, previous, spaced)
        previous = Token(kind, found, line, spaced)
        yield previous
        place, spaced = place + len(found), False
        line += found == "\n"


def _token(text: str, place: int, previous: Token | None, spaced: bool) -> tuple[str, str]:
    follows_value = previous is not None and (
        previous.kind != "sign" or previous.text in _ENDS_VALUE
    )
    for kind, pattern in (("number", _NUMBER), ("name", _NAME), ("string", _STRING)):
        match = pattern.match(text, place)
        if match is None:
            continue
        if kind == "string" and text[place] == "'" and follows_value and not spaced:
            continue  # a transpose
        if kind == "number" and text[place] == "." and follows_value and not spaced:
            continue  # a field
        return kind, match[0]
    match = _SIGN.match(text, place)
    return "sign", match[0] if match is not None else text[place]


def statements(text: str) -> Iterator[list[Token]]:
    """The tokens of one statement each; a line end within brackets ends no statement."""
    statement: list[Token] = []
    open_: list[str] = []
    for token in tokens(text):
        if token.kind == "sign":
            if token.text in _OPENING:
                open_.append(token.text)
            elif token.text in _CLOSING and open_:
                open_.pop()
            elif not open_ and token.text in "\n;,":
                if statement:
                    yield statement
                statement = []
                continue
            elif token.text == "\n":
                if open_[-1] == "(":
                    continue
                token = token._replace(text=";")  # the next row of a matrix
        statement.append(token)
    if statement:
        yield statement


def split_arguments(inner: Sequence[Token]) -> list[list[Token]]:
    """Arguments between commas, of the tokens within a call's brackets."""
    arguments: list[list[Token]] = [[]]
    depth = 0
    for token in inner:
        if token.kind == "sign":
            depth += (token.text in _OPENING) - (token.text in _CLOSING)
            if token.text == "," and depth == 0:
                arguments.append([])
                continue
        arguments[-1].append(token)
    return [] if arguments == [[]] else arguments


def closing(statement: Sequence[Token], opening: int) -> int | None:
    """The place of the bracket that closes the one at ``opening``; None if none does."""
    depth = 0
    for place in range(opening, len(statement)):
        token = statement[place]
        if token.kind == "sign":
            depth += (token.text in _OPENING) - (token.text in _CLOSING)
            if depth == 0:
                return place
    return None


def shown(expression: Sequence[Token]) -> str:
    """The tokens as they were written, but for their blanks."""
    text = "".join((" " if t.spaced and i else "") + t.text for i, t in enumerate(expression))
    return text if len(text) < 60 else text[:57] + "…"


def evaluate(expression: Sequence[Token], variables: Mapping[str, Value | None]) -> Value:
    """The value of plain arithmetic with numbers, vectors and known variables.

    Raises
    ------
    NotPlain
        Something else; the message names it.
    """
    parser = _Parser(expression, variables)
    value = parser.sum(in_matrix=False)
    if parser.place < len(expression):
        raise NotPlain(f"`{parser.next_text()}`")
    return value


class _Parser:
    """Precedence climbing: sums, products, signs, powers, transposes, in MATLAB's order."""

    def __init__(self, expression: Sequence[Token], variables: Mapping[str, Value | None]) -> None:
        self.expression = expression
        self.variables = variables
        self.place = 0
        self.depth = 0

    def next_text(self) -> str:
        at_end = self.place >= len(self.expression)
        return "" if at_end else self.expression[self.place].text

    def _next_is_sign(self, signs: Sequence[str]) -> bool:
        return (
            self.place < len(self.expression)
            and self.expression[self.place].kind == "sign"
            and self.expression[self.place].text in signs
        )

    def sum(self, in_matrix: bool) -> Value:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise NotPlain("so deep a nesting")
        value = self._product(in_matrix)
        while self._next_is_sign("+-") and not (in_matrix and self._begins_element()):
            sign = self.next_text()
            self.place += 1
            value = combine(sign, value, self._product(in_matrix))
        self.depth -= 1
        return value

    def _begins_element(self) -> bool:
        """Whether a sign within a matrix belongs to the next element: ``[1 -2]``."""
        token = self.expression[self.place]
        behind = self.expression[self.place + 1 : self.place + 2]
        return token.spaced and bool(behind) and not behind[0].spaced

    def _product(self, in_matrix: bool) -> Value:
        value = self._signed(in_matrix)
        while self._next_is_sign(("*", "/", ".*", "./")):
            sign = self.next_text()
            self.place += 1
            factor = self._signed(in_matrix)
            both = isinstance(value, tuple) and isinstance(factor, tuple)
            if (both and "." not in sign) or (sign == "/" and isinstance(factor, tuple)):
                raise NotPlain(f"a product of matrices; write .{sign}")
            value = combine(sign[-1], value, factor)
        return value

    def _signed(self, in_matrix: bool) -> Value:
        if self._next_is_sign("+-"):
            sign = -1.0 if self.next_text() == "-" else 1.0
            self.place += 1
            self.depth += 1
            if self.depth > _DEEPEST:
                raise NotPlain("so deep a nesting")
            value = combine("*", sign, self._signed(in_matrix))
            self.depth -= 1
            return value
        return self._power()

    def _power(self) -> Value:
        value = self._primary()
        while self._next_is_sign(("^", ".^", "'", ".'")):
            sign = self.next_text()
            self.place += 1
            if sign.endswith("'"):
                continue  # a column has the same values
            minus = 1.0
            while self._next_is_sign("+-"):
                minus *= -1.0 if self.next_text() == "-" else 1.0
                self.place += 1
            exponent = self._primary()
            if sign == "^" and (isinstance(value, tuple) or isinstance(exponent, tuple)):
                raise NotPlain("a power of a matrix; write .^")
            value = combine("^", value, combine("*", minus, exponent))
        return value

    def _primary(self) -> Value:
        if self.place >= len(self.expression):
            raise NotPlain("an expression that is cut off")
        token = self.expression[self.place]
        self.place += 1
        if token.kind == "number":
            return combine("*", 1.0, float(token.text.lower().replace("d", "e")))
        if token.kind == "name":
            return self._named(token)
        if token.text == "(":
            value = self.sum(in_matrix=False)
            self._close(")")
            return value
        if token.text == "[":
            return self._matrix()
        raise NotPlain(f"`{token.text}`")

    def _close(self, bracket: str) -> None:
        if not self._next_is_sign(bracket):
            raise NotPlain(f"`{self.next_text()}`" if self.next_text() else "an open bracket")
        self.place += 1

    def _named(self, token: Token) -> Value:
        name = token.text
        while self._next_is_sign(".") and self.place + 1 < len(self.expression):
            name += "." + self.expression[self.place + 1].text
            self.place += 2
        if name in self.variables:
            value = self.variables[name]
            if value is None:
                raise NotPlain(f"`{name}`, whose value is not plain arithmetic")
            if self._next_is_sign("("):
                raise NotPlain(f"an element of `{name}`")
            return value
        if self._next_is_sign("("):
            self.place += 1
            arguments = []
            while not self._next_is_sign(")"):
                arguments.append(self.sum(in_matrix=False))
                if not self._next_is_sign(")"):
                    self._close(",")
            self.place += 1
            return call(name, arguments)
        if name not in CONSTANTS:
            raise NotPlain(f"`{name}`, which is not set in this file")
        return CONSTANTS[name]

    def _matrix(self) -> Value:
        """A row or a column."""
        elements: list[float] = []
        parts = 0
        while not self._next_is_sign("]"):
            if self._next_is_sign(",;"):
                self.place += 1
                continue
            value = self.sum(in_matrix=True)
            elements += value if isinstance(value, tuple) else (value,)
            parts += 1
            if parts > 9:
                raise NotPlain("a matrix")
        self.place += 1
        if not elements:
            raise NotPlain("an empty matrix")
        return tuple(elements) if len(elements) > 1 else elements[0]
