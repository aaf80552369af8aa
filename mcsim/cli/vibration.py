"""``mcsim vibration``: a measured log or a simulated one, filtered, measured and drawn."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import click

from mcsim.cli.command import Command
from mcsim.cli.notes import note, say, silent
from mcsim.cli.options import QUIET, output

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.api.sensor_comparison import SoughtTones
    from mcsim.api.vibration import FilterOptions, LogOptions
    from mcsim.vibration.analysis import Analysis

#: Seconds before progress is told, and between two lines of it.
_PATIENCE = 2.0


class _Options(TypedDict):
    output: Path
    rpm: float | None
    cylinders: int | None
    sensor: str | None
    sensors: str | None
    reference: str | None
    tones: tuple[str, ...]
    align: bool
    high_pass: str | None
    low_pass: str | None
    moving_average: int | None
    rate: str | None
    stamps: str | None
    channels: tuple[str, ...]
    topic: str | None
    unit: str | None
    start: float | None
    end: float | None
    quiet: bool


@click.command()
@click.argument(
    "given",
    metavar="LOG…|SCENARIO",
    nargs=-1,
    required=True,
    type=click.Path(path_type=Path),
)
@output("the log or scenario gets a folder")
@click.option("--rpm", type=float, help="Speed of a four-stroke engine: marks its orders.")
@click.option("--cylinders", type=click.IntRange(1, 64), help="Of that engine; 4 if absent.")
@click.option("--sensor", help="Another built-in sensor than the scenario's.")
@click.option(
    "--sensors",
    metavar="A,B@RATE,…",
    help="Compare sensors that see the scenario: names or sensor files, each at its own rate or "
    "at that behind @; platform for those of the vibration thesis, all for all built-in ones.",
)
@click.option(
    "--reference",
    metavar="SENSOR|LOG",
    help="What the others are held against; MTN-1100 if absent and among them.",
)
@click.option(
    "--tone",
    "tones",
    multiple=True,
    metavar="'14 Hz'",
    help="Compare at this frequency too.",
)
@click.option("--align", is_flag=True, help="Bring the clocks of logs together by correlation.")
@click.option("--high-pass", metavar="'2 Hz'", help="Cut-off; 0 Hz for none.")
@click.option("--low-pass", metavar="'50 Hz'", help="Cut-off; 0 Hz for none.")
@click.option("--moving-average", type=click.IntRange(0), help="Samples; 10 if absent, 0 for none.")
@click.option(
    "--rate",
    metavar="'100 Hz'",
    help="Of a log without a time column, or whose time stamps are no use.",
)
@click.option("--time", "stamps", metavar="'NAME in UNIT'", help="Column of a log's time stamps.")
@click.option(
    "--channel",
    "channels",
    multiple=True,
    help="Column of a log; all that fit if none. Of several logs, the one that each holds.",
)
@click.option(
    "--unit",
    help="Of columns without one: those of --channel, else those named like an acceleration; "
    "also counts, '16384 counts/g'.",
)
@click.option("--topic", help="Topic of the IMU in a bag.")
@click.option("--start", type=float, metavar="S", help="Leave out what lies before (s) in a log.")
@click.option("--end", type=float, metavar="S", help="Leave out what lies after (s) in a log.")
@QUIET
def vibration(given: tuple[Path, ...], **options: Unpack[_Options]) -> None:
    """Analyse the vibration in a log, or simulate a scenario and analyse that.

    A log has a header with units ("time [ms],az [m/s²]"), or they are given by --time and --unit;
    dates and times need none. It is of any format that mcsim characterise reads.

    Filters the channels, and writes peak, RMS, signal-to-noise ratio, velocity and displacement,
    spectra, engine orders and a figure.

    Several logs, one per sensor, or a scenario with --sensors are compared: ratios, frequency and
    amplitude of each tone, against the truth and a reference; of an elevator velocity and height,
    of a sweep the frequency response. A scenario beside logs is what shook them.
    """
    if len(given) > 1 or _compares(options):
        _compare(given, options)
    else:
        _analyse(given[0], options)


def _compares(options: _Options) -> bool:
    return bool(options["sensors"] or options["reference"] or options["tones"] or options["align"])


def _analyse(given: Path, options: _Options) -> None:
    from mcsim.api.vibration import analyse_vibration

    quiet = options["quiet"]
    found = analyse_vibration(
        given,
        sensor=options["sensor"],
        filters=_filters(options),
        rpm=options["rpm"],
        cylinders=options["cylinders"],
        read=_reading(options),
        progress=_progress(given.stem, quiet),
        tell=silent if quiet else say,
    )
    folder = options["output"] / found.analysis.log.name
    found.write(folder)
    if not quiet:
        _report(found.analysis, folder)


def _compare(given: tuple[Path, ...], options: _Options) -> None:
    from mcsim.api.sensor_comparison import compare_vibrations
    from mcsim.errors import InputError
    from mcsim.vibration.comparison_text import comparison_text

    if options["sensor"] is not None:
        raise InputError("--sensor: one sensor alone; to compare several give --sensors A,B,…")
    quiet = options["quiet"]
    found = compare_vibrations(
        given,
        sensors=options["sensors"],
        reference=options["reference"],
        filters=_filters(options),
        seek=_seeking(options),
        read=_reading(options),
        align=options["align"],
        tell=silent if quiet else say,
    )
    folder = options["output"] / found.name
    files = found.write(folder)
    if quiet:
        return
    click.echo(comparison_text(found.found))
    for text in (*found.notes, *found.filter_notes()):
        note(text)
    click.echo("\n".join(str(file) for file in files if _is_shown(file)))


COMMAND = Command("vibration", vibration)


def _filters(options: _Options) -> FilterOptions:
    """What was given of the filters."""
    given: dict[str, Any] = {
        "moving_average": options["moving_average"],
        "high_pass": options["high_pass"],
        "low_pass": options["low_pass"],
    }
    chosen: Any = {key: value for key, value in given.items() if value is not None}
    filters: FilterOptions = chosen
    return filters


def _is_shown(file: Path) -> bool:
    return file.suffix in (".csv", ".png") and not file.name.startswith("log-")


def _seeking(options: _Options) -> SoughtTones:
    """What was given of the tones."""
    given: dict[str, Any] = {
        "rpm": options["rpm"],
        "cylinders": options["cylinders"],
        "tones": tuple(_hertz(tone) for tone in options["tones"]) or None,
    }
    chosen: Any = {key: value for key, value in given.items() if value is not None}
    seek: SoughtTones = chosen
    return seek


def _reading(options: _Options) -> LogOptions:
    """What was given of how a log is read."""
    cut = options["start"], options["end"]
    given: dict[str, Any] = {
        "unit": options["unit"],
        "rate": _hertz(options["rate"]),
        "channels": options["channels"] or None,
        "time": options["stamps"],
        "topic": options["topic"],
        "cut": cut if cut != (None, None) else None,
    }
    chosen: Any = {key: value for key, value in given.items() if value is not None}
    read: LogOptions = chosen
    return read


def _hertz(rate: str | None) -> float | None:
    from mcsim.units import KINDS, parse

    return parse(rate, KINDS["frequency"]) if rate is not None else None


def _progress(name: str, quiet: bool) -> Callable[[float], None]:
    """Tells the share done, once it takes long."""
    last = time.monotonic()

    def tell(share: float) -> None:
        nonlocal last
        if not quiet and time.monotonic() - last > _PATIENCE:
            last = time.monotonic()
            say(f"{name}: {share:.0%} simulated")

    return tell


def _report(analysis: Analysis, folder: Path) -> None:
    from mcsim.text_table import columns
    from mcsim.vibration.filter_words import in_words

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
    acting = f"filters: {'; '.join(in_words(analysis.filters))}"
    weakened = analysis.filters.notes
    if weakened and analysis.orders is not None:
        acting += "; what they leave of each tone is in the column `gain`"
    for text in (*log.remarks, *log.notes, *weakened, acting):
        note(text)
    click.echo(f"{log.name}: {folder / 'table.csv'}, {folder / 'figure.png'}")


def _order_rows(orders: pd.DataFrame) -> list[list[str]]:
    rows = [[name.replace("^2", "²").replace("_", " ") for name in orders.columns]]
    for _, row in orders.iterrows():
        rows.append([row["channel"], *(_cell(value) for value in row.iloc[1:])])
    return rows


def _cell(value: float) -> str:
    return "–" if value != value else f"{value:.4g}"
