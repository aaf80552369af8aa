"""``mcsim.characterise_several``: several static logs, each by itself and all in one Allan plot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.api.characterise import SensorCharacterisation, characterise
from mcsim.api.found import Found
from mcsim.errors import InputError
from mcsim.provenance import provenance_of
from mcsim.report import Report

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class SeveralLogs(Found):
    """Logs beside each other.

    Attributes
    ----------
    logs : mapping
        ``SensorCharacterisation`` by name.
    origin : mapping
        Where it comes from: the provenance of its files.
    """

    logs: Mapping[str, SensorCharacterisation]
    origin: Mapping[str, Any]

    @property
    def table(self) -> pd.DataFrame:
        """Columns log, channel, and N, B, K with the ends of their intervals; SI units."""
        import pandas as pd

        return pd.DataFrame(
            [
                {"log": name, "channel": result.channel.name}
                | {
                    f"{term}{end}": getattr(result.fit[term], value)
                    for term in "NBK"
                    for end, value in (("", "value"), ("_low", "low"), ("_high", "high"))
                }
                for name, found in self.logs.items()
                for result in found.analysis.channels
            ]
        )

    @property
    def allan(self) -> pd.DataFrame:
        """Columns log, channel, tau_s, adev, ci_low, ci_high; m/s² and rad/s."""
        import pandas as pd

        return pd.concat(
            found.allan.assign(log=name)[["log", *found.allan]] for name, found in self.logs.items()
        )

    def report(self) -> Report:
        """Files ``allan`` and ``noise`` of all logs together."""
        from mcsim.figures.several_allan import draw_several
        from mcsim.figures.style import printed

        found = [log.analysis for log in self.logs.values()]
        figure = draw_several(list(self.logs), found, "Allan deviations, bands: their intervals")
        return Report(
            provenance=self.origin,
            tables={"allan": self.allan, "noise": self.table},
            pictures=printed(figure, "allan"),
            nine_digits=("noise",),
        )

    def write(self, folder: str | Path) -> list[Path]:
        """Write what they have in common into ``folder``, and each log's own into one inside."""
        own = [
            file for name, found in self.logs.items() for file in found.write(Path(folder) / name)
        ]
        return [*own, *super().write(folder)]


def characterise_several(logs: Sequence[str | Path], **options: Any) -> SeveralLogs:
    """Characterise several static logs with the same options.

    Parameters
    ----------
    logs : sequence of path
        Two or more.
    **options
        Of ``characterise``.

    Returns
    -------
    SeveralLogs
        ``logs`` by name, ``table`` and ``allan`` of all of them, and ``write(folder)``.

    Raises
    ------
    InputError
        As ``characterise``; logs that have the same name.
    """
    paths = [Path(log) for log in logs]
    names = _names(paths)
    found = {name: characterise(path, **options) for name, path in zip(names, paths, strict=True)}
    told = {k: v for k, v in options.items() if k != "tell"}
    return SeveralLogs(found, provenance_of("characterise", paths, told))


def _names(paths: Sequence[Path]) -> list[str]:
    """The files' names without their endings; with their folder's where two are alike."""
    stems = [path.resolve().name.split(".")[0] or "log" for path in paths]
    if len(set(stems)) < len(stems):
        stems = [f"{path.resolve().parent.name}_{s}" for path, s in zip(paths, stems, strict=True)]
    for k, name in enumerate(stems):
        if name in stems[:k]:
            raise InputError(
                f"{paths[k]}: another log is called {name} too; their results need names of their "
                "own"
            )
    return stems
