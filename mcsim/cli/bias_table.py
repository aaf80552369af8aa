"""``mcsim table bias-tracking``: Table 5.8 of the thesis."""

from __future__ import annotations

import click

_CONCLUSION = """\
RMSE in 1e-4 m/s². exact, simulated: error of the Kalman filter against the true bias of 14 h logs
with Tc and σ of Table 5.7 and noise densities of Table 5.2; from average: distance of the estimate
from a moving average of the same log over {average:g} s. The thesis knows no true bias; it compares
with such an average, whose length it does not print. The BNO055's printed value exceeds the
deviation of its bias: an estimate of zero would do better."""


@click.command("bias-tracking")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
def bias_tracking(seed: int) -> None:
    """Tracking a sensor's bias (Table 5.8), printed, in closed form, and simulated."""
    from mcsim.cli.progress import announce_compilation
    from mcsim.cli.tables import columns
    from mcsim.vibration.bias_table import AVERAGE, tracked_biases

    announce_compilation()
    rows = [["sensor", "Tc [s]", "σ", "printed", "exact", "simulated", "from average"]]
    for entry in tracked_biases(seed):
        errors = (
            entry.model.deviation,
            entry.printed,
            entry.exact,
            entry.simulated,
            entry.from_average,
        )
        time = f"{entry.model.correlation_time:g}"
        rows.append([entry.sensor, time, *(f"{1e4 * value:.3g}" for value in errors)])
    click.echo("\n".join(columns(rows)))
    click.echo(_CONCLUSION.format(average=AVERAGE))
