"""The strapdown rules without a scenario around them: ideal samples to states over time."""

from __future__ import annotations

import numpy as np

from mcsim.kernels import strapdown
from mcsim.sensors.layout import no_terms
from mcsim.simulation.problem import Array
from mcsim.simulation.running import Sensors, run
from mcsim.units import STANDARD_GRAVITY


def integrated(
    start: strapdown.Motion,
    rows: Array,
    rule: str,
    interval: float,
    previous_share: float = 0.5,
    gravity: float = STANDARD_GRAVITY,
) -> Array:
    """States (9, n + 1) that undisturbed samples (n + 1, 6) are integrated to from ``start``.

    Position and velocity (along, across, height), roll, pitch, heading; ``rows`` hold turns per
    interval, one row late for the forward Euler rule.
    """
    kind = strapdown.Strapdown
    nothing = np.zeros(kind.CHANNELS)
    second_order = rule in ("trapezoidal", "two_sample")
    turns = np.max(np.abs(rows[:, strapdown.TURNS]), axis=0)
    system = kind(
        way=strapdown.way_of(rule, float(np.linalg.norm(turns))),
        interval=interval,
        gravity=gravity,
        previous_share=previous_share if second_order else 0.0,
        coning=1.0 / 12.0 if rule == "two_sample" else 0.0,
        draws=False,
        levelled=False,
        rest=strapdown.Force(0.0, 0.0, gravity),
        deviations=strapdown.NO_DEVIATIONS,
        start=start,
        end=strapdown.AT_ORIGIN,
    )
    history = np.empty((kind.HISTORY, len(rows), 1))
    sensors = Sensors(rows, nothing, no_terms(kind.CHANNELS))
    run(system, 0, 0, 1, sensors, history=history)
    return history[:, :, 0]
