"""``mcsim.compare_vibrations``: one vibration, seen by several sensors beside each other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from mcsim.api.found import Found
from mcsim.api.vibration import (
    ONLY_OF_LOGS,
    FilterOptions,
    LogOptions,
    chain_of,
    engine_of,
    is_scenario,
)
from mcsim.errors import InputError
from mcsim.logs.formats import open_log
from mcsim.logs.model import ReadOptions
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.vibration.alignment import aligned, in_common
from mcsim.vibration.comparison import Comparison, compare
from mcsim.vibration.excitations.excitation import Tone
from mcsim.vibration.filter_words import design, in_words
from mcsim.vibration.log import Log, read_vibration_log
from mcsim.vibration.platform import (
    REFERENCE,
    Seen,
    from_log,
    sensors_named,
    simulate_seen,
    true_one,
    with_ideal,
)
from mcsim.vibration.scenario import Chain, VibrationScenario, read_vibration

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.writing import Writer


class SoughtTones(TypedDict, total=False):
    """Tones that are looked for, beside those of a scenario."""

    rpm: float
    """Speed of a four-stroke engine, whose orders they are."""
    cylinders: int
    """Of that engine; 4 if absent."""
    tones: Sequence[float]
    """Further frequencies (Hz)."""


@dataclass(frozen=True)
class SensorComparison(Found):
    """What several sensors saw of one vibration.

    Attributes
    ----------
    name, title : str
    found : mcsim.vibration.comparison.Comparison
        Data frames ``table``, ``orders``, ``travel`` and ``response``; the latter three are None
        where there is nothing of it.
    scenario : VibrationScenario or None
    notes : tuple of str
        What to know of the sensors.
    simulated : collection of str
        The sensors whose logs were simulated; these are written too.
    origin : mapping
        Where it comes from.
    """

    name: str
    title: str
    found: Comparison
    scenario: VibrationScenario | None
    notes: tuple[str, ...]
    simulated: tuple[str, ...]
    origin: Mapping[str, Any]

    def filters(self) -> dict[str, tuple[str, ...]]:
        """The filters as they act at the rate of each sensor, in sentences."""
        return {s.seen.name: in_words(s.filters) for s in self.found.sensors}

    def filter_notes(self) -> tuple[str, ...]:
        """The filters as they act, in a line, and where a sensor's rate leaves them no room."""
        chain = self.found.sensors[0].filters.chain
        refused = [
            f"{s.seen.name}: {text}"
            for s in self.found.sensors
            for text in s.filters.notes
            if text.startswith("no ")
        ]
        return (f"filters: {design(chain)}", *refused, *self._cut_short())

    def _cut_short(self) -> list[str]:
        if self.scenario is None or self.scenario.excitation.travel is None:
            return []
        moved = self.found.motions or ((),) * len(self.found.sensors)
        return [
            f"{s.seen.name}: it does not hold the whole run; no velocity and height"
            for s, motions in zip(self.found.sensors, moved, strict=True)
            if not motions
        ]

    def report(self) -> Report:
        """Files ``table``, ``orders``, ``travel``, ``response``, logs, and the figures of each."""
        tables = self._tables()
        return Report(
            provenance={**self.origin, "filters": self.filters()},
            tables={**tables, **self._logs()},
            pictures=self._pictures(),
            nine_digits=(*tables, *self._logs()),
            obsolete=("orders", "travel", "response"),
        )

    def _tables(self) -> dict[str, pd.DataFrame]:
        found = self.found
        tables = {"table": found.table, "orders": found.orders}
        tables |= {"travel": found.travel, "response": found.response}
        return {name: table for name, table in tables.items() if table is not None}

    def _logs(self) -> dict[str, pd.DataFrame]:
        return {
            f"log-{s.seen.name}": _log_table(s.seen)
            for s in self.found.sensors
            if s.seen.name in self.simulated
        }

    def _pictures(self) -> dict[str, Writer]:
        from mcsim.figures.style import printed
        from mcsim.figures.vibration_response import draw_response
        from mcsim.figures.vibration_sensors import draw_sensors
        from mcsim.figures.vibration_travel import draw_travel

        pictures = printed(draw_sensors(self.found, self.title), "figure")
        if self.found.motions is not None:
            pictures |= printed(draw_travel(self.found, self.title), "travel")
        if self.found.response is not None:
            pictures |= printed(draw_response(self.found, self.title), "response")
        return pictures


def compare_vibrations(
    files: Sequence[str | Path],
    *,
    sensors: str | None = None,
    reference: str | None = None,
    filters: FilterOptions | None = None,
    seek: SoughtTones | None = None,
    read: LogOptions | None = None,
    align: bool = False,
    tell: Callable[[str], None] = lambda _: None,
) -> SensorComparison:
    """Hold sensors that see the same vibration against the truth and against a reference.

    Parameters
    ----------
    files : sequence of paths
        A scenario (YAML), logs of one sensor each, or both: the scenario is then what shook them.
    sensors : str, optional
        Built-in sensors and sensor files that see the scenario, ``MTN-1100,MPU-9250@500 Hz``;
        ``platform`` for those of the vibration thesis, ``all`` for all built-in ones.
    reference : str, optional
        The sensor, by its name, or the log, by its file; MTN-1100 if absent and among them.
    filters : FilterOptions, optional
        ``moving_average``, ``high_pass``, ``low_pass``.
    seek : SoughtTones, optional
        Tones to look for beside the scenario's: ``rpm``, ``cylinders``, ``tones``.
    read : LogOptions, optional
        How logs are read.  Of several ``channels`` each log's is the one that it holds.
    align : bool
        Whether clocks of logs are brought together by cross-correlation: with that of the
        reference, or with the scenario.
    tell : callable
        Hears what takes long.

    Returns
    -------
    SensorComparison
        ``found`` with its tables, and ``write(folder)``.

    Raises
    ------
    InputError
        A file that cannot be read, an unknown sensor, options that make no sense, or logs that
        do not show the same.
    """
    paths = list(dict.fromkeys(map(Path, files)))
    path = _only_scenario(paths)
    logs = [p for p in paths if p != path]
    held = _reference_file(reference, logs)
    if held is not None and held not in logs:
        logs.insert(0, held)
    _refuse_nothing(path, logs, sensors)
    if read and not logs:
        raise InputError(ONLY_OF_LOGS)
    scenario = read_vibration(path) if path is not None else None
    chain = chain_of(scenario.analysis if scenario else Chain(), filters or {})
    seen = simulate_seen(path, sensors_named(sensors), tell) if path and sensors else []
    simulated = tuple(one.name for one in seen)
    # Read as they are; the scenario is laid beside them when their clocks agree.
    read_logs = [from_log(_read(p, read or {})) for p in logs]
    seen += read_logs
    _refuse_twice(seen)
    place = _place_of_reference(seen, reference, logs, held)
    seen = _on_one_clock(seen, scenario, place, chain, align)
    options = {"sensors": sensors, "reference": reference, **(filters or {}), **(seek or {})}
    origin = provenance_of(
        "vibration",
        [p for p in (path, *logs) if p is not None],
        {**options, **(read or {}), **({"align": True} if align else {})},
        scenario.seed if scenario and simulated else None,
    )
    found = compare(
        seen,
        chain,
        place,
        _tones(scenario, seek or {}),
        scenario.excitation if scenario else None,
        scenario.duration if scenario else float("nan"),
    )
    name = path.stem if path else seen[place or 0].name
    title = (scenario.title if scenario else None) or (name if path else "One vibration")
    return SensorComparison(
        f"{name}-sensors", title, found, scenario, _notes(seen), simulated, origin
    )


def _only_scenario(paths: Sequence[Path]) -> Path | None:
    scenarios = [path for path in paths if is_scenario(path)]
    if len(scenarios) > 1:
        raise InputError(
            f"{scenarios[1]}: a second scenario; sensors are compared on one vibration"
        )
    return scenarios[0] if scenarios else None


def _reference_file(reference: str | None, logs: Sequence[Path]) -> Path | None:
    """The log that the reference is, if it is one."""
    if reference is None:
        return None
    named = [path for path in logs if reference in (str(path), path.name)]
    if named:
        return named[0]
    path = Path(reference)
    return path if path.is_file() and not is_scenario(path) else None


def _refuse_nothing(path: Path | None, logs: Sequence[Path], sensors: str | None) -> None:
    if sensors is not None and path is None:
        raise InputError("--sensors belongs to a scenario; logs have their own sensors")
    if not logs and sensors is None:
        raise InputError(
            "nothing to compare: give the scenario --sensors platform (or MPU-9250,BNO055), or "
            "name logs, one per sensor"
        )


def _read(path: Path, read: LogOptions) -> Log:
    """A log, with the one of the named channels that it holds."""
    channels = read.get("channels", ())
    if len(channels) > 1:
        file = open_log(path, ReadOptions(topic=read.get("topic")))
        held = tuple(c for c in channels if file.place_of(c) is not None)
        chosen: Any = {**read, "channels": held or channels}
        return read_vibration_log(path, **chosen)
    return read_vibration_log(path, **read)


def _refuse_twice(seen: Sequence[Seen]) -> None:
    names = [one.name for one in seen]
    for name in names:
        if names.count(name) > 1:
            raise InputError(
                f"{name}: two sensors of that name; rename one of the logs, or leave one out"
            )


def _place_of_reference(
    seen: Sequence[Seen], reference: str | None, logs: Sequence[Path], held: Path | None
) -> int | None:
    names = [one.name.casefold() for one in seen]
    if held is not None:
        return len(seen) - len(logs) + list(logs).index(held)
    if reference is None:
        return names.index(REFERENCE.casefold()) if REFERENCE.casefold() in names else None
    if reference.casefold() not in names:
        raise InputError(
            f'--reference "{reference}": neither a file nor one of the sensors '
            f"({', '.join(one.name for one in seen)})"
        )
    return names.index(reference.casefold())


def _on_one_clock(
    seen: list[Seen],
    scenario: VibrationScenario | None,
    place: int | None,
    chain: Chain,
    align: bool,
) -> list[Seen]:
    if align and scenario is not None:
        logs = [one for one in seen if one.ideal is None]
        moved = iter(aligned(logs, true_one(scenario), chain))
        seen = [next(moved) if one.ideal is None else one for one in seen]
    elif align:
        seen = in_common(aligned(seen, seen[place or 0], chain))
    if scenario is None:
        return seen
    return [one if one.ideal is not None else with_ideal(one, scenario) for one in seen]


def _tones(scenario: VibrationScenario | None, seek: SoughtTones) -> list[Tone]:
    """Those of the scenario, of an engine, and further frequencies, in their order."""
    tones = list(scenario.excitation.tones) if scenario else []
    engine = engine_of(seek.get("rpm"), seek.get("cylinders"), None)
    known = {round(tone.frequency, 9) for tone in tones}
    orders = engine.orders if engine else ()
    further = [Tone(f"order {o:g}", engine.frequency(o), order=o) for o in orders if engine]
    further += [Tone(f"{frequency:g} Hz", frequency) for frequency in seek.get("tones", ())]
    for tone in further:
        if not tone.frequency > 0.0:
            raise InputError(f"--tone '{tone.frequency:g} Hz': must be above zero")
    tones += [tone for tone in further if round(tone.frequency, 9) not in known]
    return sorted(tones, key=lambda tone: tone.frequency)


def _notes(seen: Sequence[Seen]) -> tuple[str, ...]:
    """What was done to logs, and what sensors do not see, each once."""
    notes = [
        note if note.startswith(one.name) else f"{one.name}: {note}"
        for one in seen
        for note in (*one.log.remarks, *one.log.notes)
    ]
    return tuple(dict.fromkeys(notes))


def _log_table(seen: Seen) -> pd.DataFrame:
    import pandas as pd

    column = f"a{seen.log.channels[0]} [m/s^2]"
    return pd.DataFrame({"time [s]": seen.time, column: seen.signal})
