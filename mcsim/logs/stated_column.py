"""A column that a scenario names, as `NAME in UNIT`, in a recorded drive or run."""

from __future__ import annotations

import difflib
import math

from mcsim.errors import InputError, UnitError
from mcsim.logs.column_file import ColumnFile, shown
from mcsim.logs.columns import Column, written_column
from mcsim.logs.titles import factor_of, kind_of
from mcsim.units import Kind


def stated_column(file: ColumnFile, role: str, spec: str, kind: Kind) -> Column:
    """The column of a role, its unit from the scenario or from the header.

    Raises
    ------
    InputError
        No such column, no unit, one of another kind, or one that the header contradicts.
    """
    name, separator, unit = spec.rpartition(" in ")
    name = name.strip() if separator else spec.strip()
    place = file.place_of(name)
    if place is None:
        held = [written_column(file, i) for i in range(file.count)]
        close = difflib.get_close_matches(name, held, n=1)
        hint = f'; did you mean "{close[0]}"?' if close else ""
        raise InputError(
            f'{file.path}: no column "{shown(name)}" for {role}{hint} (columns: {", ".join(held)})'
        )
    own = file.unit(place)
    if not (unit.strip() if separator else own):
        example = kind.example.split()[1]
        raise InputError(
            f'trajectory.columns.{role}: "{spec}" has no unit; '
            f'write for example "{spec} in {example}"'
        )
    try:
        scale = factor_of(unit if separator else own, kind)
    except UnitError as error:
        raise InputError(f"trajectory.columns.{role}: {error}") from None
    stated = kind_of(own) if own else None
    if separator and stated is kind and not math.isclose(factor_of(own, kind), scale):
        raise InputError(
            f'trajectory.columns.{role}: "{spec}", but the header of {file.path} says '
            f'"{file.title(place)}"; correct one'
        )
    return Column(place, file.title(place), role, scale, unit.strip() if separator else own)
