"""``mcsim vibration``: a measured log or a simulated one, filtered, measured and drawn."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcsim.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.vibration.analysis import Analysis, Engine
    from mcsim.vibration.log import Log
    from mcsim.vibration.scenario import Chain, VibrationScenario

_SCENARIO_ENDINGS = (".yaml", ".yml")
#: Seconds before progress is told, and between two lines of it.
_PATIENCE = 2.0
#: More values take some seconds to analyse.
_MANY = 500_000


@click.command()
@click.argument("given", metavar="LOG|SCENARIO", type=click.Path(path_type=Path))
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    default=Path("output"),
    show_default=True,
    help="Folder for results; the log or scenario gets a folder inside.",
)
@click.option("--rpm", type=float, help="Speed of a four-stroke engine: marks its orders.")
@click.option("--cylinders", type=click.IntRange(1, 64), help="Of that engine; 4 if absent.")
@click.option("--sensor", help="Another built-in sensor than the scenario's.")
@click.option("--high-pass", metavar="'2 Hz'", help="Cut-off; 0 Hz for none.")
@click.option("--low-pass", metavar="'50 Hz'", help="Cut-off; 0 Hz for none.")
@click.option("--moving-average", type=click.IntRange(0), help="Samples; 10 if absent, 0 for none.")
@click.option(
    "--rate",
    metavar="'100 Hz'",
    help="Of a log without a time column, or whose time stamps are no use.",
)
@click.option("--time", "stamps", metavar="'NAME in UNIT'", help="Column of a log's time stamps.")
@click.option("--channel", "channels", multiple=True, help="Column of a log; all that fit if none.")
@click.option(
    "--unit",
    help="Of columns without one: those of --channel, else those named like an acceleration; "
    "also counts, '16384 counts/g'.",
)
@click.option("--start", type=float, metavar="S", help="Leave out what lies before (s) in a log.")
@click.option("--end", type=float, metavar="S", help="Leave out what lies after (s) in a log.")
@click.option("--quiet", is_flag=True, help="No progress, no summary.")
def vibration(
    given: Path,
    output: Path,
    rpm: float | None,
    cylinders: int | None,
    sensor: str | None,
    high_pass: str | None,
    low_pass: str | None,
    moving_average: int | None,
    rate: str | None,
    stamps: str | None,
    channels: tuple[str, ...],
    unit: str | None,
    start: float | None,
    end: float | None,
    quiet: bool,
) -> None:
    """Analyse the vibration in a log (CSV), or simulate a scenario and analyse that.

    A log has a header with units ("time [ms],az [m/s²]"), or they are given by --time and --unit;
    dates and times need none.

    Filters the channels, and writes peak, RMS, signal-to-noise ratio, velocity and displacement,
    spectra, engine orders and a figure.
    """
    from mcsim.units import KINDS, parse
    from mcsim.vibration.analysis import analyse
    from mcsim.vibration.scenario import Chain

    settings = {"moving_average": moving_average, "high_pass": high_pass, "low_pass": low_pass}
    is_scenario = given.suffix.casefold() in _SCENARIO_ENDINGS
    of_logs = rate, stamps, unit, start, end, *channels
    scenario = _scenario(given, sensor, of_logs) if is_scenario else None
    chain = _chain(scenario.analysis if scenario else Chain(), settings)
    engine = _engine(rpm, cylinders, scenario)
    if scenario is not None:
        from mcsim.vibration.simulation import simulate

        log = simulate(scenario, given.stem, _progress(given.stem, quiet))
    else:
        from mcsim.vibration.log import read_vibration_log

        if sensor is not None:
            raise InputError("--sensor belongs to a scenario; a log has its own sensor")
        hertz = parse(rate, KINDS["frequency"]) if rate is not None else None
        log = read_vibration_log(
            given, unit=unit, rate=hertz, channels=channels, time=stamps, cut=(start, end)
        )
    if not quiet and log.samples.size > _MANY:
        _tell(f"{log.name}: analysing {log.samples.size:,} values")
    analysis = analyse(log, chain, engine)
    title = (scenario.title if scenario else None) or given.stem
    if scenario is not None and scenario.sensor.model:
        title = f"{title} – {scenario.sensor.model}"
    folder = output / log.name
    _write(analysis, folder, title, simulated=scenario is not None)
    if not quiet:
        _report(analysis, folder)


def analyse_shipped(output: Path) -> list[Path]:
    """Simulate and analyse the shipped vibrations; their pictures."""
    from mcsim.cli.paper import shipped_scenarios
    from mcsim.vibration.analysis import analyse
    from mcsim.vibration.simulation import simulate

    pictures = []
    for path in sorted((shipped_scenarios() / "vibration").glob("*.yaml")):
        scenario = _scenario(path, None, ())
        analysis = analyse(
            simulate(scenario, path.stem, lambda _: None),
            scenario.analysis,
            _engine(None, None, scenario),
        )
        title = f"{scenario.title or path.stem} – {scenario.sensor.model}"
        _write(analysis, output / path.stem, title, simulated=True)
        pictures.append(output / path.stem / "figure.png")
    return pictures


def _scenario(path: Path, sensor: str | None, of_logs: tuple[object, ...]) -> VibrationScenario:
    from mcsim.vibration.scenario import read_vibration

    if any(option is not None for option in of_logs):
        raise InputError(
            "--rate, --time, --unit, --channel, --start and --end belong to a log, not to a "
            "scenario"
        )
    return read_vibration(path, sensor)


def _chain(base: Chain, settings: dict[str, int | str | None]) -> Chain:
    """The scenario's chain with what the options change."""
    from mcsim.scenario.document import Document, PathKey
    from mcsim.scenario.validation import validate
    from mcsim.vibration.scenario import Chain

    changed = {key: value for key, value in settings.items() if value is not None}
    places: dict[PathKey, str] = {(key,): f"--{key.replace('_', '-')}" for key in changed}
    tree = {**base.model_dump(), **changed}
    return validate(Document(tree, "options", overrides=places), Chain)


def _engine(
    rpm: float | None, cylinders: int | None, scenario: VibrationScenario | None
) -> Engine | None:
    from mcsim.vibration.analysis import Engine

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


def _progress(name: str, quiet: bool) -> Callable[[float], None]:
    """Tells the share done, once it takes long."""
    last = time.monotonic()

    def tell(share: float) -> None:
        nonlocal last
        if not quiet and time.monotonic() - last > _PATIENCE:
            last = time.monotonic()
            _tell(f"{name}: {share:.0%} simulated")

    return tell


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _write(analysis: Analysis, folder: Path, title: str, simulated: bool) -> None:
    from mcsim.figures.style import write_figure
    from mcsim.figures.vibration import draw_vibration
    from mcsim.store import readable_errors, write_whole

    figure = draw_vibration(analysis, title)
    tables = {
        "table": analysis.table,
        "spectrum": analysis.spectrum,
        "density": analysis.density,
        "orders": analysis.orders,
        "log": _log_table(analysis.log) if simulated else None,
    }
    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name, table in tables.items():
            path = folder / f"{name}.csv"
            if table is None:
                path.unlink(missing_ok=True)
            else:
                write_whole(path, _csv_writer(table))
    write_figure(figure, folder, "figure")


def _csv_writer(table: pd.DataFrame) -> Callable[[Path], None]:
    return lambda path: table.to_csv(path, index=False, lineterminator="\n", float_format="%.9g")


def _log_table(log: Log) -> pd.DataFrame:
    import pandas as pd

    columns = {f"a{c} [m/s^2]": log.samples[:, i] for i, c in enumerate(log.channels)}
    return pd.DataFrame({"time [s]": log.time, **columns})


def _report(analysis: Analysis, folder: Path) -> None:
    from mcsim.cli.tables import columns

    log = analysis.log
    click.echo(f"{log.name}: {len(log.samples):,} samples at {log.rate:.6g} Hz")
    shown = [
        c
        for c in analysis.table.columns
        if c.split(" [")[0] in ("peak", "peak_to_peak", "rms", "snr", "velocity rms")
        or c.startswith("displacement rms")
    ]
    header = ["channel", "stage", *(name.replace("^2", "²") for name in shown)]
    rows = [header]
    for _, row in analysis.table.iterrows():
        rows.append([row["channel"], row["stage"], *(_cell(row[name]) for name in shown)])
    click.echo("\n".join(columns(rows)))
    if analysis.orders is not None:
        click.echo("\n".join(["", *columns(_order_rows(analysis.orders))]))
    for note in (*log.remarks, *log.notes, *analysis.filters.notes):
        click.echo(f"note: {note}", err=True)
    click.echo(f"{log.name}: {folder / 'table.csv'}, {folder / 'figure.png'}")


def _order_rows(orders: pd.DataFrame) -> list[list[str]]:
    rows = [[name.replace("^2", "²").replace("_", " ") for name in orders.columns]]
    for _, row in orders.iterrows():
        rows.append([row["channel"], *(_cell(value) for value in row.iloc[1:])])
    return rows


def _cell(value: float) -> str:
    return "–" if value != value else f"{value:.4g}"
