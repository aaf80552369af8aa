"""``mcsim table sensors``: Tables 5.1 and 5.2 of the vibration thesis beside simulated values."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

if TYPE_CHECKING:
    import pandas as pd

_HEADS = {
    "std_printed [m/s^2]": "σ printed [m/s²]",
    "std_simulated [m/s^2]": "simulated",
    "density_printed [ug/sqrt(Hz)]": "density printed [µg/√Hz]",
    "density_by_bandwidth [ug/sqrt(Hz)]": "σ/√f_3dB",
    "density_by_spectrum [ug/sqrt(Hz)]": "Welch",
    "rate [Hz]": "rate [Hz]",
    "bandwidth [Hz]": "f_3dB [Hz]",
}


@click.command("sensors")
@click.option(
    "--noise",
    type=click.Choice(["allan", "density", "data_sheet"]),
    default="allan",
    show_default=True,
    help="Noise of the logs: Allan's N, B, K; measured densities; data sheets.",
)
@click.option("--duration", metavar="'20 s'", default="20 s", show_default=True)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
@click.option("--output", type=click.Path(path_type=Path), help="Folder for sensors.csv.")
def sensor_table_command(
    noise: Literal["allan", "density", "data_sheet"],
    duration: str,
    seed: int,
    output: Path | None,
) -> None:
    """Deviations and noise densities of the vibration thesis (Tables 5.1 and 5.2)."""
    from mcsim.cli.tables import columns
    from mcsim.errors import InputError
    from mcsim.units import KINDS, parse
    from mcsim.vibration.sensor_tables import NOISE, remarks, sensor_table

    seconds = parse(duration, KINDS["time"])
    if not 1.0 <= seconds <= 3600.0:
        raise InputError(f'--duration "{duration}" must lie between 1 s and 1 h')
    frame = sensor_table(noise, seconds, seed)
    click.echo(f"logs of {seconds:g} s, noise: {NOISE[noise]}")
    click.echo("\n".join(columns(_rows(frame))))
    click.echo("\nwhere the printed values cannot all hold:")
    for remark in remarks():
        click.echo(f"  {remark}")
    if output is not None:
        click.echo(_write(frame, output))


def _rows(frame: pd.DataFrame) -> list[list[str]]:
    rows = [["sensor", "axis", *_HEADS.values()]]
    for _, row in frame.iterrows():
        rows.append([row["sensor"], row["axis"], *(f"{row[key]:.4g}" for key in _HEADS)])
    return rows


def _write(frame: pd.DataFrame, folder: Path) -> Path:
    from mcsim.store import readable_errors, write_whole

    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        return write_whole(
            folder / "sensors.csv",
            lambda path: frame.to_csv(path, index=False, lineterminator="\n", float_format="%.9g"),
        )
