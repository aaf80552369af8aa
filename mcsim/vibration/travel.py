"""Velocity and height of a run from rest to rest, by integration of what a sensor saw.

An offset b that is left grows into b t in velocity and b t²/2 in height.  Three ways to remove it:

* ``rest before``: the mean of the rest before the run is removed, gravity included.  What
  remains is that mean's own error, and noise: the velocity walks.
* ``rest before and after``: the mean over the run is removed, as the velocity is zero at both of
  its ends.  A steady offset is gone wholly; of noise a bridge remains.
* ``high-pass``: the chain's, on acceleration, velocity and height.  It removes the drift, and the
  run with it, which lies far below its cut-off; what remains is the hum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from mcsim.vibration.excitations.excitation import Travel
from mcsim.vibration.platform import Seen
from mcsim.vibration.processing import Filters

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

REST_BEFORE, AT_REST_TWICE, HIGH_PASS = "rest before", "rest before and after", "high-pass"
#: A rest of fewer samples has no mean worth removing.
_FEWEST = 16


@dataclass(frozen=True)
class Motion:
    """Velocity (m/s) and height (m), (n,), at ``time`` (s), and the true ones.

    ``drift`` says how the drift was removed.  ``u_height`` (m) is the standard deviation of the
    height at the end that the white noise of the rest makes; nan where it is not known.
    """

    drift: str
    time: Array
    velocity: Array
    height: Array
    true_velocity: Array
    true_height: Array
    u_height: float


def motions(seen: Seen, steps: Filters, travel: Travel) -> tuple[Motion, ...]:
    """The run by each way of removing the drift that the log allows; none of a run cut short."""
    time, signal, interval = seen.time, seen.signal, 1.0 / seen.log.rate
    if time[0] > travel.start or time[-1] < travel.end:
        return ()
    run = (time >= travel.start - interval) & (time <= travel.end + interval)
    before, after = time < travel.start, time > travel.end
    length = travel.end - travel.start
    walk = _deviation(signal, before, after) * math.sqrt(interval)
    ways: list[tuple[str, Array, float]] = []
    if before.sum() >= _FEWEST:
        rest = float(before.sum()) * interval
        spread = walk * math.sqrt(length**3 / 3.0 + length**4 / (4.0 * rest))
        ways.append((REST_BEFORE, signal - signal[before].mean(), spread))
    # The mean as the trapezoidal rule takes it: it leaves exactly no velocity.
    offset = np.trapezoid(signal[run]) / (run.sum() - 1)
    ways.append((AT_REST_TWICE, signal - offset, walk * math.sqrt(length**3 / 12.0)))
    found = [_integrated(way, time, acc, run, travel, u) for way, acc, u in ways]
    if steps.high_pass is not None:
        found.append(_behind_high_pass(seen, steps, run, travel))
    return tuple(found)


def _deviation(signal: Array, *rests: NDArray[np.bool_]) -> float:
    """Standard deviation at rest, of all rests that are long enough; nan if none is."""
    parts = [signal[rest] - signal[rest].mean() for rest in rests if rest.sum() >= _FEWEST]
    if not parts:
        return math.nan
    count = sum(map(len, parts)) - len(parts)
    return math.sqrt(sum(float(part @ part) for part in parts) / count)


def _integrated(
    drift: str,
    time: Array,
    signal: Array,
    run: NDArray[np.bool_],
    travel: Travel,
    u_height: float,
) -> Motion:
    velocity = _integral(signal[run], time[run])
    height = _integral(velocity, time[run])
    return Motion(drift, time[run], velocity, height, *travel.motion(time[run]), u_height)


def _integral(signal: Array, time: Array) -> Array:
    return np.asarray(cumulative_trapezoid(signal, time, initial=0), float)


def _behind_high_pass(seen: Seen, steps: Filters, run: NDArray[np.bool_], travel: Travel) -> Motion:
    filtered = steps.apply(seen.signal[:, None])
    velocity = steps.integrate(filtered)
    height = steps.integrate(velocity)
    time = seen.time[run]
    return Motion(
        f"{HIGH_PASS} {steps.chain.high_pass:g} Hz",
        time,
        velocity[run, 0],
        height[run, 0],
        *travel.motion(time),
        math.nan,
    )


def travel_table(
    names: Sequence[str], found: Sequence[Sequence[Motion]], travel: Travel
) -> pd.DataFrame:
    """One row per sensor and way of removing the drift: top speed, height, and their errors."""
    import pandas as pd

    return pd.DataFrame(
        [
            {"sensor": name, **_row(motion, travel)}
            for name, motions_of in zip(names, found, strict=True)
            for motion in motions_of
        ]
    )


def _row(motion: Motion, travel: Travel) -> dict[str, Any]:
    top = float(np.max(motion.velocity))
    true_top = float(np.max(motion.true_velocity))
    height = float(motion.height[-1])
    errors = motion.velocity - motion.true_velocity
    return {
        "drift_removed_by": motion.drift,
        "top_speed [m/s]": top,
        "top_speed_error [m/s]": top - true_top,
        "speed_at_end [m/s]": float(motion.velocity[-1]),
        "velocity_rms_error [m/s]": float(np.sqrt(np.mean(errors**2))),
        "height [m]": height,
        "height_error [m]": height - travel.distance,
        "u_height_of_white_noise [m]": motion.u_height,
    }
