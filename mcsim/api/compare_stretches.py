"""``mcsim.compare_stretches``: a log before and after a bad stretch, or two of its parts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.api.characterise import LogOptions
from mcsim.api.found import Found
from mcsim.characterisation.analysis import Characterisation, Settings
from mcsim.characterisation.analysis import characterise as analyse
from mcsim.characterisation.fit import Intervals
from mcsim.characterisation.health.bad_stretch import bad_stretch
from mcsim.characterisation.health.record import SHORTEST
from mcsim.characterisation.stretches import Change, change_table, changes, least_shown
from mcsim.errors import InputError
from mcsim.logs import ReadOptions, read_log
from mcsim.provenance import provenance_of
from mcsim.report import Report

if TYPE_CHECKING:
    import pandas as pd

_FORMS = (
    "write auto (the stretch is looked for), FROM:TO (the bad stretch, in s), or "
    "FROM:TO,FROM:TO (the two that are compared)"
)


@dataclass(frozen=True)
class StretchComparison(Found):
    """Two stretches of a log.

    Attributes
    ----------
    before, after : mcsim.characterisation.Characterisation
        Of the two; ``ranges`` are their times (s).
    why : str
        What is wrong between them, if that was looked for.
    changes : tuple of mcsim.characterisation.stretches.Change
        Level, deviation and N of each channel.
    origin : mapping
        Where it comes from: the provenance of its files.
    """

    before: Characterisation
    after: Characterisation
    ranges: tuple[tuple[float, float], tuple[float, float]]
    why: str
    changes: tuple[Change, ...]
    origin: Mapping[str, Any]

    @property
    def table(self) -> pd.DataFrame:
        """Columns channel, quantity, unit, before, after, u_of_change, p, p_holm, changed."""
        return change_table(self.changes)

    @property
    def names(self) -> list[str]:
        """The two ranges in words."""
        (a, b), (c, d) = self.ranges
        return [f"before: {a:.6g} to {b:.6g} s", f"after: {c:.6g} to {d:.6g} s"]

    @property
    def words(self) -> str:
        """What has changed, or how little of it would have shown."""
        table = self.table
        changed = table[table["changed"]]
        told = f"Between them: {self.why}. " if self.why else ""
        if not len(changed):
            shown = least_shown(self.changes)
            least = " or ".join(f"{x:.2g} {unit}" for unit, x in shown.items())
            return (
                f"{told}No change shown (Holm's p of all tests is 0.01 or more). In every channel "
                f"a change of level would have shown from {least} on."
            )
        items = ", ".join(
            f"{q} of {c}" for c, q in zip(changed["channel"], changed["quantity"], strict=True)
        )
        return told + f"Changed (Holm's p of all tests below 0.01): {items}."

    def report(self) -> Report:
        """Files ``comparison`` and ``allan``."""
        from mcsim.figures.several_allan import draw_several
        from mcsim.figures.style import printed

        title = f"{self.before.log.path.name}: two stretches. {self.words}"
        figure = draw_several(self.names, [self.before, self.after], title)
        return Report(
            provenance=self.origin,
            tables={"comparison": self.table},
            pictures=printed(figure, "comparison"),
            nine_digits=("comparison",),
        )


def compare_stretches(
    log: str | Path,
    stretches: str = "auto",
    *,
    read: LogOptions | None = None,
    intervals: Intervals = "bootstrap",
    tell: Callable[[str], None] = lambda _: None,
) -> StretchComparison:
    """Compare level, deviation and N of a static log before and after something happened.

    Parameters
    ----------
    log : path
        As for ``characterise``.
    stretches : str
        ``auto`` looks for the longest stretch that is stuck, noisy or at a rail; ``100:160`` names
        the bad one (s from the first row), ``0:600,900:1500`` the two that are compared.
    read : LogOptions, optional
        How it is read; ``start`` and ``end`` are those of the stretches.
    intervals : "bootstrap" or "covariance"
        Of N.
    tell : callable
        Hears what is being done.

    Returns
    -------
    StretchComparison
        ``table`` of all quantities, ``words``, ``before`` and ``after`` in full, and
        ``write(folder)``.

    Raises
    ------
    InputError
        A log that cannot be read, no bad stretch in it, or parts shorter than a minute.
    """
    path, options = Path(log), dict(read or {})
    if options.get("start") is not None or options.get("end") is not None:
        raise InputError("--compare: names its stretches itself; leave out --start and --end")
    tell(f"reading {log}")
    whole = read_log(path, ReadOptions(**options))  # type: ignore[arg-type]
    ranges, why = _ranges(stretches, whole.duration, lambda: bad_stretch(whole), str(path))
    settings = Settings(intervals=intervals)
    parts = []
    for start, end in ranges:
        cut: dict[str, Any] = options | {"start": start, "end": end}
        parts.append(analyse(read_log(path, ReadOptions(**cut)), settings, tell))
    found = changes(parts[0], parts[1], ranges[1][0] - ranges[0][1])
    told = {"compare": stretches, "intervals": intervals, **options}
    origin = provenance_of("characterise", [path], told)
    return StretchComparison(parts[0], parts[1], ranges, why, tuple(found), origin)


def _ranges(
    text: str, duration: float, look: Callable[[], Any], where: str
) -> tuple[tuple[tuple[float, float], tuple[float, float]], str]:
    why = ""
    if text == "auto":
        found = look()
        if found is None:
            raise InputError(f"{where}: --compare auto: no stretch is stuck, noisy or at a rail")
        ranges = (0.0, found.start), (found.end, duration)
        why = f"{found.why} from {found.start:.6g} to {found.end:.6g} s"
    else:
        given = [_range(part, text) for part in text.split(",")]
        if len(given) == 1:
            ranges = (0.0, given[0][0]), (given[0][1], duration)
        elif len(given) == 2:
            ranges = given[0], given[1]
        else:
            raise InputError(f'--compare "{text}": {_FORMS}')
    if ranges[1][0] < ranges[0][1]:
        raise InputError(f'--compare "{text}": the stretches overlap, or stand in the wrong order')
    for start, end in ranges:
        if min(end, duration) - start < SHORTEST:
            raise InputError(
                f"{where}: --compare {text}: from {start:.6g} to {min(end, duration):.6g} s is "
                f"less than {SHORTEST:g} s, too short to compare"
            )
    return ranges, why


def _range(part: str, text: str) -> tuple[float, float]:
    try:
        start, end = (float(number) for number in part.split(":"))
    except ValueError:
        raise InputError(f'--compare "{text}": {_FORMS}') from None
    if not 0.0 <= start < end:
        raise InputError(f'--compare "{text}": two ascending times in s are needed')
    return start, end
