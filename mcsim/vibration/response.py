"""Frequency response of sensors from a sweep, band by band.

The phase of a sweep is known: in each sixth of an octave its sine and cosine, and a constant,
are fitted to what a sensor saw.  Amplitude over that of the truth is the sensor's gain; of a
first-order low-pass at f_c it is 1/√(1 + (f/f_c)²), with a phase of −arctan(f/f_c).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcsim.vibration.excitations import ExcitationBlock
from mcsim.vibration.platform import Seen

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: Bands per octave.
_PER_OCTAVE = 6
_HALF_POWER = math.sqrt(0.5)
#: A band of less has no amplitude.
_FEWEST_SAMPLES, _FEWEST_CYCLES = 12, 0.75


@dataclass(frozen=True)
class _Fit:
    """Amplitude and its standard uncertainty (m/s²), and phase (rad)."""

    amplitude: float
    u_amplitude: float
    phase: float


def responses(
    seen: Sequence[Seen], reference: int | None, excitation: ExcitationBlock, duration: float
) -> pd.DataFrame | None:
    """One row per sensor and frequency; None where the excitation is no sweep.

    Bands that end above half a sensor's rate are left out: there it sees their image.
    """
    import pandas as pd

    rows = [list(_rows(one, excitation, duration)) for one in seen]
    if not any(rows):
        return None
    held = {row["frequency [Hz]"]: row for row in rows[reference]} if reference is not None else {}
    if reference is not None:
        for row in (row for own in rows for row in own):
            other = held.get(row["frequency [Hz]"])
            deviation = row["gain"] / other["gain"] - 1.0 if other else math.nan
            row["gain_from_reference [%]"] = 100.0 * deviation
    return pd.DataFrame([row for own in rows for row in own])


def _rows(seen: Seen, excitation: ExcitationBlock, duration: float) -> Iterator[dict[str, Any]]:
    cycles = excitation.cycles(seen.time, duration)
    if cycles is None or seen.ideal is None:
        return
    frequency = np.gradient(cycles, seen.time)
    for low, high in _bands(excitation, duration):
        inside = (frequency >= low) & (frequency < high)
        if not _enough(cycles, inside) or high > seen.log.rate / 2.0:
            continue
        turn = 2.0 * math.pi * cycles[inside]
        own, true = _fit(seen.signal[inside], turn), _fit(seen.ideal[inside], turn)
        yield {
            "sensor": seen.name,
            "frequency [Hz]": math.sqrt(low * high),
            "amplitude [m/s^2]": own.amplitude,
            "u_amplitude [m/s^2]": own.u_amplitude,
            "gain": own.amplitude / true.amplitude if true.amplitude else math.nan,
            "u_gain": own.u_amplitude / true.amplitude if true.amplitude else math.nan,
            "phase [deg]": _degrees(own.phase - true.phase),
        }


def _bands(excitation: ExcitationBlock, duration: float) -> list[tuple[float, float]]:
    """Sixths of an octave between the ends of the sweep; the same for all sensors."""
    ends = np.array([0.0, duration])
    step = 1e-6 * duration
    cycles = excitation.cycles(np.concatenate([ends, ends + np.array([step, -step])]), duration)
    assert cycles is not None
    first, last = sorted(abs(cycles[2:] - cycles[:2]) / step)
    count = max(1, round(_PER_OCTAVE * math.log2(last / first)))
    edges = np.geomspace(first, last, count + 1)
    return list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))


def _enough(cycles: Array, inside: NDArray[np.bool_]) -> bool:
    if inside.sum() < _FEWEST_SAMPLES:
        return False
    return bool(np.ptp(cycles[inside]) >= _FEWEST_CYCLES)


def _fit(signal: Array, turn: Array) -> _Fit:
    """Least squares of a sine, a cosine and a constant."""
    design = np.stack([np.sin(turn), np.cos(turn), np.ones_like(turn)], axis=1)
    (sine, cosine, constant), *_ = np.linalg.lstsq(design, signal, rcond=None)
    left = signal - design @ np.array([sine, cosine, constant])
    variance = float(left @ left) / (len(signal) - 3)
    amplitude = math.hypot(sine, cosine)
    along = np.array([sine, cosine, 0.0]) / amplitude if amplitude else np.array([1.0, 0.0, 0.0])
    spread = float(along @ np.linalg.inv(design.T @ design) @ along)
    return _Fit(amplitude, math.sqrt(variance * spread), math.atan2(cosine, sine))


def _degrees(angle: float) -> float:
    """Between -180° and 180°."""
    return math.degrees(math.remainder(angle, 2.0 * math.pi))


def half_power(table: pd.DataFrame, sensor: str) -> float:
    """Frequency (Hz) at which a sensor's gain first falls below 1/√2; nan if it does not."""
    rows = table[table["sensor"] == sensor]
    frequency, gain = rows["frequency [Hz]"].to_numpy(), rows["gain"].to_numpy()
    below = np.flatnonzero((gain[1:] < _HALF_POWER) & (gain[:-1] >= _HALF_POWER))
    if not len(below):
        return math.nan
    two = slice(int(below[0]), int(below[0]) + 2)
    falling = gain[two][::-1], np.log(frequency[two])[::-1]
    return float(np.exp(np.interp(_HALF_POWER, *falling)))
