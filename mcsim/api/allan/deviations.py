"""``mcsim.allan.deviations``: the deviations of the Allan family of a static log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from mcsim.api.characterise import LogOptions
from mcsim.api.found import Found
from mcsim.characterisation.allan import averaging_factors
from mcsim.characterisation.deviations import (
    DEVIATIONS,
    WELCH,
    DeviationCurve,
    deviation_curve,
    interval_of,
)
from mcsim.characterisation.sensor_file import SAMPLE
from mcsim.errors import InputError
from mcsim.logs import Log, ReadOptions, read_log
from mcsim.logs.model import Channel
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.text_table import columns
from mcsim.units import KINDS, in_unit, parse_confidence

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: All that there are, and those that are computed where nothing is said.
KINDS_OF_DEVIATION = (*DEVIATIONS, WELCH)
USUAL = ("oadev", "mdev", "hdev", "totdev")
#: Units of tables, by element.
_UNITS = {"accelerometer": "m/s^2", "gyroscope": "rad/s"}
#: Rows per channel on a terminal.
_ROWS = 10
_WORDS = {
    "adev": "Allan deviation of clusters that begin where the last one ended",
    "oadev": "Allan deviation of clusters that begin at every sample",
    "mdev": "modified: the phase averaged over the cluster, which tells quantisation (slope −3/2) "
    "from white noise (−1/2, √½ of oadev)",
    "hdev": "Hadamard: third differences, which a ramp does not show in",
    "totdev": "total: the log continued by reflection, for longer clusters; at half the log 13 % "
    "too small for flicker, 21 % for a random walk",
    WELCH: "Allan deviation by Eq. (3.12) of Welch's density",
}


@dataclass(frozen=True)
class ChannelDeviations:
    """A channel: curves in SI units, with the ends (k,) of their intervals."""

    channel: Channel
    curves: tuple[DeviationCurve, ...]
    intervals: tuple[tuple[Array, Array], ...]


@dataclass(frozen=True)
class AllanDeviations(Found):
    """Deviations of a log.

    Attributes
    ----------
    log : Log
    channels : tuple of ChannelDeviations
        In the order accelerometer, gyroscope, x, y, z.
    confidence : str
        Of the intervals.
    origin : mapping
        Where it comes from.
    """

    log: Log
    channels: tuple[ChannelDeviations, ...]
    confidence: str
    origin: Mapping[str, Any]

    @property
    def table(self) -> pd.DataFrame:
        """Columns channel, kind, tau_s, deviation, ci_low, ci_high, and the unit of these three."""
        import pandas as pd

        return pd.concat(
            pd.DataFrame(
                {
                    "channel": found.channel.name,
                    "kind": curve.kind,
                    "tau_s": np.round(curve.tau, 9),
                    "deviation": curve.deviation,
                    "ci_low": low,
                    "ci_high": high,
                    "unit": _UNITS[found.channel.element],
                }
            )
            for found in self.channels
            for curve, (low, high) in zip(found.curves, found.intervals, strict=True)
        )

    @property
    def text(self) -> str:
        """Deviations at some cluster times, and what they are."""
        lines = []
        for found in self.channels:
            kind, unit = SAMPLE[found.channel.element]
            one = in_unit(1.0, unit, KINDS[kind])
            head = [f"{found.channel.name} [{unit}]", *(c.kind for c in found.curves)]
            rows = [["τ [s]", *head[1:]]]
            longest = max(found.curves, key=lambda c: len(c.factors)).tau
            spots = np.unique(np.linspace(0, len(longest) - 1, _ROWS).round().astype(int))
            rows += [
                [f"{longest[k]:.4g}", *(_cell(c, k, one) for c in found.curves)] for k in spots
            ]
            lines += [head[0], *columns(rows), ""]
        kinds = [curve.kind for curve in self.channels[0].curves]
        lines += [f"{kind}: {_WORDS[kind]}." for kind in kinds]
        lines.append(
            f"Intervals of {self.confidence}: χ² with the degrees of freedom of the power law that "
            "the curve's slope shows (Greenhall and Riley 2003)."
        )
        return "\n".join(lines)

    def report(self) -> Report:
        """Files ``deviations`` (table and picture)."""
        from mcsim.figures.allan_deviations import Line, Panel, draw_deviations
        from mcsim.figures.style import printed

        panels = []
        for found in self.channels:
            kind, unit = SAMPLE[found.channel.element]
            lines = [
                Line(curve.kind, curve.tau, curve.deviation, low, high)
                for curve, (low, high) in zip(found.curves, found.intervals, strict=True)
            ]
            panels.append(Panel(found.channel.name, unit, in_unit(1.0, unit, KINDS[kind]), lines))
        words = {name: f"{kind.words} deviation" for name, kind in DEVIATIONS.items()}
        words[WELCH] = "Allan deviation of Welch's density"
        title = (
            f"{self.log.path.name} – {self.log.duration / 3600.0:.3g} h at "
            f"{self.log.rate:.4g} Hz, intervals of {self.confidence}"
        )
        return Report(
            provenance=self.origin,
            tables={"deviations": self.table},
            pictures=printed(draw_deviations(panels, words, title), "deviations"),
            nine_digits=("deviations",),
        )


def _cell(curve: DeviationCurve, k: int, one: float) -> str:
    return f"{curve.deviation[k] * one:.4g}" if k < len(curve.factors) else "–"


def deviations(
    log: str | Path,
    kinds: Sequence[str] = USUAL,
    *,
    read: LogOptions | None = None,
    confidence: str = "68.27 %",
) -> AllanDeviations:
    """Modified, Hadamard and total deviation of a static log, beside the Allan deviation.

    Parameters
    ----------
    log : path
        Of any format that ``mcsim.characterise`` reads.
    kinds : sequence of str
        ``adev``, ``oadev``, ``mdev``, ``hdev``, ``totdev``, and ``welch``: the Allan deviation by
        Eq. (3.12) of Welch's density.
    read : LogOptions, optional
        How the log is read.
    confidence : str
        Of the intervals: ``95 %``, ``1 sigma``.

    Returns
    -------
    AllanDeviations
        ``channels``, ``table`` (m/s², rad/s), ``text``, and ``write(folder)``.

    Raises
    ------
    InputError
        A log that cannot be read or is too short, or a deviation that there is not.
    """
    for kind in kinds:
        if kind not in KINDS_OF_DEVIATION:
            raise InputError(f'"{kind}" is none of {", ".join(KINDS_OF_DEVIATION)}')
    if not kinds:
        raise InputError(f"name a deviation: {', '.join(KINDS_OF_DEVIATION)}")
    probability = float(2.0 * ndtr(parse_confidence(confidence)) - 1.0)
    path = Path(log)
    found = read_log(path, ReadOptions(**(read or {})))
    channels = [
        _of_channel(channel, found.rate, tuple(dict.fromkeys(kinds)), probability)
        for channel in found.channels
    ]
    options = {"kinds": list(kinds), "confidence": confidence, **(read or {})}
    origin = provenance_of("allan deviations", [path], options)
    return AllanDeviations(found, tuple(channels), confidence, origin)


def _of_channel(
    channel: Channel, rate: float, kinds: Sequence[str], confidence: float
) -> ChannelDeviations:
    samples = channel.samples
    if not np.ptp(samples):
        raise InputError(f"{channel.name}: the output is constant")
    factors = averaging_factors(len(samples), rate)
    curves = tuple(deviation_curve(samples, rate, kind, factors) for kind in kinds)
    intervals = tuple(interval_of(curve, len(samples), confidence) for curve in curves)
    return ChannelDeviations(channel, curves, intervals)
