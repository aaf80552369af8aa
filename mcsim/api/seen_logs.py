"""What is compared: a scenario, sensors that see it, and logs; one of them is the reference."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcsim import catalogue
from mcsim.api.vibration import LogOptions, is_scenario
from mcsim.errors import InputError
from mcsim.logs.formats import open_log
from mcsim.logs.model import ReadOptions
from mcsim.vibration.alignment import aligned, in_common
from mcsim.vibration.log import Log, name_of_log, read_vibration_log
from mcsim.vibration.platform import (
    REFERENCE,
    Seen,
    from_log,
    name_of,
    sensors_named,
    simulate_seen,
    true_one,
    with_ideal,
)
from mcsim.vibration.scenario import Chain, VibrationScenario


@dataclass(frozen=True)
class Given:
    """What a user gave; ``reference`` is the log that is one, ``named`` how it was called."""

    scenario: Path | None
    sensors: tuple[str, ...]
    logs: tuple[Path, ...]
    reference: Path | None
    named: str | None

    @property
    def inputs(self) -> list[Path]:
        """All files."""
        return [*([self.scenario] if self.scenario else []), *self.logs]

    def place_of_reference(self, seen: Sequence[Seen]) -> int | None:
        """Where the reference stands among what was seen, the logs last.

        Raises
        ------
        InputError
            It is neither a file nor a sensor among them.
        """
        if self.reference is not None:
            return len(seen) - len(self.logs) + self.logs.index(self.reference)
        names = [one.name.casefold() for one in seen]
        wanted = (self.named or REFERENCE).casefold()
        if wanted in names:
            return names.index(wanted)
        if self.named is None:
            return None
        raise self.no_reference([one.name for one in seen])

    def no_reference(self, names: Sequence[str]) -> InputError:
        """The reference is none of ``names``; a built-in sensor may be added to them."""
        known = catalogue.known(self.named or "")
        advice = ""
        if known is not None and self.sensors:
            listed = ",".join([*self.sensors, known.name])
            advice = f"; add it to them: --sensors {listed}"
        return InputError(
            f'--reference "{self.named}": neither a file nor one of the sensors '
            f"({', '.join(names)}){advice}"
        )

    def check_reference(self) -> None:
        """Refuse a reference that can be no sensor and no log, before anything is simulated."""
        names = [*map(name_of, self.sensors), *map(name_of_log, self.logs)]
        held = {name.casefold() for name in names}
        if self.reference is None and self.named and self.named.casefold() not in held:
            raise self.no_reference(names)


def sorted_out(files: Sequence[str | Path], sensors: str | None, reference: str | None) -> Given:
    """Which of the files is the scenario, which are logs, and which of them is the reference.

    Raises
    ------
    InputError
        Two scenarios, sensors without one, nothing to compare, or a reference that is not there.
    """
    paths = list(dict.fromkeys(map(Path, files)))
    scenario = _only_scenario(paths)
    logs = [path for path in paths if path != scenario]
    held = _reference_file(reference, logs)
    if held is not None and held not in logs:
        logs.insert(0, held)
    if sensors is not None and scenario is None:
        raise InputError("--sensors belongs to a scenario; logs have their own sensors")
    if not logs and sensors is None:
        raise InputError(
            "nothing to compare: give the scenario --sensors platform (or MPU-9250,BNO055), or "
            "name logs, one per sensor"
        )
    names = sensors_named(sensors) if sensors is not None else ()
    given = Given(scenario, names, tuple(logs), held, reference)
    given.check_reference()
    return given


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


def all_seen(
    given: Given, read: LogOptions, tell: Callable[[str], None]
) -> tuple[list[Seen], tuple[str, ...]]:
    """What the sensors and the logs show, in this order, and the names of the former.

    Logs are as they were written; a scenario is not laid beside them yet.

    Raises
    ------
    InputError
        A file that cannot be read, a log of several channels, or two sensors of one name.
    """
    simulated = simulate_seen(given.scenario, given.sensors, tell) if given.scenario else []
    seen = [*simulated, *(from_log(_read(path, read)) for path in given.logs)]
    names = [one.name for one in seen]
    for name in names:
        if names.count(name) > 1:
            raise InputError(
                f"{name}: two sensors of that name; rename one of the logs, or leave one out"
            )
    return seen, tuple(one.name for one in simulated)


def _read(path: Path, read: LogOptions) -> Log:
    """A log, with the one of the named channels that it holds."""
    channels = read.get("channels", ())
    if len(channels) > 1:
        file = open_log(path, ReadOptions(topic=read.get("topic")))
        held = tuple(c for c in channels if file.place_of(c) is not None)
        chosen: Any = {**read, "channels": held or channels}
        return read_vibration_log(path, **chosen)
    return read_vibration_log(path, **read)


def laid_beside(seen: Sequence[Seen], scenario: VibrationScenario | None) -> list[Seen]:
    """With the scenario, if there is one, beside what logs show; its time begins with theirs."""
    if scenario is None:
        return list(seen)
    return [one if one.ideal is not None else with_ideal(one, scenario) for one in seen]


def on_one_clock(
    seen: Sequence[Seen], scenario: VibrationScenario | None, place: int | None, chain: Chain
) -> list[Seen]:
    """Logs on the clock of the scenario, else of the reference, else of the first of them.

    Raises
    ------
    InputError
        A log that does not show the same, or no stretch that all of them saw.
    """
    if scenario is None:
        return in_common(aligned(seen, seen[place or 0], chain))
    logs = [one for one in seen if one.ideal is None]
    moved = iter(aligned(logs, true_one(scenario), chain))
    return laid_beside([next(moved) if one.ideal is None else one for one in seen], scenario)
