"""Options of the commands that read sensors in the dialects of other tools."""

from __future__ import annotations

from collections.abc import Iterable

import click

from mcsim.errors import InputError


class DialectName(click.ParamType):  # type: ignore[type-arg, unused-ignore]
    """One that ``mcsim.dialects.readable`` or ``writable`` names, looked up when needed."""

    name = "dialect"

    def __init__(self, which: str) -> None:
        self.which = which

    def _choices(self) -> tuple[str, ...]:
        from mcsim import dialects

        names: tuple[str, ...] = getattr(dialects, self.which)()
        return names

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        del param, ctx
        return f"[{'|'.join(self._choices())}]"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        if value not in self._choices():
            self.fail(f'"{value}" is not one of {", ".join(self._choices())}', param, ctx)
        return value


class Hertz(click.ParamType):  # type: ignore[type-arg, unused-ignore]
    """A sampling rate in Hz, as a number or with its unit."""

    name = "hertz"

    def convert(
        self, value: str, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        from mcsim.units import KINDS, parse

        try:
            return float(value)
        except ValueError:
            pass
        try:
            return parse(value, KINDS["frequency"])
        except InputError as error:
            self.fail(str(error), param, ctx)


def answers(given: Iterable[str]) -> dict[str, str]:
    """The answers of ``--assume key=meaning``.

    Raises
    ------
    InputError
        Not of this form.
    """
    found = {}
    for text in given:
        key, equals, meaning = text.partition("=")
        if not equals:
            raise InputError(f'--assume "{text}": write key=meaning, for example n=continuous')
        found[key.strip()] = meaning.strip()
    return found
