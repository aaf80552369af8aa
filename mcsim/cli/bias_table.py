"""``mcsim table bias-tracking``: Table 5.8 of the thesis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mcsim.vibration.bias_table import TrackedBias

_CONCLUSION = """\
RMSE in 1e-4 m/s². exact, simulated: error of the Kalman filter against the true bias of {hours:g} h
logs at {rate:g} Hz, with Tc and σ of Table 5.7 and noise densities of Table 5.2 (one sample's noise
is ND √Fs, as the thesis has it); at own rate: exact at the rate of Table 5.2; from average:
distance of the estimate from a moving average of the same log over {average:g} s. The thesis knows
no true bias; it compares with such an average, whose length it does not print, nor the rate. From
{rate:g} Hz to the own rates the exact value changes by up to {change:.1%}."""


@click.command("bias-tracking")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
def bias_tracking(seed: int) -> None:
    """Tracking a sensor's bias (Table 5.8), printed, in closed form, and simulated."""
    from mcsim.cli.progress import announce_compilation
    from mcsim.cli.tables import columns
    from mcsim.vibration.bias_table import AVERAGE, DURATION, RATE, tracked_biases

    announce_compilation()
    head = ["sensor", "Tc [s]", "σ", "printed", f"exact ({RATE:g} Hz)", "at own rate"]
    rows = [[*head, "simulated", "from average"]]
    entries = list(tracked_biases(seed))
    for entry in entries:
        errors = (
            entry.model.deviation,
            entry.printed,
            entry.exact,
        )
        time = f"{entry.model.correlation_time:g}"
        own = f"{1e4 * entry.exact_own:.3g} ({entry.own_rate:g} Hz)"
        found = (f"{1e4 * value:.3g}" for value in (entry.simulated, entry.from_average))
        rows.append([entry.sensor, time, *(f"{1e4 * e:.3g}" for e in errors), own, *found])
    click.echo("\n".join(columns(rows)))
    change = max(abs(entry.exact_own / entry.exact - 1.0) for entry in entries)
    click.echo(
        _CONCLUSION.format(average=AVERAGE, rate=RATE, hours=DURATION / 3600.0, change=change)
    )
    click.echo(useless_words(entries))


def useless_words(entries: Sequence[TrackedBias]) -> str:
    """Whose printed error exceeds the deviation of the bias itself."""
    worse = [e.sensor for e in entries if e.printed > e.model.deviation]
    if not worse:
        return "No printed value exceeds the deviation of its sensor's bias."
    return (
        f"Printed values above the deviation of the bias itself: {', '.join(worse)}; an estimate "
        "of zero would do better."
    )
