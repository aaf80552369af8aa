"""``mcsim characterise``: from a static log to a sensor's parameters."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcsim.cli.dialect_options import DialectName, Hertz, answers
from mcsim.errors import InputError

if TYPE_CHECKING:
    from mcsim.characterisation.analysis import Characterisation, Settings
    from mcsim.characterisation.fit import Intervals
    from mcsim.dialects import Reading

_ENDINGS = (".gz", ".xz", ".bz2", ".csv", ".txt", ".yaml", ".yml", ".bag", ".mcap", ".db3")


@click.command()
@click.argument("log", type=click.Path(path_type=Path))
@click.option(
    "--rate",
    type=Hertz(),
    metavar="HZ",
    help="Sampling rate of a log without time, or whose time stamps are no use.",
)
@click.option(
    "--columns",
    help="What the columns are: time, accel_x … gyro_z in order (- skips one), or accel_x=TITLE,….",
)
@click.option(
    "--units",
    help="Units in the order of the columns, or accelerometer=g,gyroscope=deg/s,time=ms; counts: "
    "accelerometer=16384 counts/g.",
)
@click.option("--topic", help="Topic of the IMU in a bag.")
@click.option("--start", type=float, metavar="S", help="Leave out what lies before (s).")
@click.option("--end", type=float, metavar="S", help="Leave out what lies after (s).")
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
    "--from",
    "dialect",
    type=DialectName("READABLE"),
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
@click.option("--quiet", is_flag=True, help="No progress, no summary.")
def characterise(
    log: Path,
    rate: float | None,
    columns: str | None,
    units: str | None,
    topic: str | None,
    start: float | None,
    end: float | None,
    fit_range: tuple[float, float] | None,
    non_overlapping: bool,
    confidence: str,
    intervals: Intervals,
    dialect: str | None,
    assume: tuple[str, ...],
    noise_convention: str | None,
    walk_convention: str | None,
    output: Path | None,
    quiet: bool,
) -> None:
    """Characterise a sensor from a static log; write sensor.yaml, tables and figures.

    LOG is a CSV file (plain or packed; units in its header or by --units; time in
    s, ms, µs, ns, dates and times, or --rate), a folder of EuRoC, TUM-VI or
    gnss-ins-sim, a ROS bag or MCAP file (extra mcsim[bags]), or ready parameters in any
    dialect that mcsim convert reads.

    Noise: N is Allan's (two-sided); a data sheet's one-sided density is √2 N.
    """
    folder = output or Path("output") / _stem(log)
    if _is_parameters(log):
        given = _conventions(noise_convention, walk_convention) | answers(assume)
        _parameters(log, dialect, given, rate, folder, quiet)
        return

    from mcsim.characterisation.analysis import characterise as analyse
    from mcsim.cli.progress import announce_compilation
    from mcsim.logs import ReadOptions, read_log

    settings = _settings(fit_range, non_overlapping, confidence, intervals)
    if not quiet:
        announce_compilation()
    step = _silent if quiet else _say
    step(f"reading {log}")
    read = read_log(log, ReadOptions(rate, columns, units, topic, start, end))
    result = analyse(read, settings, step)
    step("drawing")
    files = _write(result, folder)
    if not quiet:
        click.echo(_summary(result))
        click.echo(", ".join(map(str, files)))


def _settings(
    fit_range: tuple[float, float] | None,
    non_overlapping: bool,
    confidence: str,
    intervals: Intervals,
) -> Settings:
    from scipy.special import ndtr

    from mcsim.characterisation.analysis import Settings
    from mcsim.characterisation.bootstrap import largest_confidence
    from mcsim.units import parse_confidence

    if fit_range is not None and not 0.0 < fit_range[0] < fit_range[1]:
        raise InputError(
            f"--fit-range {fit_range[0]:g} {fit_range[1]:g}: two ascending times in s are needed"
        )
    probability = float(2.0 * ndtr(parse_confidence(confidence)) - 1.0)
    if intervals == "bootstrap" and probability > largest_confidence():
        raise InputError(
            f"--confidence {confidence}: a bootstrap knows intervals of up to "
            f"{100 * largest_confidence():g} %; give --intervals covariance"
        )
    return Settings(
        estimator="non-overlapping" if non_overlapping else "overlapping",
        fit_range=fit_range,
        confidence=probability,
        intervals=intervals,
    )


def _is_parameters(log: Path) -> bool:
    from mcsim.dialects import ENDINGS

    return log.suffix.lower() in ENDINGS


_WHITE = {"continuous": "continuous", "discrete": "per_sample"}


def _conventions(noise: str | None, walk: str | None) -> dict[str, str]:
    """The two options for imu_utils as answers to its questions."""
    given = {"n": _WHITE[noise]} if noise is not None else {}
    return given | ({"w": walk.replace("-", "_")} if walk is not None else {})


def _parameters(
    log: Path,
    dialect: str | None,
    given: dict[str, str],
    rate: float | None,
    folder: Path,
    quiet: bool,
) -> None:
    """Ready parameters, read as ``mcsim convert`` reads them, as a sensor file."""
    from mcsim.dialects import Assumptions, read_file, write_sensor

    if rate is not None and not 0.0 < rate < float("inf"):
        raise InputError(f"--rate {rate:g} must be above zero")
    assumptions = Assumptions(given, rate)
    reading = read_file(log, dialect, assumptions)
    text = write_sensor(reading.description, "allan", assumptions)
    file = _write_texts(folder, {"sensor.yaml": _with_origin(text, reading, log)})[0]
    if not quiet:
        notes = [f"note: {note}" for note in reading.notes]
        click.echo("\n".join([*notes, _told(text), str(file)]))


def _with_origin(text: str, reading: Reading, log: Path) -> str:
    """The sensor file with a line for each note and where it comes from."""
    from mcsim.version import __version__

    head = [f"Written by mcsim {__version__}.", *(f"Note: {note}" for note in reading.notes)]
    source = log.name.replace("\\", "\\\\").replace('"', '\\"')
    return "".join(f"# {line}\n" for line in head) + text + f'source: "parameters of {source}"\n'


def _told(text: str) -> str:
    """The convention: the comment that the dialect begins with."""
    lines = [line[2:] for line in text.splitlines() if line.startswith("# ")]
    return " ".join(lines)


def _write(result: Characterisation, folder: Path) -> list[Path]:
    """Everything is made before anything is written."""
    from mcsim.characterisation.sensor_file import sensor_file
    from mcsim.characterisation.tables import allan_table, psd_table
    from mcsim.figures.allan import draw_allan, draw_psd
    from mcsim.figures.style import write_figure

    texts = {
        "sensor.yaml": sensor_file(result),
        "allan.csv": allan_table(result).to_csv(index=False, lineterminator="\n"),
        "psd.csv": psd_table(result).to_csv(index=False, lineterminator="\n", float_format="%.9g"),
    }
    figures = {"allan": draw_allan(result), "psd": draw_psd(result)}
    files = _write_texts(folder, texts)
    for name, figure in figures.items():
        files += write_figure(figure, folder, name)
    return files


def _write_texts(folder: Path, texts: dict[str, str]) -> list[Path]:
    from mcsim.store import readable_errors, write_whole

    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        return [
            write_whole(folder / name, lambda path, text=text: _put(path, text))  # type: ignore[misc]
            for name, text in texts.items()
        ]


def _put(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _summary(result: Characterisation) -> str:
    from mcsim.characterisation.sensor_file import KEYS, SAMPLE, written
    from mcsim.characterisation.verdict import noise_density, number, verdict
    from mcsim.cli.tables import columns

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
            *verdict(result),
            "",
            *(f"- {note}" for note in notes),
        ]
    )


def _stem(log: Path) -> str:
    name = log.resolve().name
    while Path(name).suffix.lower() in _ENDINGS:
        name = Path(name).stem
    return name or "log"


def _silent(_: str) -> None:
    return None


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
