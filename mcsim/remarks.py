"""Remarks on a point's errors: why a value is missing, degenerate or uncertain."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mcsim.estimation import FEWEST_CONTROLLED, SEEN, rare_events, unsmooth
from mcsim.scenario.run import MonteCarlo
from mcsim.simulation.problem import Limit, Problem
from mcsim.statistics import Estimates
from mcsim.statistics.collector import MOST_NETS, cell_size

#: Share of the variance from which on events that were hardly seen are remarked on.
_MATTERS = 0.1

#: Remarks by the error's label.
Notes = dict[str, str]


def add_note(notes: Notes, name: str, note: str) -> None:
    """One more note on an error."""
    notes[name] = f"{notes[name]}; {note}" if name in notes else note


def note_not_finite(problem: Problem, estimates: Estimates, notes: Notes) -> None:
    """Say why numbers are missing where nothing else does."""
    numbers = np.concatenate([estimates.value, estimates.low, estimates.high], axis=1)
    for name, row in zip(problem.error_names, numbers, strict=True):
        if not np.all(np.isfinite(row)):
            notes.setdefault(name, "beyond the range of numbers: the inputs are too large or small")


def note_degenerate(problem: Problem, estimates: Estimates, count: int, notes: Notes) -> None:
    linear = np.sum(list(problem.linear.variances.values()), axis=0)
    for i, (name, degenerate) in enumerate(
        zip(problem.error_names, estimates.degenerate, strict=True)
    ):
        if count == 1:
            add_note(notes, name, "one realization: no scatter and no interval follow from it")
        elif degenerate and linear[i] > 0.0:
            add_note(
                notes, name, "all realizations are equal: what disturbs this error does not show"
            )
        elif degenerate:
            add_note(notes, name, "all realizations are equal: nothing disturbs this error")


def without_effect(
    problem: Problem, settings: MonteCarlo, count: int, limits: Sequence[Limit]
) -> Iterator[Limit]:
    """What is written and does nothing here."""
    written = settings.model_fields_set
    controlled = "estimator" in written and settings.estimator == "control_variate"
    if controlled and count < FEWEST_CONTROLLED:
        yield Limit(
            f"estimator: control variates take {FEWEST_CONTROLLED} realizations; the plain "
            "estimator served"
        )
    if settings.offsets != "sobol":
        return
    if unsmooth(problem, limits):
        yield Limit(
            "offsets: Sobol points serve errors that are smooth, and here an angle may wrap or a "
            "limit may be reached; these are random"
        )
    elif cell_size(count, nets=True) == 1:
        yield Limit(
            f"offsets: Sobol points take more than {MOST_NETS} realizations; these are random"
        )


def note_uncertain(
    problem: Problem, settings: MonteCarlo, estimates: Estimates, count: int, notes: Notes
) -> None:
    """What the intervals rest on where the realizations alone do not tell."""
    rare = rare_events(problem)
    share = seen = np.zeros(len(problem.error_names))
    if rare is not None:
        whole = np.maximum(np.sum(list(problem.linear.variances.values()), axis=0), 1e-300)
        share, seen = problem.linear.spike_variance() / whole, rare.events * count
    controlled = settings.estimator == "control_variate" and count >= FEWEST_CONTROLLED
    scatter = "what the linear model leaves" if controlled else "the scatter"
    for i, name in enumerate(problem.error_names):
        if count > 1 and share[i] > _MATTERS and seen[i] < SEEN:
            add_note(
                notes,
                name,
                f"spikes make {share[i]:.0%} of the variance by the linear model, and only "
                f"{seen[i]:.2g} are expected among {count:,} realizations: the intervals allow "
                "for those not seen",
            )
        elif estimates.few is not None and estimates.few[i]:
            add_note(
                notes,
                name,
                f"few realizations carry most of {scatter}: the intervals are widened for it",
            )
        if count > 1 and estimates.unbounded and not estimates.degenerate[i]:
            add_note(
                notes,
                name,
                f"{count} realizations do not bound {', '.join(estimates.unbounded)} at "
                f"{settings.confidence:.3g} sigma: the interval ends at an extreme realization",
            )
