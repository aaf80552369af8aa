"""Memory that a scenario asks for, judged before anything is allocated."""

from __future__ import annotations

from mcsim.errors import InputError
from mcsim.scenario_file import Point, Scenario
from mcsim.statistics import KEPT, MOMENTS

#: What one point may ask for (bytes).
MOST_BYTES = 2 << 30
#: Realizations that histories are estimated from, at most and at least; long drives have
#: smaller ensembles, so that they fit in memory (samples x realizations).
HISTORY_REALIZATIONS = 4000
_MOST_HISTORY_STATES, _FEWEST_HISTORY_REALIZATIONS = 3_000_000, 200
_FLOAT = 8
#: Arrays alive at once: of resampled statistics, of kept realizations, of states over time.
_RESAMPLED, _KEPT_COPIES, _HISTORY_COPIES = 6, 4, 3


def check_memory(scenario: Scenario, counts: list[int]) -> None:
    """Refuse points that ask for more memory than ``MOST_BYTES``, naming the key to change.

    ``counts`` are the points' samples per realization.

    Raises
    ------
    InputError
        See above.
    """
    for point, count in zip(scenario.points, counts, strict=True):
        for key, size, instead in _demands(point, count):
            if size > MOST_BYTES:
                where = scenario.document.place(tuple(key.split(".")))
                raise InputError(
                    f"{where}: {key}: takes {size / 2**30:.1f} GiB of memory, more than the "
                    f"{MOST_BYTES / 2**30:g} GiB that a point may; {instead}"
                )


def history_realizations(available: int | None, samples: int) -> int:
    """How many of the available realizations (None: any) of so many samples histories show."""
    return min(
        available or HISTORY_REALIZATIONS,
        HISTORY_REALIZATIONS,
        max(_FEWEST_HISTORY_REALIZATIONS, _MOST_HISTORY_STATES // samples),
    )


def _demands(point: Point, count: int) -> list[tuple[str, int, str]]:
    """Keys, what they ask for (bytes), and what to do instead."""
    model = point.model
    settings, rows = model.monte_carlo, len(model.error_rows)
    largest = settings.realizations or settings.most_realizations
    instants = ", or ask for fewer `instants`" if rows > len(model.ERRORS) else ""
    over_time = 2 * len(model.ERRORS)  # states, and as many errors
    histories = 0
    if model.outputs.history:
        histories = history_realizations(settings.realizations, count + 1) * (count + 1)
    tracks = model.outputs.tracks * (count + 1)
    return [
        (
            "monte_carlo.resamples",
            settings.resamples * rows * len(MOMENTS) * _FLOAT * _RESAMPLED,
            f"use fewer resamples{instants}",
        ),
        (
            "monte_carlo.realizations" if settings.realizations else "monte_carlo.max_realizations",
            min(largest, KEPT) * rows * _FLOAT * _KEPT_COPIES,
            f"use fewer realizations{instants}",
        ),
        (
            "outputs.history",
            histories * over_time * _FLOAT * _HISTORY_COPIES,
            "shorten the drive, lower the rate of the sensors, or leave it out",
        ),
        (
            "outputs.tracks",
            tracks * over_time * _FLOAT * _HISTORY_COPIES,
            "keep fewer tracks, shorten the drive, or lower the rate of the sensors",
        ),
    ]
