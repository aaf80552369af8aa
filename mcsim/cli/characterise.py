"""``mcsim characterise``: from a static log to a sensor's parameters."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import click

from mcsim.cli.command import Command
from mcsim.cli.dialect_options import DialectName, answers
from mcsim.cli.log_options import log_options, read_options
from mcsim.cli.notes import say, silent
from mcsim.cli.options import QUIET

if TYPE_CHECKING:
    from mcsim.characterisation.analysis import Characterisation
    from mcsim.characterisation.fit import Intervals

_PACKED = (".gz", ".xz", ".bz2", ".zst")
_PICTURES = ("allan", "psd", "histogram", "autocorrelation", "bias")
_FILES = (
    "sensor.yaml",
    "normality.csv",
    *(f"{name}.{ending}" for name in _PICTURES for ending in ("csv", "png", "svg")),
)


class _Options(TypedDict):
    rate: float | None
    columns: str | None
    units: str | None
    topic: str | None
    start: float | None
    end: float | None
    fit_range: tuple[float, float] | None
    non_overlapping: bool
    confidence: str
    intervals: Intervals
    compare: str | None
    dialect: str | None
    assume: tuple[str, ...]
    noise_convention: str | None
    walk_convention: str | None
    output: Path | None
    quiet: bool


@click.command()
@click.argument("logs", metavar="LOG…", nargs=-1, required=True, type=click.Path(path_type=Path))
@log_options
@click.option(
    "--fit-range",
    type=float,
    nargs=2,
    metavar="FROM TO",
    help="Cluster times of the fit in s; all that follow the model if absent.",
)
@click.option("--non-overlapping", is_flag=True, help="Report non-overlapping Allan deviations.")
@click.option("--confidence", default="95 %", show_default=True, help="Of all intervals.")
@click.option(
    "--intervals",
    type=click.Choice(["bootstrap", "covariance"]),
    default="bootstrap",
    show_default=True,
    help="Of N, B and K: from blocks of the log, or from the noise that was fitted.",
)
@click.option(
    "--compare",
    metavar="FROM:TO",
    help="Compare what lies before a bad stretch (s) and after it: level, deviation, N, with "
    "tests; auto looks for it, FROM:TO,FROM:TO names the two that are compared.",
)
@click.option(
    "--from",
    "dialect",
    type=DialectName("readable"),
    help="Dialect of ready parameters; recognised if absent.",
)
@click.option(
    "--assume",
    multiple=True,
    metavar="KEY=MEANING",
    help="Answer to what ready parameters leave open, as in mcsim convert.",
)
@click.option(
    "--noise-convention",
    type=click.Choice(["continuous", "discrete"]),
    help="imu_utils: --assume n=continuous (Allan's N), or n=per_sample (N √rate).",
)
@click.option(
    "--walk-convention",
    type=click.Choice(["allan-minimum", "random-walk", "ignore"]),
    help="imu_utils: --assume w=allan_minimum, random_walk (Allan's K) or ignore.",
)
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    help="Folder for the results; output/LOG if absent.",
)
@QUIET
def characterise(logs: tuple[Path, ...], **options: Unpack[_Options]) -> None:
    """Characterise a sensor from a static log; write sensor.yaml, tables and figures.

    LOG is a CSV file (plain or packed; units in its header or by --units; time in
    s, ms, µs, ns, dates and times, or --rate), a folder of EuRoC, TUM-VI or
    gnss-ins-sim, a ROS bag or MCAP file (extra mcsim[bags]), or ready parameters in any
    dialect that mcsim convert reads.  Several logs are characterised one by one, and their Allan
    deviations drawn in one figure.

    Noise: N is Allan's (two-sided); a data sheet's one-sided density is √2 N.
    """
    folder = options["output"] or Path("output") / "-".join(_stem(log) for log in logs[:3])
    if len(logs) > 1:
        _several(logs, folder, options)
    elif _is_parameters(logs[0]):
        _parameters(logs[0], folder, options)
    elif options["compare"] is not None:
        _compare(logs[0], folder, options["compare"], options)
    else:
        _log(logs[0], folder, options)


COMMAND = Command("characterise", characterise)


def _begin(options: _Options) -> Callable[[str], None]:
    """What hears about progress."""
    from mcsim.cli.progress import announce_compilation

    if options["quiet"]:
        return silent
    announce_compilation()
    return say


def _arguments(options: _Options, tell: Callable[[str], None]) -> dict[str, Any]:
    return {
        "read": read_options(dict(options)),
        "fit_range": options["fit_range"],
        "overlapping": not options["non_overlapping"],
        "confidence": options["confidence"],
        "intervals": options["intervals"],
        "tell": tell,
    }


def _log(log: Path, folder: Path, options: _Options) -> None:
    from mcsim.api.characterise import characterise as characterisation_of

    tell = _begin(options)
    found = characterisation_of(log, **_arguments(options, tell))
    tell("drawing")
    found.write(folder)
    if not options["quiet"]:
        click.echo(_summary(found.analysis, found.verdict))
        click.echo(", ".join(str(folder / name) for name in _FILES))


def _several(logs: tuple[Path, ...], folder: Path, options: _Options) -> None:
    from mcsim.api.several_logs import characterise_several
    from mcsim.errors import InputError
    from mcsim.text_table import frame_text

    if options["compare"] is not None:
        raise InputError("--compare: takes one log; several are compared without it")
    for log in logs:
        if _is_parameters(log):
            raise InputError(f"{log}: holds parameters; several files must all be logs")
    tell = _begin(options)
    found = characterise_several(logs, **_arguments(options, tell))
    tell("drawing")
    found.write(folder)
    if not options["quiet"]:
        click.echo(frame_text(found.table))
        click.echo("N, B, K in SI units (m/s², rad/s; s), with the ends of their intervals")
        click.echo(f"{folder / 'allan.png'}, {folder / 'noise.csv'}, and a folder for each log")


def _compare(log: Path, folder: Path, stretches: str, options: _Options) -> None:
    from mcsim.api.compare_stretches import compare_stretches
    from mcsim.text_table import frame_text

    tell = _begin(options)
    found = compare_stretches(
        log, stretches, read=read_options(dict(options)), intervals=options["intervals"], tell=tell
    )
    found.write(folder)
    if not options["quiet"]:
        click.echo("; ".join(found.names))
        click.echo(frame_text(found.table))
        click.echo(
            f"u_of_change: standard uncertainty of after - before, in its unit. {found.words}"
        )
        click.echo(f"{folder / 'comparison.csv'}, {folder / 'comparison.png'}")


def _is_parameters(log: Path) -> bool:
    """Whether a name is one of a dialect's files, and no format of logs knows the file."""
    from mcsim.dialects import endings
    from mcsim.logs.formats import recognising

    return log.suffix.lower() in endings() and not recognising(log)


_WHITE = {"continuous": "continuous", "discrete": "per_sample"}


def _conventions(options: _Options) -> dict[str, str]:
    """The two options for imu_utils as answers to its questions."""
    noise, walk = options["noise_convention"], options["walk_convention"]
    given = {"n": _WHITE[noise]} if noise is not None else {}
    return given | ({"w": walk.replace("-", "_")} if walk is not None else {})


def _parameters(log: Path, folder: Path, options: _Options) -> None:
    """Ready parameters, read as ``mcsim convert`` reads them, as a sensor file."""
    from mcsim.api.convert import read_parameters

    given = _conventions(options) | answers(options["assume"])
    found = read_parameters(log, source=options["dialect"], assume=given, rate=options["rate"])
    found.write(folder)
    if not options["quiet"]:
        notes = [f"note: {note}" for note in found.notes]
        click.echo("\n".join([*notes, found.convention, str(folder / "sensor.yaml")]))


def _summary(result: Characterisation, verdict: list[str]) -> str:
    from mcsim.characterisation.sensor_file import KEYS, SAMPLE, written
    from mcsim.characterisation.verdict import noise_density, number
    from mcsim.text_table import columns

    rows = [
        [
            "channel",
            "N (two-sided)",
            "one-sided density",
            "B",
            "K",
            "bias Tc",
            "bias σ",
            "Kalman RMSE",
            "mean RMSE",
        ]
    ]
    for channel in result.channels:
        element = channel.channel.element
        kind, unit = SAMPLE[element]
        n, b, k = (number(channel.fit, element, term) for term in KEYS[element])
        bias = ["–"] * 4
        if channel.bias is not None:
            bias[2:] = [
                f"{float(written(x, unit, kind).split()[0]):.3g} {unit}"
                for x in (channel.bias.kalman_expected, channel.bias.mean_expected)
            ]
        process = channel.fit.gauss_markov
        if process is not None:
            sigma = float(written(process.model.deviation, unit, kind).split()[0])
            bias[:2] = [f"{process.model.correlation_time:.3g} s", f"{sigma:.3g} {unit}"]
        rows.append([channel.channel.name, n, noise_density(channel), b, k, *bias])
    notes = [f"{f.channel}: {f.text}" if f.channel else f.text for f in result.findings]
    return "\n".join(
        [
            *columns(rows),
            "",
            *verdict,
            "",
            *(f"- {note}" for note in notes),
        ]
    )


def _stem(log: Path) -> str:
    """The name without the endings that formats and dialects have."""
    from mcsim.dialects import endings as of_dialects
    from mcsim.logs.formats import endings as of_logs

    known = {*_PACKED, *of_logs(), *of_dialects()}
    name = log.resolve().name
    while Path(name).suffix.lower() in known:
        name = Path(name).stem
    return name or "log"
