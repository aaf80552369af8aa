"""``mcsim.analyse_vibration``: a measured log or a simulated one, filtered, measured and drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from mcsim.api.found import Found
from mcsim.errors import InputError
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.scenario.document import Document, PathKey
from mcsim.scenario.validation import validate
from mcsim.vibration.analysis import Analysis, Engine, analyse
from mcsim.vibration.filter_words import in_words
from mcsim.vibration.log import Log, read_vibration_log
from mcsim.vibration.scenario import Chain, VibrationScenario, read_vibration
from mcsim.vibration.simulation import simulate

if TYPE_CHECKING:
    import pandas as pd

_SCENARIO_ENDINGS = (".yaml", ".yml")
ONLY_OF_LOGS = (
    "--rate, --time, --unit, --channel, --topic, --start and --end belong to a log, "
    "not to a scenario"
)
#: More values take some seconds to analyse.
_MANY = 500_000


class FilterOptions(TypedDict, total=False):
    """What takes the place of a scenario's filters, or of the usual ones."""

    moving_average: int
    """Samples; 10 if absent, 0 for none."""
    high_pass: str
    """Cut-off with its unit; ``0 Hz`` for none."""
    low_pass: str
    """Cut-off with its unit; ``0 Hz`` for none."""


class LogOptions(TypedDict, total=False):
    """How a log is read; see ``mcsim.vibration.log.read_vibration_log``."""

    unit: str
    rate: float
    channels: tuple[str, ...]
    time: str
    topic: str
    cut: tuple[float | None, float | None]


@dataclass(frozen=True)
class Vibration(Found):
    """What a vibration is.

    Attributes
    ----------
    title : str
    analysis : mcsim.vibration.analysis.Analysis
        Arrays (n, channels) in m/s²; ``table``, ``spectrum``, ``density`` and ``orders``, which is
        None without an engine, are data frames.
    simulated : bool
        Whether the log was simulated; it is then written too.
    origin : mapping
        Where it comes from: the provenance of its files.
    """

    title: str
    analysis: Analysis
    simulated: bool
    origin: Mapping[str, Any]

    def report(self) -> Report:
        """Files ``table``, ``spectrum``, ``density``, ``orders``, ``log`` and ``figure``."""
        from mcsim.figures.style import printed
        from mcsim.figures.vibration import draw_vibration

        found = self.analysis
        tables = {"table": found.table, "spectrum": found.spectrum, "density": found.density}
        if found.orders is not None:
            tables["orders"] = found.orders
        if self.simulated:
            tables["log"] = _log_table(found.log)
        return Report(
            provenance={**self.origin, "filters": in_words(found.filters)},
            tables=tables,
            pictures=printed(draw_vibration(found, self.title), "figure"),
            nine_digits=tables,
            obsolete=("orders", "log"),
        )


def analyse_vibration(
    file: str | Path,
    *,
    sensor: str | None = None,
    filters: FilterOptions | None = None,
    rpm: float | None = None,
    cylinders: int | None = None,
    read: LogOptions | None = None,
    progress: Callable[[float], None] = lambda _: None,
    tell: Callable[[str], None] = lambda _: None,
) -> Vibration:
    """Analyse the vibration in a log, or simulate a scenario (YAML) and analyse that.

    Parameters
    ----------
    file : path
    sensor : str, optional
        Another sensor than the scenario's: a built-in one's name, or a sensor file.
    filters : FilterOptions, optional
        ``moving_average``, ``high_pass``, ``low_pass``.
    rpm : float, optional
        Speed of a four-stroke engine whose orders are looked for; a scenario may bring its own.
    cylinders : int, optional
        Of that engine; 4 if absent.
    read : LogOptions, optional
        How a log is read: ``unit``, ``rate`` (Hz), ``channels``, ``time``, ``topic`` of a
        bag, ``cut`` (s).
    progress : callable
        Is told the share simulated, 0 to 1.
    tell : callable
        Hears what takes long.

    Returns
    -------
    Vibration
        ``analysis`` with the tables ``table`` (peak, RMS; m/s²), ``spectrum``, ``density``
        ((m/s²)²/Hz) and ``orders``, and ``write(folder)``.

    Raises
    ------
    InputError
        A file that cannot be read or is no such log or scenario; options that belong to the
        other of the two, or that make no sense.
    """
    path, scenario = Path(file), None
    if is_scenario(path):
        if read:
            raise InputError(ONLY_OF_LOGS)
        scenario = read_vibration(path, sensor)
    chain = chain_of(scenario.analysis if scenario else Chain(), filters or {})
    engine = engine_of(rpm, cylinders, scenario)
    if scenario is not None:
        log = simulate(scenario, path.stem, progress)
    elif sensor is not None:
        raise InputError("--sensor belongs to a scenario; a log has its own sensor")
    else:
        log = read_vibration_log(path, **(read or {}))
    if log.samples.size > _MANY:
        tell(f"{log.name}: analysing {log.samples.size:,} values")
    options = {"sensor": sensor, "rpm": rpm, "cylinders": cylinders, **(filters or {})}
    seed = scenario.seed if scenario else None
    origin = provenance_of("vibration", [path], {**options, **(read or {})}, seed)
    title = _title(path.stem, scenario)
    tones = scenario.excitation.tones if scenario else ()
    return Vibration(title, analyse(log, chain, engine, tones), scenario is not None, origin)


def is_scenario(path: Path) -> bool:
    """Whether a file is a scenario, by the ending of its name, and no log."""
    return path.suffix.casefold() in _SCENARIO_ENDINGS


def _title(name: str, scenario: VibrationScenario | None) -> str:
    title = (scenario.title if scenario else None) or name
    if scenario is not None and scenario.sensor.model:
        title = f"{title} – {scenario.sensor.model}"
    return title


def chain_of(base: Chain, settings: FilterOptions) -> Chain:
    """The scenario's chain with what the options change."""
    places: dict[PathKey, str] = {(key,): f"--{key.replace('_', '-')}" for key in settings}
    tree = {**base.model_dump(), **settings}
    return validate(Document(tree, "options", overrides=places), Chain)


def engine_of(
    rpm: float | None, cylinders: int | None, scenario: VibrationScenario | None
) -> Engine | None:
    """The engine whose orders are looked for, if there is one."""
    if rpm is not None:
        if not 0.0 < rpm < 1e6:
            raise InputError(f"--rpm {rpm:g}: must be above zero and below a million")
        return Engine(rpm / 60.0, cylinders or 4)
    if scenario is not None and scenario.excitation.engine is not None:
        speed, own = scenario.excitation.engine
        return Engine(speed, cylinders or own)
    if cylinders is not None:
        raise InputError("--cylinders needs the engine's speed: give --rpm too")
    return None


def _log_table(log: Log) -> pd.DataFrame:
    import pandas as pd

    columns = {f"a{c} [m/s^2]": log.samples[:, i] for i, c in enumerate(log.channels)}
    return pd.DataFrame({"time [s]": log.time, **columns})
