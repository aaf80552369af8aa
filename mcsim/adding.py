"""``mcsim.add``: parts of a user's own, by their type to the list of their kind."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from mcsim.errors import InputError
from mcsim.registry import Registry

#: For each kind of part where its type and its list are: imported when a part may be one of it.
KINDS: dict[str, tuple[str, str]] = {
    "Case": ("mcsim.simulation.case:Case", "mcsim.systems:SYSTEMS"),
    "SensorTerm": ("mcsim.sensor_terms.term:SensorTerm", "mcsim.sensor_terms:TERMS"),
    "ErrorQuantity": (
        "mcsim.scenario.error_quantities:ErrorQuantity",
        "mcsim.scenario.error_quantities:ERROR_QUANTITIES",
    ),
    "Statistic": ("mcsim.statistics:Statistic", "mcsim.statistics:STATISTICS"),
    "Picture": ("mcsim.figures:Picture", "mcsim.figures:PICTURES"),
    "PaperTable": ("mcsim.papers:PaperTable", "mcsim.papers:TABLES"),
    "PaperFigure": ("mcsim.papers:PaperFigure", "mcsim.papers:FIGURES"),
    "Command": ("mcsim.cli.command:Command", "mcsim.cli.commands:COMMANDS"),
    "Dialect": ("mcsim.dialects:Dialect", "mcsim.dialects:DIALECTS"),
    "LogFormat": ("mcsim.logs:LogFormat", "mcsim.logs:LOG_FORMATS"),
    "Track": ("mcsim.tracks:Track", "mcsim.tracks:TRACKS"),
    "Excitation": (
        "mcsim.vibration.excitations:Excitation",
        "mcsim.vibration.excitations:EXCITATIONS",
    ),
}


def add(part: Any) -> None:
    """Add a part of your own, as if it stood in the package's list.

    Call it in a Python file, and load that with ``--with FILE.py`` or import it before scenarios
    are read.

    Parameters
    ----------
    part
        An object of one of the types that ``KINDS`` names; all are public names of ``mcsim``.

    Raises
    ------
    InputError
        Something else, or a name that is taken.
    """
    kind = type(part).__name__
    for base in type(part).__mro__:
        if base.__name__ in KINDS:
            kind = base.__name__
            break
    if kind not in KINDS or not isinstance(part, _at(KINDS[kind][0])):
        raise InputError(f"mcsim.add takes a {', '.join(KINDS)}; this is a {kind}")
    parts: Registry[Any] = _at(KINDS[kind][1])
    parts.add(part)


def _at(where: str) -> Any:
    module, _, name = where.partition(":")
    return getattr(import_module(module), name)
