"""Exceptions that users meet; every message says what is wrong and what would be right."""

from __future__ import annotations


class McsimError(Exception):
    """Base of all errors raised on purpose."""


class InputError(McsimError):
    """Bad input: a scenario, an option, a data file (exit code 2)."""


class UnitError(InputError):
    """A quantity that cannot be read: no number, no unit, or the wrong unit."""


class PartialError(McsimError):
    """Some points of a sweep failed; the others were written (exit code 3)."""


class InterruptedRun(McsimError):
    """The user stopped a run; finished points are kept (exit code 130)."""
