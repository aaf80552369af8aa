"""Sensors beside each other: figures, signal-to-noise ratios and tones of the same vibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcsim.vibration.excitations import ExcitationBlock
from mcsim.vibration.excitations.excitation import Tone
from mcsim.vibration.filter_words import band
from mcsim.vibration.platform import Seen
from mcsim.vibration.processing import Filters, filters, refuse_long_average
from mcsim.vibration.response import half_power, responses
from mcsim.vibration.scenario import Chain
from mcsim.vibration.spectra import Spectrum, amplitude_spectrum, signal_to_noise
from mcsim.vibration.tone import NOT_FOUND, FoundTone, find_tone
from mcsim.vibration.travel import Motion, motions, travel_table

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: A tone is looked for within this share of its frequency.
_WIDTH = 0.03
_NAN = float("nan")


@dataclass(frozen=True)
class Filtered:
    """One sensor's log (n,) in m/s²: without its mean, behind the chain, and the ideal likewise."""

    seen: Seen
    filters: Filters
    raw: Array
    filtered: Array
    ideal: Array | None
    ideal_filtered: Array | None

    def spectrum(self) -> Spectrum:
        """Amplitudes (Hann) of the raw log and, in the second column, behind the chain."""
        both = np.stack([self.raw, self.filtered], axis=1)
        return amplitude_spectrum(both, self.seen.log.rate)


@dataclass(frozen=True)
class Comparison:
    """What a comparison found.

    ``table`` has a row per sensor, ``orders`` one per sensor and tone, ``travel`` one per sensor
    and way of removing the drift, ``response`` one per sensor and frequency; what the excitation
    has nothing of is None.  ``reference`` is the place of the reference in ``sensors``, or None.
    """

    sensors: tuple[Filtered, ...]
    reference: int | None
    tones: tuple[Tone, ...]
    table: pd.DataFrame
    orders: pd.DataFrame | None
    motions: tuple[tuple[Motion, ...], ...] | None
    travel: pd.DataFrame | None
    response: pd.DataFrame | None


def compare(
    seen: Sequence[Seen],
    chain: Chain,
    reference: int | None = None,
    tones: Sequence[Tone] = (),
    excitation: ExcitationBlock | None = None,
    duration: float = _NAN,
) -> Comparison:
    """Hold what several sensors saw against the truth and against one of them.

    Parameters
    ----------
    seen : sequence of Seen
    chain : Chain
        The same for all of them; it acts at the rate of each.
    reference : int, optional
        Which of them is the reference.
    tones : sequence of Tone
        What to look for; without any, and without an excitation, the strongest one.
    excitation : ExcitationBlock, optional
        What is known to have shaken them, for ``duration`` (s).

    Raises
    ------
    InputError
        The moving average is longer than what one of them saw.
    """
    sensors = tuple(_filter(one, chain) for one in seen)
    sought = tuple(tones)
    if not sought and excitation is None:
        sought = _strongest(sensors[reference or 0])
    found = [[_find(sensor, tone) for tone in sought] for sensor in sensors]
    travel = excitation.travel if excitation else None
    moved = tuple(motions(s.seen, s.filters, travel) for s in sensors) if travel else ()
    names = [one.name for one in seen]
    response = responses(seen, reference, excitation, duration) if excitation else None
    return Comparison(
        sensors=sensors,
        reference=reference,
        tones=sought,
        table=_table(sensors, reference, response),
        orders=_orders(sensors, reference, sought, found) if sought else None,
        motions=moved if any(moved) else None,
        travel=travel_table(names, moved, travel) if any(moved) and travel else None,
        response=response,
    )


def _filter(seen: Seen, chain: Chain) -> Filtered:
    refuse_long_average(chain, seen.name, len(seen.time))
    steps = filters(chain, seen.log.rate)

    def both(signal: Array) -> tuple[Array, Array]:
        return signal - signal.mean(), steps.apply(signal[:, None])[:, 0]

    ideal = both(seen.ideal) if seen.ideal is not None else (None, None)
    return Filtered(seen, steps, *both(seen.signal), *ideal)


def _strongest(sensor: Filtered) -> tuple[Tone, ...]:
    """The strongest tone that the filters leave, if there is any."""
    spectrum = sensor.spectrum()
    frequency = float(spectrum.frequency[int(np.argmax(spectrum.levels[:, 1]))])
    return (Tone("strongest", frequency),) if frequency > 0.0 else ()


def _find(sensor: Filtered, tone: Tone) -> tuple[FoundTone, FoundTone]:
    """A tone in the raw and in the filtered log, where it is steady."""
    rate, time = sensor.seen.log.rate, sensor.seen.time
    if tone.frequency >= rate / 2.0:
        return NOT_FOUND, NOT_FOUND
    first, last = tone.span or (time[0], np.inf)
    inside = (time >= first) & (time < last)
    width = _WIDTH * tone.frequency
    raw, filtered = (
        find_tone(signal[inside], rate, tone.frequency, width)
        for signal in (sensor.raw, sensor.filtered)
    )
    return raw, filtered


def _table(
    sensors: Sequence[Filtered], reference: int | None, response: pd.DataFrame | None
) -> pd.DataFrame:
    import pandas as pd

    rows = [_row(sensor) for sensor in sensors]
    if response is not None:
        for row in rows:
            row["half_power_found [Hz]"] = half_power(response, row["sensor"])
    held = rows[reference] if reference is not None else {}
    for row, sensor in zip(rows, sensors, strict=True):
        row |= _from("reference", row, {} if row is held else held)
        if sensor.ideal is not None and sensor.ideal_filtered is not None:
            row |= _from("truth", row, _levels(sensor.ideal, sensor.ideal_filtered))
        row["lag [s]"] = sensor.seen.lag
    table = pd.DataFrame(rows)
    return table.drop(columns="lag [s]") if table["lag [s]"].isna().all() else table


def _row(sensor: Filtered) -> dict[str, Any]:
    seen, rate = sensor.seen, sensor.seen.log.rate
    lower, upper = band(sensor.filters)
    return {
        "sensor": seen.name,
        "rate [Hz]": rate,
        "bandwidth [Hz]": seen.bandwidth,
        "band_from [Hz]": lower,
        "band_to [Hz]": upper,
        "snr_raw [dB]": signal_to_noise(sensor.raw, rate),
        "snr_filtered [dB]": signal_to_noise(sensor.filtered, rate),
        **_levels(sensor.raw, sensor.filtered),
    }


def _levels(raw: Array, filtered: Array) -> dict[str, float]:
    return {
        f"{what}_{stage} [m/s^2]": float(level)
        for stage, signal in (("raw", raw), ("filtered", filtered))
        for what, level in (
            ("peak", np.abs(signal).max()),
            ("peak_to_peak", np.ptp(signal)),
            ("rms", np.sqrt(np.mean(signal**2))),
        )
    }


def _from(what: str, row: dict[str, Any], other: dict[str, Any]) -> dict[str, float]:
    """Deviations of peak and RMS from another's, in per cent."""
    return {
        f"{key}_from_{what} [%]": _per_cent(row[f"{key} [m/s^2]"], other[f"{key} [m/s^2]"])
        for key in ("peak_raw", "peak_filtered", "rms_raw", "rms_filtered")
        if other
    }


def _per_cent(value: float, of: float | None) -> float:
    return 100.0 * (value / of - 1.0) if of else _NAN


def _orders(
    sensors: Sequence[Filtered],
    reference: int | None,
    tones: Sequence[Tone],
    found: Sequence[Sequence[tuple[FoundTone, FoundTone]]],
) -> pd.DataFrame:
    """One row per sensor and tone."""
    import pandas as pd

    main = _dominant(tones, found[reference or 0])
    rows = []
    for i, sensor in enumerate(sensors):
        for j, tone in enumerate(tones):
            raw, filtered = found[i][j]
            gain = float(sensor.filters.gain(np.array([tone.frequency]))[0])
            row = {"sensor": sensor.seen.name, **_expected(tone, j == main), **_said(raw)}
            row |= _from_truth(raw, tone)
            if reference is not None:
                row |= _from_reference(found[i][j], found[reference][j])
            row |= {"gain": gain, "amplitude_filtered [m/s^2]": filtered.amplitude}
            row |= {"above_noise [dB]": raw.height, "stands_out": _yes(raw.above_noise)}
            rows.append(row)
    return pd.DataFrame(rows)


def _dominant(tones: Sequence[Tone], found: Sequence[tuple[FoundTone, FoundTone]]) -> int:
    """The strongest tone: of the truth, else of the reference."""
    levels = [
        raw.amplitude if tone.amplitude is None else tone.amplitude
        for tone, (raw, _) in zip(tones, found, strict=True)
    ]
    return int(np.argmax(np.nan_to_num(levels)))


def _expected(tone: Tone, dominant: bool) -> dict[str, Any]:
    return {
        "tone": tone.name,
        "order": _NAN if tone.order is None else tone.order,
        "dominant": _yes(dominant),
        "expected [Hz]": tone.frequency,
        "expected [m/s^2]": _NAN if tone.amplitude is None else tone.amplitude,
    }


def _said(raw: FoundTone) -> dict[str, float]:
    """What was found; of what noise alone may be, no frequency."""
    sure = raw.above_noise
    return {
        "found [Hz]": raw.frequency if sure else _NAN,
        "u_found [Hz]": raw.u_frequency if sure else _NAN,
        "amplitude [m/s^2]": raw.amplitude,
        "u_amplitude [m/s^2]": raw.u_amplitude,
    }


def _from_truth(raw: FoundTone, tone: Tone) -> dict[str, float]:
    sure = raw.above_noise
    known = sure and tone.amplitude is not None
    return {
        "frequency_from_truth [Hz]": raw.frequency - tone.frequency if known else _NAN,
        "amplitude_from_truth [%]": _per_cent(raw.amplitude, tone.amplitude) if known else _NAN,
    }


def _from_reference(
    found: tuple[FoundTone, FoundTone], held: tuple[FoundTone, FoundTone]
) -> dict[str, float]:
    """Deviations from the reference, with their uncertainties; nan where one is but noise."""
    (raw, filtered), (other, other_filtered) = found, held
    sure = raw.above_noise and other.above_noise and found is not held
    ratio = raw.amplitude / other.amplitude if sure else _NAN
    spread = np.hypot(raw.u_amplitude / raw.amplitude, other.u_amplitude / other.amplitude)
    return {
        "frequency_from_reference [Hz]": raw.frequency - other.frequency if sure else _NAN,
        "u_frequency_from_reference [Hz]": (
            float(np.hypot(raw.u_frequency, other.u_frequency)) if sure else _NAN
        ),
        "amplitude_from_reference [%]": 100.0 * (ratio - 1.0),
        "u_amplitude_from_reference [%]": 100.0 * float(ratio * spread),
        "filtered_from_reference [%]": (
            _per_cent(filtered.amplitude, other_filtered.amplitude) if sure else _NAN
        ),
    }


def _yes(true: bool) -> str:
    return "yes" if true else "no"
