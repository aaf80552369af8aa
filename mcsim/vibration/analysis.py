"""The analysis of a log: figures per channel, spectra, engine orders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcsim.vibration.excitations.excitation import Tone
from mcsim.vibration.log import Log
from mcsim.vibration.processing import Filters, filters, refuse_long_average
from mcsim.vibration.scenario import Chain
from mcsim.vibration.spectra import (
    Spectrogram,
    Spectrum,
    amplitude_spectrum,
    signal_to_noise,
    spectrogram,
    tone_amplitude,
    welch_spectrum,
)

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: A tone belongs to an order when it lies within this share of its frequency.
_ORDER_WIDTH = 0.03
#: Rows of a spectrum's table, per channel.
_MOST_ROWS = 20_000
#: The floor beside a tone is the median amplitude within this many half widths.
_FLOOR_WIDTH = 5.0


@dataclass(frozen=True)
class Engine:
    """A four-stroke engine whose orders are marked."""

    speed: float
    cylinders: int = 4

    @property
    def orders(self) -> tuple[float, ...]:
        """Crankshaft, firing order (half the cylinders fire per turn), and twice that."""
        firing = self.cylinders / 2.0
        return tuple(sorted({1.0, firing, 2.0 * firing}))

    def frequency(self, order: float) -> float:
        """Frequency of an order (Hz)."""
        return order * self.speed


@dataclass(frozen=True)
class Analysis:
    """What an analysis found; arrays (n, channels), raw and filtered without mean.

    ``tones`` are what was looked for: the orders of an engine, the tones of a scenario.
    """

    log: Log
    filters: Filters
    tones: tuple[Tone, ...]
    raw: Array
    filtered: Array
    table: pd.DataFrame
    orders: pd.DataFrame | None
    spectrum: pd.DataFrame
    density: pd.DataFrame
    amplitude: tuple[Spectrum, Spectrum]
    welch: tuple[Spectrum, Spectrum]

    def spectrogram(self, channel: int) -> Spectrogram:
        """Density over time of one raw channel."""
        return spectrogram(self.raw[:, channel], self.log.rate)

    @property
    def strongest(self) -> int:
        """The channel with the largest RMS after filtering."""
        return int(np.argmax(self.filtered.std(axis=0)))


def analyse(
    log: Log, chain: Chain, engine: Engine | None = None, tones: Sequence[Tone] = ()
) -> Analysis:
    """Filter a log, and take its figures and spectra.

    Parameters
    ----------
    log : Log
        Accelerations in m/s².
    chain : Chain
        Moving average, high-pass and low-pass.
    engine : Engine, optional
        Whose orders to look for.
    tones : sequence of Tone
        What else to look for, in the stretch of time where it is steady; those that are no
        engine's have no order.

    Raises
    ------
    InputError
        The moving average is longer than the log.
    """
    refuse_long_average(chain, log.name, len(log.samples))
    steps = filters(chain, log.rate)
    sought = _sought(engine, tones)
    raw: Array = log.samples - log.samples.mean(axis=0)
    filtered = steps.apply(log.samples)
    amplitude = amplitude_spectrum(raw, log.rate), amplitude_spectrum(filtered, log.rate)
    densities = welch_spectrum(raw, log.rate), welch_spectrum(filtered, log.rate)
    return Analysis(
        log=log,
        filters=steps,
        tones=tuple(sought),
        raw=raw,
        filtered=filtered,
        table=_table(log, raw, filtered, steps),
        orders=_orders(log, raw, filtered, steps, sought, amplitude[0]) if sought else None,
        spectrum=_tidy(log.channels, amplitude, "amplitude", "m/s^2"),
        density=_tidy(log.channels, densities, "density", "(m/s^2)^2/Hz"),
        amplitude=amplitude,
        welch=densities,
    )


def _table(log: Log, raw: Array, filtered: Array, steps: Filters) -> pd.DataFrame:
    """One row per channel and stage."""
    import pandas as pd

    velocity = steps.integrate(filtered)
    displacement = steps.integrate(velocity)
    rows: list[dict[str, Any]] = []
    for i, channel in enumerate(log.channels):
        for stage, signal in (("raw", raw), ("filtered", filtered)):
            row = {"channel": channel, "stage": stage, "mean [m/s^2]": log.samples[:, i].mean()}
            row |= _figures(signal[:, i], "m/s^2", "")
            row["snr [dB]"] = signal_to_noise(signal[:, i], log.rate)
            if stage == "filtered":
                row |= _figures(1e3 * velocity[:, i], "mm/s", "velocity ")
                row |= _figures(1e3 * displacement[:, i], "mm", "displacement ")
            rows.append(row)
    return pd.DataFrame(rows)


def _figures(signal: Array, unit: str, prefix: str) -> dict[str, float]:
    return {
        f"{prefix}peak [{unit}]": float(np.abs(signal).max()),
        f"{prefix}peak_to_peak [{unit}]": float(np.ptp(signal)),
        f"{prefix}rms [{unit}]": float(np.sqrt(np.mean(signal**2))),
    }


def _sought(engine: Engine | None, tones: Sequence[Tone]) -> list[Tone]:
    """The orders of an engine, and the tones that are none of them, by frequency."""
    orders = engine.orders if engine else ()
    found = [Tone(f"order {o:g}", engine.frequency(o), order=o) for o in orders if engine]
    found += [tone for tone in tones if tone.order is None or tone.order not in orders]
    return sorted(found, key=lambda tone: tone.frequency)


def _orders(
    log: Log,
    raw: Array,
    filtered: Array,
    steps: Filters,
    tones: Sequence[Tone],
    spectrum: Spectrum,
) -> pd.DataFrame:
    """The tone at each order: where it is, how large, and how far above the noise."""
    import pandas as pd

    rows = []
    for i, channel in enumerate(log.channels):
        for tone in tones:
            wanted = tone.frequency
            width = _ORDER_WIDTH * wanted
            steady = _steady(log, tone)
            before, found = tone_amplitude(raw[steady, i], log.rate, wanted, width)
            after, _ = tone_amplitude(filtered[steady, i], log.rate, wanted, width)
            rows.append(
                {
                    "channel": channel,
                    "order": float("nan") if tone.order is None else tone.order,
                    "expected [Hz]": wanted,
                    "found [Hz]": found,
                    "amplitude_raw [m/s^2]": before,
                    "amplitude_filtered [m/s^2]": after,
                    "gain": float(steps.gain(np.array([wanted]))[0]),
                    "above_noise [dB]": _above_noise(spectrum, i, wanted, width),
                }
            )
    return pd.DataFrame(rows)


def _steady(log: Log, tone: Tone) -> slice:
    """The samples in which a tone is steady."""
    if tone.span is None:
        return slice(None)
    first, last = np.searchsorted(log.time, tone.span)
    return slice(int(first), int(last))


def _above_noise(spectrum: Spectrum, channel: int, frequency: float, width: float) -> float:
    """Largest amplitude around a frequency over the median beside it (dB)."""
    width = max(width, 2.0 * float(spectrum.frequency[1]))
    away = np.abs(spectrum.frequency - frequency)
    near, beside = away <= width, (away > width) & (away <= _FLOOR_WIDTH * width)
    if not near.any() or not beside.any():
        return float("nan")
    levels = spectrum.levels[:, channel]
    return float(20.0 * np.log10(levels[near].max() / np.median(levels[beside])))


def _tidy(
    channels: Sequence[str], pair: tuple[Spectrum, Spectrum], what: str, unit: str
) -> pd.DataFrame:
    """Raw and filtered spectra, one row per channel and frequency.

    Of a long log's, neighbouring frequencies share a row: that of the largest raw value.
    """
    import pandas as pd

    raw, filtered = pair
    width = -(-len(raw.frequency) // _MOST_ROWS)
    tables = []
    for i, channel in enumerate(channels):
        rows = _largest_of_groups(raw.levels[:, i], width)
        tables.append(
            pd.DataFrame(
                {
                    "channel": channel,
                    "frequency [Hz]": raw.frequency[rows],
                    f"{what}_raw [{unit}]": raw.levels[rows, i],
                    f"{what}_filtered [{unit}]": filtered.levels[rows, i],
                }
            )
        )
    return pd.concat(tables, ignore_index=True)


def _largest_of_groups(levels: Array, width: int) -> NDArray[np.intp]:
    """Index of the largest of each ``width`` neighbours."""
    starts = np.arange(0, len(levels), width)
    padded = np.full(len(starts) * width, -np.inf)
    padded[: len(levels)] = levels
    return starts + padded.reshape(-1, width).argmax(axis=1)
