"""What a MATLAB script sets of ``accelparams`` and ``gyroparams``, statement by statement.

Read are calls with name-value pairs, properties set afterwards (``gyro.NoiseDensity = …``,
``imu.Gyroscope.NoiseDensity = …``) and the variables in them, in the order in which they run.
Whatever else could change a parameter is refused, and named.
"""

from __future__ import annotations

import difflib
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from mcsim.dialects.arithmetic import NotPlain, Value
from mcsim.dialects.matlab_text import (
    Token,
    closing,
    evaluate,
    shown,
    split_arguments,
    statements,
)
from mcsim.errors import InputError

FUNCTIONS = {"accelparams": "accelerometer", "gyroparams": "gyroscope"}
#: Properties of ``imuSensor`` that hold an element's parameters.
_OWNERS = {"Accelerometer": "accelerometer", "Gyroscope": "gyroscope"}
_BLOCKS = ("if", "for", "while", "switch", "try", "parfor")


@dataclass(frozen=True)
class Property:
    """A value that was set: numbers, a text, or None where it is neither; and where."""

    value: Value | str | None
    place: str


@dataclass
class Script:
    """``elements`` maps an element to its properties; ``known`` are their names.

    ``needed`` are those whose value must be understood.
    """

    source: str
    known: Collection[str]
    needed: Collection[str]
    elements: dict[str, dict[str, Property]] = field(default_factory=dict)
    _variables: dict[str, Value | None] = field(default_factory=dict)
    _targets: dict[str, str] = field(default_factory=dict)
    _made_at: dict[str, int] = field(default_factory=dict)
    _copies: set[str] = field(default_factory=set)
    _blocks: int = 0

    def run(self, text: str) -> None:
        """Read a script.

        Raises
        ------
        InputError
            A parameter's value, or a statement about parameters, is not understood.
        """
        for statement in statements(text):
            self._statement(statement)

    def _fail(self, token: Token, what: str) -> InputError:
        return InputError(f"{self.source}:{token.line}: {what}")

    def _statement(self, statement: list[Token]) -> None:
        first = statement[0]
        if first.kind == "name" and first.text in _BLOCKS:
            self._blocks += 1
            self._forget(statement)
        elif first.kind == "name" and first.text == "end" and len(statement) == 1:
            self._blocks = max(0, self._blocks - 1)
        target, right = _assignment(statement)
        calls = [i for i, token in enumerate(statement) if _is_function(token)]
        for place in calls:
            self._call(statement, place)
        if calls:
            if target and right and _is_function(right[0]):
                self._targets[target] = FUNCTIONS[right[0].text]
        elif right is not None:
            self._assign(statement, target, right)
        elif first.text == "set" and len(statement) > 2:
            self._refuse_change(statement, statement[2].text)

    def _forget(self, statement: Sequence[Token]) -> None:
        """Variables that a branch or a loop sets have no one value."""
        for token, behind in pairwise(statement):
            if token.kind == "name" and behind.text == "=":
                self._variables[token.text] = None

    def _assign(self, statement: list[Token], target: str | None, right: list[Token]) -> None:
        if target is None:
            self._assign_part(statement)
            return
        owner, _, name = target.rpartition(".")
        element = self._targets.get(owner) or self._owned(statement, owner, name)
        if element is not None:
            self._refuse_in_block(statement[0])
            self._set(element, statement[0], name, right)
            return
        if owner in self._copies and name in self.known:
            raise self._fail(statement[0], f"`{target}`: set on a copy of the parameters")
        self._remember(target, right)

    def _owned(self, statement: list[Token], owner: str, name: str) -> str | None:
        """The element behind ``imu.Gyroscope`` where nothing else made one."""
        element = _OWNERS.get(owner.rpartition(".")[2])
        if element is None or name not in self.known or owner in self._copies:
            return None
        if element in self._made_at:
            raise self._fail(
                statement[0],
                f"`{owner}.{name}`: parameters of the {element} were made in line "
                f"{self._made_at[element]} too; keep one of the two",
            )
        self._made_at[element] = statement[0].line
        self._targets[owner] = element
        return element

    def _remember(self, target: str, right: list[Token]) -> None:
        if shown(right) in self._targets or shown(right) in self._copies:
            self._copies.add(target)
            return
        try:
            self._variables[target] = evaluate(right, self._variables) if not self._blocks else None
        except NotPlain:
            self._variables[target] = None

    def _assign_part(self, statement: list[Token]) -> None:
        """``x(2) = …``, ``[a, b] = …``, ``gyro.NoiseDensity(3) = …``."""
        equals = next(i for i, token in enumerate(statement) if token.text == "=")
        for place, token in enumerate(statement[:equals]):
            if token.kind == "name":
                self._refuse_change(statement, _dotted(statement[place:equals]))
                self._variables[token.text] = None
                self._variables[_dotted(statement[place:equals])] = None

    def _refuse_change(self, statement: list[Token], name: str) -> None:
        owners = [t for t in (*self._targets, *self._copies) if f"{name}.".startswith(f"{t}.")]
        if owners or name.rpartition(".")[0].rpartition(".")[2] in _OWNERS:
            raise self._fail(
                statement[0], f"`{shown(statement)}`: this change of the parameters is not read"
            )

    def _refuse_in_block(self, token: Token) -> None:
        if self._blocks:
            raise self._fail(token, "parameters that a branch or a loop sets are not read")

    def _call(self, statement: list[Token], place: int) -> None:
        function = statement[place]
        element = FUNCTIONS[function.text]
        self._refuse_in_block(function)
        if element in self._made_at:
            raise self._fail(
                function,
                f"{function.text}: parameters of the {element} were made in line "
                f"{self._made_at[element]} too; keep one of the two",
            )
        self._made_at[element] = function.line
        self.elements[element] = {}
        if place + 1 == len(statement) or statement[place + 1].text != "(":
            return
        end = closing(statement, place + 1)
        if end is None:
            raise self._fail(function, f"{function.text}: its bracket is not closed")
        self._pairs(element, function, split_arguments(statement[place + 2 : end]))

    def _pairs(self, element: str, function: Token, arguments: list[list[Token]]) -> None:
        rest = list(arguments)
        while rest:
            argument = rest.pop(0)
            if len(argument) > 1 and argument[0].kind == "name" and argument[1].text == "=":
                self._set(element, argument[0], argument[0].text, argument[2:])
            elif len(argument) == 1 and argument[0].kind == "string" and rest:
                self._set(element, argument[0], argument[0].text[1:-1], rest.pop(0))
            else:
                token = argument[0] if argument else function
                raise self._fail(
                    token,
                    f"{function.text}: `{shown(argument)}` is no name with its value; "
                    "write 'NoiseDensity', 1e-3",
                )

    def _set(self, element: str, token: Token, name: str, right: list[Token]) -> None:
        function = next(f for f, e in FUNCTIONS.items() if e == element)
        place = f"{self.source}:{token.line}: {function}: {name}"
        if name not in self.known:
            close = difflib.get_close_matches(name[:40], self.known, n=1)
            hint = f'; did you mean "{close[0]}"?' if close else ""
            raise InputError(
                f"{self.source}:{token.line}: {function}: {name[:40]}: no such parameter{hint} "
                f"(known: {', '.join(self.known)})"
            )
        given = self.elements.setdefault(element, {})
        if name in given and _within_call(token):
            raise InputError(f"{place}: stands twice; keep one")
        if len(right) == 1 and right[0].kind == "string":
            given[name] = Property(right[0].text[1:-1], place)
            return
        try:
            given[name] = Property(evaluate(right, self._variables), place)
        except NotPlain as error:
            if name in self.needed:
                raise InputError(
                    f"{place}: `{shown(right)}`: only plain arithmetic is read, not {error}"
                ) from None
            given[name] = Property(None, place)


def _within_call(token: Token) -> bool:
    """Whether a name stands in a call; a property that is set later takes its place."""
    return token.kind == "string"


def _is_function(token: Token) -> bool:
    return token.kind == "name" and token.text in FUNCTIONS


def _dotted(left: Sequence[Token]) -> str:
    """The name at the beginning, with its fields: ``gyro.NoiseDensity`` of ``…(3)``."""
    name = left[0].text
    for dot, part in zip(left[1::2], left[2::2], strict=False):
        if dot.text != "." or part.kind != "name":
            break
        name += "." + part.text
    return name


def _assignment(statement: list[Token]) -> tuple[str | None, list[Token] | None]:
    """``name.field = …`` as its name and right side; no name where it is another left side."""
    depth = 0
    for place, token in enumerate(statement):
        if token.kind != "sign":
            continue
        depth += (token.text in "([{") - (token.text in ")]}")
        if token.text == "=" and depth == 0:
            left, right = statement[:place], statement[place + 1 :]
            plain = bool(left) and len(_dotted(left).split(".")) * 2 - 1 == len(left)
            return (_dotted(left) if plain and left[0].kind == "name" else None), right
    return None, None
