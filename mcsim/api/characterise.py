"""``mcsim.characterise``: from a static log to a sensor's parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from scipy.special import ndtr

from mcsim.api.found import Found
from mcsim.characterisation.analysis import Characterisation, Settings
from mcsim.characterisation.analysis import characterise as analyse
from mcsim.characterisation.bootstrap import largest_confidence
from mcsim.characterisation.fit import Intervals
from mcsim.characterisation.noise_view import (
    ChannelView,
    autocorrelation_table,
    course_table,
    histogram_table,
    normality_table,
    normality_words,
    views,
)
from mcsim.characterisation.sensor_file import sensor_file
from mcsim.characterisation.tables import allan_table, psd_table
from mcsim.characterisation.verdict import verdict
from mcsim.errors import InputError
from mcsim.logs import ReadOptions, read_log
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.units import parse_confidence

if TYPE_CHECKING:
    import pandas as pd


class LogOptions(TypedDict, total=False):
    """How a log is read; see ``mcsim.logs.ReadOptions``."""

    rate: float | None
    columns: str | None
    units: str | None
    topic: str | None
    start: float | None
    end: float | None


@dataclass(frozen=True)
class SensorCharacterisation(Found):
    """A sensor's parameters from a static log.

    Attributes
    ----------
    analysis : mcsim.characterisation.Characterisation
        Channel by channel: Allan curve, spectrum, fitted noise, bias; SI units.
    origin : mapping
        Where it comes from: the provenance of its files.
    """

    analysis: Characterisation
    origin: Mapping[str, Any]

    @property
    def allan(self) -> pd.DataFrame:
        """Columns channel, tau_s, adev, ci_low, ci_high; m/s² and rad/s."""
        return allan_table(self.analysis)

    @property
    def psd(self) -> pd.DataFrame:
        """Columns channel, frequency_hz, psd_one_sided, floor_one_sided; SI unit squared per Hz."""
        return psd_table(self.analysis)

    @property
    def sensor(self) -> str:
        """The sensor file (YAML) that scenarios take."""
        return sensor_file(self.analysis)

    @property
    def verdict(self) -> list[str]:
        """What the numbers say, sentence by sentence."""
        return [*verdict(self.analysis), *normality_words(self.views)]

    @cached_property
    def views(self) -> tuple[ChannelView, ...]:
        """Channel by channel: distribution of the noise, autocorrelation, course of the bias."""
        return views(self.analysis)

    def report(self) -> Report:
        """Files ``sensor.yaml``, ``allan``, ``psd``, ``histogram``, ``bias`` and their kin."""
        from mcsim.figures import noise
        from mcsim.figures.allan import draw_allan, draw_psd
        from mcsim.figures.style import printed

        drawn = {
            "allan": draw_allan(self.analysis),
            "psd": draw_psd(self.analysis),
            "histogram": noise.draw_histogram(self.analysis, self.views),
            "autocorrelation": noise.draw_autocorrelation(self.analysis, self.views),
            "bias": noise.draw_bias(self.analysis, self.views),
        }
        return Report(
            provenance=self.origin,
            tables={
                "allan": self.allan,
                "psd": self.psd,
                "histogram": histogram_table(self.views),
                "normality": normality_table(self.views),
                "autocorrelation": autocorrelation_table(self.views),
                "bias": course_table(self.views),
            },
            pictures={
                file: write
                for name, figure in drawn.items()
                for file, write in printed(figure, name).items()
            },
            texts={"sensor.yaml": self.sensor},
            nine_digits=("psd", "histogram", "normality", "autocorrelation", "bias"),
        )


def characterise(
    log: str | Path,
    *,
    read: LogOptions | None = None,
    fit_range: tuple[float, float] | None = None,
    overlapping: bool = True,
    confidence: str = "95 %",
    intervals: Intervals = "bootstrap",
    tell: Callable[[str], None] = lambda _: None,
) -> SensorCharacterisation:
    """Characterise a sensor from a static log.

    Parameters
    ----------
    log : path
        A CSV file (plain or packed), a folder of EuRoC, TUM-VI or gnss-ins-sim, a ROS bag or
        MCAP file (extra ``mcsim[bags]``).
    read : LogOptions, optional
        How it is read: ``rate`` (Hz), ``columns``, ``units``, ``topic``, ``start``, ``end`` (s).
    fit_range : (float, float), optional
        Cluster times of the fit (s); all that follow the model if absent.
    overlapping : bool
        Which Allan deviations are reported.
    confidence : str
        Of all intervals: ``95 %``, ``3 sigma``.
    intervals : "bootstrap" or "covariance"
        Of N, B and K: from blocks of the log, or from the noise that was fitted.
    tell : callable
        Hears what is being done.

    Returns
    -------
    SensorCharacterisation
        ``sensor`` (the text of a sensor file), the tables ``allan`` and ``psd`` (m/s² and rad/s),
        ``verdict`` in sentences, and ``write(folder)``.

    Raises
    ------
    InputError
        A log that cannot be read, is too short, moves or holds a constant channel; nothing in the
        range of the fit; a confidence that a bootstrap does not reach.
    """
    settings = _settings(fit_range, overlapping, confidence, intervals)
    path = Path(log)
    tell(f"reading {log}")
    found = analyse(read_log(path, ReadOptions(**(read or {}))), settings, tell)
    options = {"fit_range": fit_range, "estimator": settings.estimator, "confidence": confidence}
    told = {**options, "intervals": intervals, **(read or {})}
    return SensorCharacterisation(found, provenance_of("characterise", [path], told))


def _settings(
    fit_range: tuple[float, float] | None, overlapping: bool, confidence: str, intervals: Intervals
) -> Settings:
    if fit_range is not None and not 0.0 < fit_range[0] < fit_range[1]:
        raise InputError(
            f"--fit-range {fit_range[0]:g} {fit_range[1]:g}: two ascending times in s are needed"
        )
    probability = float(2.0 * ndtr(parse_confidence(confidence)) - 1.0)
    if intervals == "bootstrap" and probability > largest_confidence():
        raise InputError(
            f"--confidence {confidence}: a bootstrap knows intervals of up to "
            f"{100 * largest_confidence():g} %; give --intervals covariance"
        )
    return Settings(
        estimator="overlapping" if overlapping else "non-overlapping",
        fit_range=fit_range,
        confidence=probability,
        intervals=intervals,
    )
