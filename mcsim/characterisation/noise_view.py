"""What a characterised channel looks like beyond its Allan curve: Figures 5.3 to 5.5."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mcsim.characterisation.analysis import ChannelResult, Characterisation
from mcsim.characterisation.autocorrelation import Autocorrelation, autocorrelation_of
from mcsim.characterisation.bias import SMOOTHING, smooth
from mcsim.characterisation.course import BiasCourse, bias_course
from mcsim.characterisation.normality import (
    LEVEL_OF_TEST,
    Histogram,
    Normality,
    fast_part,
    histogram,
    is_coarse,
    normality,
)

if TYPE_CHECKING:
    import pandas as pd

#: The longest lag, as a part of the log.
_LONGEST_LAG = 0.25
_AVERAGES = 100.0


@dataclass(frozen=True)
class ChannelView:
    """Distribution, correlation and bias of one axis, without what the fit leaves out.

    ``normality`` is None where steps are too coarse for a test; ``of_samples`` has lags up to the
    length of the bias's moving average, ``of_bias`` those beyond it.
    """

    result: ChannelResult
    histogram: Histogram
    normality: Normality | None
    of_samples: Autocorrelation
    of_bias: Autocorrelation
    course: BiasCourse


def views(found: Characterisation) -> tuple[ChannelView, ...]:
    """Of all channels, in their order."""
    return tuple(view(result, found.log.rate) for result in found.channels)


def view(result: ChannelResult, rate: float) -> ChannelView:
    """Of one channel at ``rate`` Hz."""
    seen, white = result.inspection, result.fit["N"].value
    samples, step = seen.samples, seen.resolution
    length = min(SMOOTHING, len(samples) / rate / _AVERAGES)
    noise = fast_part(samples, rate)
    average = smooth(samples, rate, length)
    model = result.bias.model if result.bias is not None else None
    longest = int(_LONGEST_LAG * len(average.values))
    within = round(average.length / average.interval)
    return ChannelView(
        result=result,
        histogram=histogram(noise, step),
        normality=None if is_coarse(noise, step) else normality(noise, step),
        of_samples=autocorrelation_of(samples, 1.0 / rate, 1, max(2, round(length * rate))),
        of_bias=autocorrelation_of(average.values, average.interval, within, longest),
        course=bias_course(samples, rate, white, length, model),
    )


def normality_words(found: tuple[ChannelView, ...]) -> list[str]:
    """What the test says, in a sentence or two."""
    return list(_words(found))


def _words(found: tuple[ChannelView, ...]) -> Iterator[str]:
    tests = {v.result.channel.name: v.normality for v in found}
    coarse = [name for name, test in tests.items() if test is None]
    known = {name: test for name, test in tests.items() if test is not None}
    normal = [name for name, test in known.items() if test.is_normal]
    if normal:
        least = min(known[name].p for name in normal)
        names = "all channels" if len(normal) == len(tests) > 1 else ", ".join(normal)
        yield f"Noise of {names}: nothing speaks against a normal distribution (p ≥ {least:.2g})."
    for name, test in known.items():
        if not test.is_normal:
            yield (
                f"Noise of {name} is not normal (p {probability(test.p)}): skewness "
                f"{test.skewness:.2g} ± {1.96 * test.u_skewness:.1g}, excess kurtosis "
                f"{test.excess:.2g} ± {1.96 * test.u_excess:.1g}"
                + ("; a histogram hardly shows it." if test.is_slight else ".")
            )
    if coarse:
        yield f"Steps of {', '.join(coarse)} are too coarse for a test of the noise's distribution."
    if known:
        yield (
            "The test is K² of skewness and kurtosis, at the level "
            f"{LEVEL_OF_TEST:g}, without the slow part; the samples' correlation and their "
            "rounding are allowed for."
        )


def probability(p: float) -> str:
    """``= 0.03``, or what it is below."""
    return f"= {p:.2g}" if p >= 1e-9 else "< 1e-9"


def histogram_table(found: tuple[ChannelView, ...]) -> pd.DataFrame:
    """Columns channel, from, to, count, normal: bins in m/s² and rad/s, and expected counts."""
    import pandas as pd

    return pd.concat(
        pd.DataFrame(
            {
                "channel": v.result.channel.name,
                "from": v.histogram.edges[:-1],
                "to": v.histogram.edges[1:],
                "count": v.histogram.counts,
                "normal": v.histogram.expected,
            }
        )
        for v in found
    )


def normality_table(found: tuple[ChannelView, ...]) -> pd.DataFrame:
    """A row per channel: moments, what chance makes of them (one deviation), K² and p."""
    import pandas as pd

    rows = [(v.result.channel.name, *_numbers(v.normality)) for v in found]
    heads = ["samples", "skewness", "u_skewness", "excess_kurtosis", "u_excess_kurtosis"]
    table = pd.DataFrame(rows, columns=["channel", *heads, "k_squared", "p"])
    return table.astype({"samples": "Int64"})


def _numbers(test: Normality | None) -> tuple[float | None, ...]:
    if test is None:
        return (None,) * 7
    moments = (test.skewness, test.u_skewness, test.excess, test.u_excess)
    return (test.samples, *moments, test.statistic, test.p)


def autocorrelation_table(found: tuple[ChannelView, ...]) -> pd.DataFrame:
    """Columns channel, of (samples, bias), lag_s, autocorrelation, band (95 % of none)."""
    import pandas as pd

    return pd.concat(
        pd.DataFrame(
            {
                "channel": v.result.channel.name,
                "of": name,
                "lag_s": a.lags,
                "autocorrelation": a.values,
                "band": a.band,
            }
        )
        for v in found
        for name, a in (("samples", v.of_samples), ("bias", v.of_bias))
    )


def course_table(found: tuple[ChannelView, ...]) -> pd.DataFrame:
    """Columns channel, time_s, measured, measured_band, tracked, tracked_band; m/s² and rad/s."""
    import pandas as pd

    return pd.concat(
        pd.DataFrame(
            {
                "channel": v.result.channel.name,
                "time_s": c.time,
                "measured": c.measured,
                "measured_band": c.measured_band,
                "tracked": float("nan") if c.tracked is None else c.tracked,
                "tracked_band": float("nan") if c.tracked_band is None else c.tracked_band,
            }
        )
        for v in found
        for c in (v.course,)
    )
