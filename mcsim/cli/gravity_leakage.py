"""``mcsim table gravity-leakage``: Table 1 of the application note."""

from __future__ import annotations

from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mcsim.systems.strapdown.gravity_leakage import Leakage

_UNITS = {"acceleration": "m/s²", "velocity": "m/s", "position": "m"}
_TIMES = {1.0: "", 10.0: " at 10 s", 60.0: " at 1 min", 600.0: " at 10 min", 3600.0: " at 1 h"}
_HEADER = ["angle", "printed", "exact", "g = 9.8", "simulated", "printed / (g = 9.8)"]
_CONCLUSION = """\
exact: standard gravity, 9.80665 m/s²; simulated: the strapdown kernel at {rate:g} Hz with the
note's recursion, which lags by T/t. Beyond some minutes the earth's curvature would bound the
error (Schuler), in neither column."""
#: Printed values that differ by less do so by rounding.
_ROUNDED = 0.05


@click.command("gravity-leakage")
@click.option(
    "--csv", "file", type=click.Path(path_type=Path, dir_okay=False), help="Also write a CSV file."
)
def gravity_leakage(file: Path | None) -> None:
    """Errors of a vehicle at rest whose attitude is wrong, printed and recomputed."""
    from mcsim.cli.progress import announce_compilation
    from mcsim.systems.strapdown import gravity_leakage as source

    announce_compilation()
    entries = list(source.gravity_leakage())
    if file is not None:
        _write(entries, file)
    click.echo(_text(entries, source.RATE))


def _text(entries: list[Leakage], rate: float) -> str:
    from mcsim.cli.tables import columns

    rows: dict[tuple[str, float], list[list[str]]] = {}
    for entry in entries:
        numbers = (entry.printed, entry.exact, entry.with_9_8, entry.simulated)
        cells = [entry.angle, *map(_plain, numbers), f"{entry.ratio:.3f}"]
        rows.setdefault((entry.quantity, entry.time), [_HEADER]).append(cells)
    blocks = [
        "\n".join([f"{quantity} error{_TIMES[time]} [{_UNITS[quantity]}]", *columns(block)])
        for (quantity, time), block in rows.items()
    ]
    return "\n\n".join([*blocks, f"{verdict(entries)}\n{_CONCLUSION.format(rate=rate)}"])


def verdict(entries: list[Leakage]) -> str:
    """How the printed values compare with g sin(angle), a t and a t²/2, from their ratios."""
    ratios = {name: [entry.ratio for entry in entries if entry.quantity == name] for name in _UNITS}
    others = [*ratios["acceleration"], *ratios["velocity"]]
    off = max(abs(ratio - 1.0) for ratio in others)
    first = (
        "Accelerations are g sin(angle), velocities a t: as printed, to the note's rounding."
        if off < _ROUNDED
        else "Accelerations are g sin(angle), velocities a t; printed values differ by up to "
        f"{off:.0%}."
    )
    middle = median(ratios["position"])
    second = "Positions are a t²/2, which is what the note's own recursion gives; the printed ones "
    if abs(middle / 2.0 - 1.0) < _ROUNDED:
        second += f"are a t²,\ntoo large by a factor of two (median ratio {middle:.2f})."
    elif abs(middle - 1.0) < _ROUNDED:
        second += f"agree\n(median ratio {middle:.2f})."
    else:
        second += f"are\n{middle:.2f} times that (median)."
    return f"{first}\n{second}"


def _plain(number: float) -> str:
    """Four significant digits without an exponent."""
    rounded = float(f"{number:.4g}")
    return f"{rounded:,.0f}" if rounded >= 1000.0 else f"{rounded:g}"


def _write(entries: list[Leakage], file: Path) -> None:
    import pandas as pd

    from mcsim.store import readable_errors, write_whole

    frame = pd.DataFrame(
        {
            "quantity": [e.quantity for e in entries],
            "time [s]": [e.time for e in entries],
            "angle": [e.angle for e in entries],
            "unit": [_UNITS[e.quantity] for e in entries],
            "printed": [e.printed for e in entries],
            "exact": [e.exact for e in entries],
            "g = 9.8": [e.with_9_8 for e in entries],
            "simulated": [e.simulated for e in entries],
        }
    )
    with readable_errors(file.parent):
        write_whole(file, lambda path: frame.to_csv(path, index=False, lineterminator="\n"))
