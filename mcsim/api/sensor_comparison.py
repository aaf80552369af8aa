"""``mcsim.compare_vibrations``: one vibration, seen by several sensors beside each other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from mcsim.api.found import Found
from mcsim.api.seen_logs import all_seen, laid_beside, on_one_clock, sorted_out
from mcsim.api.vibration import ONLY_OF_LOGS, FilterOptions, LogOptions, chain_of, engine_of
from mcsim.errors import InputError
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.vibration.comparison import Comparison, compare
from mcsim.vibration.excitations.excitation import Tone
from mcsim.vibration.filter_words import design, in_words
from mcsim.vibration.platform import Seen, left_out
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
    given = sorted_out(files, sensors, reference)
    if read and not given.logs:
        raise InputError(ONLY_OF_LOGS)
    scenario = read_vibration(given.scenario) if given.scenario is not None else None
    chain = chain_of(scenario.analysis if scenario else Chain(), filters or {})
    sought = _tones(scenario, seek or {})
    seen, simulated = all_seen(given, read or {}, tell)
    place = given.place_of_reference(seen)
    seen = on_one_clock(seen, scenario, place, chain) if align else laid_beside(seen, scenario)
    found = compare(
        seen,
        chain,
        place,
        sought,
        scenario.excitation if scenario else None,
        scenario.duration if scenario else float("nan"),
    )
    options = {
        "sensors": sensors,
        "reference": given.reference.name if given.reference else reference,
        "align": align or None,
        **(filters or {}),
        **(seek or {}),
        **(read or {}),
    }
    seed = scenario.seed if scenario and simulated else None
    name = given.scenario.stem if given.scenario else seen[place or 0].name
    title = (scenario.title or name) if scenario else "One vibration"
    return SensorComparison(
        name=f"{name}-sensors",
        title=title,
        found=found,
        scenario=scenario,
        notes=(*left_out(sensors or ""), *_notes(seen)),
        simulated=simulated,
        origin=provenance_of("vibration", given.inputs, options, seed),
    )


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
