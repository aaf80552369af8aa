"""``mcsim.velocity``: recorded runs of an accelerometer to a velocity with its uncertainty."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from mcsim.api.found import Found
from mcsim.api.velocity_options import (
    KnownOptions,
    MonteCarloOptions,
    MotionOptions,
    ReadOptions,
    ReferenceOptions,
    inputs_of,
    layout_of,
    reference_of,
    rule_of,
)
from mcsim.errors import InputError
from mcsim.gum import Budget, Course
from mcsim.gum.tables import budget_table, comparison_table
from mcsim.measured_velocity.correction_file import read_correction
from mcsim.measured_velocity.group import Group, Run, group_of, run_of, time_base
from mcsim.measured_velocity.measurement import Measurement, course_of, measure, step_budget_of
from mcsim.measured_velocity.propagation import DRAWS, Inputs, tilts
from mcsim.measured_velocity.reference import Reference
from mcsim.measured_velocity.run_log import Layout, RecordedRuns, read_runs
from mcsim.measured_velocity.segments import segments
from mcsim.measured_velocity.tables import run_table, velocity_table
from mcsim.measured_velocity.words import measured_words
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.simulation.limits import SMALL_TILT
from mcsim.units import degrees

if TYPE_CHECKING:
    import pandas as pd

#: Draws of the Monte Carlo: fewer give no 95 %, more take memory and no digits.
_DRAWS = (200, 1_000_000)
#: A velocity of so many uncertainties is none of standstill.
_SURELY = 5.0
#: Numbers (draws × instants) that are kept, and (times runs) that are drawn, without being asked.
_MOST_KEPT, _MOST_DRAWN = 40_000_000, 300_000_000


@dataclass(frozen=True)
class MeasuredVelocity(Found):
    """The velocity of recorded runs, by propagation and by Monte Carlo.

    Attributes
    ----------
    name : str
    measurement : mcsim.measured_velocity.measurement.Measurement
        ``runs`` (M, n + 1) and ``mean`` (n + 1,) in m/s over ``group.time``, with ``sums`` by
        Eq. (30)–(33) and what Monte Carlo has ``drawn``.
    reference : Reference or None
        What it is compared with.
    notes : tuple of str
        How the files were read, and what was taken for granted.
    origin : mapping
        Where it comes from.
    """

    name: str
    measurement: Measurement
    reference: Reference | None
    notes: tuple[str, ...]
    origin: Mapping[str, Any]

    @cached_property
    def step(self) -> Budget:
        """The 26 rows of Tables 3 and 4, estimates averaged over the motion."""
        return step_budget_of(self.measurement)

    @cached_property
    def course(self) -> Course:
        """Standard uncertainties over time (m/s) by source, as those of ``mcsim.budget``."""
        return course_of(self.measurement)

    @property
    def table(self) -> pd.DataFrame:
        """Runs, mean, uncertainties and reference over time (m/s)."""
        return velocity_table(self.measurement, self.reference)

    @property
    def runs(self) -> pd.DataFrame:
        """One row per run: rest, tilt, length, velocity at the end."""
        return run_table(self.measurement)

    @property
    def budget(self) -> pd.DataFrame:
        """The 26 rows and the totals: columns ``mcsim.gum.tables.BUDGET_COLUMNS``."""
        return budget_table(self.step, self.course).drop(columns=["printed", "ratio"])

    @property
    def comparison(self) -> pd.DataFrame:
        """Columns ``time [s], method, of, source, uncertainty [m/s]``."""
        return comparison_table(self.course)

    @property
    def words(self) -> str:
        """What the numbers say."""
        return measured_words(self.measurement, self.course, self.step, self.reference)

    def report(self) -> Report:
        """Tables ``velocity``, ``runs``, ``budget``, ``comparison``, their pictures, and words."""
        from mcsim.figures.budget import draw_comparison, draw_shares
        from mcsim.figures.measured_velocity import draw_velocity
        from mcsim.figures.style import printed

        pictures = printed(draw_velocity(self.measurement, self.reference, self.name), "velocity")
        pictures |= printed(draw_comparison(self.course, self.name), "comparison")
        outputs: tuple[Literal["Dv", "acx"], ...] = ("Dv", "acx")
        for output in outputs:
            of = f"{self.name}: variance of {output}"
            shares = draw_shares([self.step], [self.name], output, of)
            pictures |= printed(shares, f"shares-{output.lower()}")
        return Report(
            provenance={**self.origin, "remarks": list(self.notes)},
            tables={
                "velocity": self.table,
                "runs": self.runs,
                "budget": self.budget,
                "comparison": self.comparison,
            },
            pictures=pictures,
            texts={"velocity.txt": self.words},
        )


def velocity(
    files: str | Path | Sequence[str | Path],
    calibration: str | Path,
    *,
    read: ReadOptions | None = None,
    motion: MotionOptions | None = None,
    known: KnownOptions | None = None,
    reference: ReferenceOptions | None = None,
    monte_carlo: MonteCarloOptions | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> MeasuredVelocity:
    """From raw runs of a tri-axial accelerometer to their velocity and its uncertainty.

    Parameters
    ----------
    files : path or several
        Logs with time stamps and the raw axes x (forward), y and z (upward), each with the rest
        before the motion: one run, runs that a column ``run`` tells apart, or as many as
        ``motion`` says, with rests between them.
    calibration : path
        What ``mcsim.calibrate`` writes, or a velocity scenario, whose gravity and tilt count too.
    read : ReadOptions, optional
        How logs are read: ``columns``, ``units``, ``run_column``.
    motion : MotionOptions, optional
        Where it begins and ends: ``rest``, ``duration``, ``still``, ``runs`` (how many
        the files hold), ``align``.
    known : KnownOptions, optional
        ``gravity`` and ``gravity_uncertainty``; ``tilt_change``, or ``unevenness`` and
        ``axle_distance``; ``nonlinearity``; ``interval_uncertainty``, ``time_errors``;
        ``tilt_order``.
    reference : ReferenceOptions, optional
        ``columns`` of the speed or the wheels, ``files``, ``wheel_radius``, ``ticks_per_turn``,
        ``uncertainty``.
    monte_carlo : MonteCarloOptions, optional
        ``draws`` and ``seed``.
    tell : callable
        Hears how files were read and what was taken for granted.

    Returns
    -------
    MeasuredVelocity
        ``table`` (velocities over time with uncertainties, m/s), ``runs``, ``budget``,
        ``comparison``, ``words`` and ``write(folder)``.

    Raises
    ------
    InputError
        A file that cannot be read, no rest, nothing that moves, or options that make no sense.
    """
    paths = [Path(files)] if isinstance(files, str | Path) else [Path(f) for f in files]
    notes: list[str] = []

    def note(text: str) -> None:
        if text not in notes:
            notes.append(text)
            tell(text)

    motion = motion or {}
    against = reference_of(reference or {})
    correction = read_correction(Path(calibration))
    others = [Path(f) for f in (reference or {}).get("files", ())]
    records, named = _recorded(paths, others, layout_of(read or {}, against), note)
    # A file is one run, unless a column tells several apart, or more are asked for.
    single = named or (motion.get("runs") or 0) <= len(paths)
    group = _group(records, single, motion, note)
    inputs = inputs_of(correction, known or {}, group.time_base, note)
    _doubt_small_angles(inputs, group, note)
    _check_rest(inputs.correction.row("z").value(group.rests), group)
    draws, seed = _checked_draws(monte_carlo or {}, group, note)
    given = {**(read or {}), **motion, **(known or {}), **(reference or {})}
    options = {key: value for key, value in given.items() if value and key != "files"}
    inputs_read = [*paths, Path(calibration), *others]
    origin = provenance_of("velocity", inputs_read, {**options, "draws": draws}, seed)
    measurement = measure(inputs, group, draws, seed)
    if not single:
        _doubt_standstill(measurement, note)
    return MeasuredVelocity(_name(paths), measurement, against, tuple(notes), origin)


def _name(paths: list[Path]) -> str:
    first = paths[0].name.split(".")[0]
    return first if len(paths) == 1 else f"{first} and {len(paths) - 1} more"


def _recorded(
    paths: list[Path], others: list[Path], layout: Layout, note: Callable[[str], None]
) -> tuple[list[RecordedRuns], bool]:
    """All records, and whether a column tells their runs apart."""
    if not paths:
        raise InputError("no file of a run is given")
    if others and len(others) != len(paths):
        raise InputError(
            f"--reference-file: {len(others)} for {len(paths)} files of runs; give one for each, "
            "in the same order and with stamps of the same clock"
        )
    records, labelled = [], False
    for n, path in enumerate(paths):
        own, named = read_runs(path, layout, others[n] if others else None, note)
        records += own
        labelled = labelled or named
    return records, labelled


def _group(
    records: list[RecordedRuns], single: bool, motion: MotionOptions, note: Callable[[str], None]
) -> Group:
    rule = rule_of(motion)
    expected = motion.get("runs")
    if rule.rest is not None and not single and expected not in (None, 1):
        raise InputError(
            "--rest: says where the one run of a file begins; give each run its file, or a column "
            "`run`, or leave --rest out and let rests be found"
        )
    runs: list[Run] = []
    for record in records:
        found, words = segments(record, rule, single)
        note(words)
        many = len(found) > 1
        for n, segment in enumerate(found, start=1):
            name = f"{record.name}, motion {n}" if many else record.name
            runs.append(run_of(record, segment, name))
    if expected is not None and len(runs) != expected:
        raise InputError(
            f"--runs {expected}: {len(runs)} found; a steady drive of more than {rule.still:g} s "
            "looks like a rest, and a shorter rest like a drive: set --still"
        )
    base = time_base([r.time for r in records], max(r.resolution for r in records))
    group = group_of(runs, base, motion.get("align", "auto"))
    for text in _said(group):
        note(text)
    return group


def _said(group: Group) -> list[str]:
    """How runs were put together."""
    notes = []
    if group.runs > 1:
        how = (
            "sample by sample, as none is lost and the rates agree"
            if group.alignment == "samples"
            else "at common instants, interpolated"
        )
        notes.append(f"{group.runs} runs, aligned at the start of motion and averaged {how}")
    if max(group.steps) > min(group.steps):
        notes.append(
            f"runs last {min(group.lengths):.4g} to {max(group.lengths):.4g} s, "
            f"{min(group.steps)} to {max(group.steps)} samples: statistics until the shortest ends"
        )
    if group.lost:
        notes.append(
            f"{group.lost} samples are missing while moving: the one before goes on over the gap"
        )
    return notes


def _doubt_standstill(measurement: Measurement, note: Callable[[str], None]) -> None:
    """A motion between rests that were found should end at standstill."""
    ends, u = measurement.runs[:, -1], measurement.drawn.single[:, -1]
    moving = np.flatnonzero(np.abs(ends) > _SURELY * u)
    if len(moving):
        first = int(moving[0])
        note(
            f"{len(moving)} of {len(ends)} motions do not end at standstill, the first of them "
            f"({measurement.group.names[first]}) at {ends[first]:.3g} m/s: is a steady drive taken "
            "for a rest? Raise --still, or give a column `run`"
        )


def _doubt_small_angles(inputs: Inputs, group: Group, note: Callable[[str], None]) -> None:
    """Eq. (15) is for small angles."""
    tilt = float(np.max(np.abs(tilts(inputs, group))))
    if inputs.order == 0 and tilt > SMALL_TILT:
        note(
            f"the sensor is tilted by up to {degrees(tilt):.3g}°, where Eq. (15), for small "
            f"angles, errs by {0.5 * tilt**2:.1%} of gravity's share, which no uncertainty here "
            "covers: give --tilt-order exact"
        )


def _check_rest(vertical: Any, group: Group) -> None:
    for name, value in zip(group.names, vertical, strict=True):
        if not 0.9 < value < 1.1:
            raise InputError(
                f"{name}: at rest the corrected z reads {value:.3g} g, where an upward axis reads "
                "about 1 g: is z upward, is this calibration that of the sensor, and are both in "
                "the same unit?"
            )


def _checked_draws(
    given: MonteCarloOptions, group: Group, note: Callable[[str], None]
) -> tuple[int, int]:
    """Draws and seed; of long runs fewer draws are made unless more are asked for."""
    steps = len(group.time)
    most = min(_MOST_KEPT // steps, _MOST_DRAWN // (steps * group.runs))
    draws, seed = given.get("draws"), given.get("seed", 1)
    if draws is None:
        draws = max(min(DRAWS, most), _DRAWS[0])
        if draws < DRAWS:
            note(f"{steps:,} instants of {group.runs} runs: {draws:,} draws by Monte Carlo")
    if not _DRAWS[0] <= draws <= _DRAWS[1]:
        raise InputError(f"--draws {draws}: must lie between {_DRAWS[0]} and {_DRAWS[1]:,}")
    if draws * steps > 2 * _MOST_KEPT:
        raise InputError(
            f"--draws {draws}: of {steps:,} instants are more than mcsim can hold; lower it, or "
            "give a shorter --duration"
        )
    return draws, seed
