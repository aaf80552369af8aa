"""Time stamps as loggers make them, of samples that are truly equally spaced."""

from collections.abc import Callable

import numpy as np

#: Samples, and their times (s), which some loss has thinned; the interval (s); random numbers.
Stamper = Callable[[np.ndarray, float, np.random.Generator], np.ndarray]


def true_times(n, rate, loss, rng):
    """Number of each of n samples that arrive, where each is lost with probability ``loss``."""
    index = np.flatnonzero(rng.random(int(n * (1.0 + loss) + 8.0 * np.sqrt(n * loss) + 8)) >= loss)
    return (index[:n] - index[0]).astype(np.int64), 1.0 / rate


def jitter(part, sort=False):
    """Normal jitter, independent; ``sort``: a stamp is never earlier than the one before."""

    def stamp(index, step, rng):
        stamps = (index + part * rng.standard_normal(len(index))) * step
        return np.maximum.accumulate(stamps) if sort else stamps

    return stamp


def bursts(size, part=0.05):
    """So many samples are delivered together, microseconds apart, when the last is there."""

    def stamp(index, step, rng):
        n = len(index)
        last = np.minimum((np.arange(n) // size + 1) * size - 1, n - 1)
        wait = part * rng.random(n // size + 1)[np.arange(n) // size]
        return (index[last] + wait) * step + 1e-4 * step * (np.arange(n) % size)

    return stamp


def polled(size):
    """All that is there is fetched at intervals that are no multiple of the samples'."""
    return lambda index, step, _: np.ceil(index / (1.0371 * size)) * 1.0371 * size * step


def coarse(tick):
    """A clock that shows multiples of ``tick`` (s)."""
    return lambda index, step, _: np.floor((index * step + 1e-9) / tick) * tick


def stale(part, scatter=0.02):
    """Some stamps are those of the sample before."""

    def stamp(index, step, rng):
        stamps = (index + scatter * rng.standard_normal(len(index))) * step
        rows = np.flatnonzero(rng.random(len(index)) < part)
        rows = rows[rows > 0]
        stamps[rows] = stamps[rows - 1]
        return stamps

    return stamp


def stalls(count, rows, part=0.1):
    """The host stalls so often, and stamps so many samples when it goes on."""

    def stamp(index, step, rng):
        stamps = (index + part * rng.standard_normal(len(index))) * step
        for start in rng.integers(0, len(index) - rows, count):
            stamps[start : start + rows] = stamps[start : start + rows].max()
        return np.maximum.accumulate(stamps)

    return stamp


def stepped(by, part=0.1):
    """The clock is set back by so many intervals in the middle."""

    def stamp(index, step, rng):
        stamps = (index + part * rng.standard_normal(len(index))) * step
        stamps[len(index) // 2 :] -= by * step
        return stamps

    return stamp


def wrapped(period, part=0.1):
    """The clock begins anew after ``period`` (s)."""

    def stamp(index, step, rng):
        stamps = (index + part * rng.standard_normal(len(index))) * step
        return np.mod(stamps + 0.37 * period, period)

    return stamp


def drifting(part, per_million):
    """Jitter, and a clock whose rate wanders by so many parts per million."""

    def stamp(index, step, rng):
        n = index[-1] + 1
        slow = per_million * 1e-6 * n / (2 * np.pi) * np.sin(2 * np.pi * index / n)
        return (index + slow + part * rng.standard_normal(len(index))) * step

    return stamp


#: Name, sampling rate (Hz), and how stamps are made.
STAMPERS: dict[str, tuple[float, Stamper]] = {
    "jitter 5 %": (100.0, jitter(0.05)),
    "jitter 15 %": (100.0, jitter(0.15)),
    "jitter 30 %": (100.0, jitter(0.3)),
    "jitter 30 %, in order": (100.0, jitter(0.3, sort=True)),
    "jitter 45 %": (100.0, jitter(0.45)),
    "jitter 20 %, drift 100 ppm": (100.0, drifting(0.2, 100.0)),
    "bursts of 2": (100.0, bursts(2)),
    "bursts of 5": (100.0, bursts(5)),
    "bursts of 10": (100.0, bursts(10)),
    "polled, about 4 each": (200.0, polled(4)),
    "clock of 1 ms at 400 Hz": (400.0, coarse(1e-3)),
    "clock of 10 ms at 1 kHz": (1000.0, coarse(0.01)),
    "clock of 10 ms at 110 Hz": (110.0, coarse(0.01)),
    "clock of 15.6 ms at 100 Hz": (100.0, coarse(1 / 64)),
    "clock of 20 ms at 500 Hz": (500.0, coarse(0.02)),
    "stale 0.5 %": (100.0, stale(0.005)),
    "stale 10 %": (100.0, stale(0.1)),
    "5 stalls of 30 samples": (100.0, stalls(5, 30)),
    "set back by 1.4 intervals": (100.0, stepped(1.4)),
    "set back by 700 intervals": (100.0, stepped(700.3)),
    "begins anew after 2^16 µs": (1000.0, wrapped(0.065536)),
    "begins anew after a minute": (87.0, wrapped(60.0)),
}
