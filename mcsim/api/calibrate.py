"""``mcsim.calibrate``: an accelerometer from its positions at rest, measured or simulated."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from mcsim.api.found import Found
from mcsim.calibration import (
    NormFit,
    RestPositions,
    SixPositionFit,
    SixPositions,
    calibrate_by_norm,
    calibrate_weighted,
    find_rests,
    read_positions,
    read_six_positions,
)
from mcsim.calibration import calibrate as fit_of
from mcsim.calibration.norm_words import norm_residual_table, norm_words
from mcsim.calibration.simulated import (
    is_scenario,
    simulated_positions,
    simulated_test,
    velocity_scenario,
)
from mcsim.calibration.tables import parameter_table, residual_table, scenario_block
from mcsim.calibration.words import calibration_words
from mcsim.errors import InputError, UnitError
from mcsim.logs import ReadOptions
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.units import KINDS, parse

if TYPE_CHECKING:
    import pandas as pd

_LARGEST_ANGLE = 0.2
#: How the positions are given: the six by their names, any, or as the rests of one log.
Positions = Literal["six", "arbitrary", "rests"]


@dataclass(frozen=True)
class Calibration(Found):
    """Matrix and bias of an accelerometer.

    Attributes
    ----------
    fit : mcsim.calibration.SixPositionFit or mcsim.calibration.NormFit
        ``matrix`` (3, 3), ``bias`` (3,) in fractions of g, ``correction`` (3, 3), uncertainties.
    origin : mapping
        Where it comes from: the provenance of its files.
    """

    fit: SixPositionFit | NormFit
    origin: Mapping[str, Any]

    @property
    def table(self) -> pd.DataFrame:
        """One row per element of matrix and bias; biases in g."""
        return parameter_table(self.fit)

    @property
    def residuals(self) -> pd.DataFrame:
        """Residuals of the equations (g) by repetition and position; norms less one."""
        if isinstance(self.fit, NormFit):
            return norm_residual_table(self.fit)
        return residual_table(self.fit)

    @property
    def scenario(self) -> str:
        """The block ``calibration`` of a velocity scenario."""
        return scenario_block(self.fit)

    @property
    def words(self) -> str:
        """Where the uncertainties come from."""
        if isinstance(self.fit, NormFit):
            return norm_words(self.fit)
        return calibration_words(self.fit)

    def report(self) -> Report:
        """Files ``calibration.csv``, ``residuals.csv`` and ``calibration.yaml``."""
        return Report(
            provenance=self.origin,
            tables={"calibration": self.table, "residuals": self.residuals},
            texts={"calibration.yaml": self.scenario},
        )


@dataclass(frozen=True)
class SimulatedTest:
    """How the test of a velocity scenario's sensor is simulated.

    ``samples`` per position; of six positions how often the test is made, and the deviation of
    each position's angles; of arbitrary ones how many there are.
    """

    samples: int = 1000
    repetitions: int = 2
    alignment: str = "0.1 °"
    count: int = 24
    seed: int = 1


def calibrate(
    file: str | Path,
    *,
    positions: Positions = "six",
    weighted: bool = False,
    rate: float | None = None,
    shortest_rest: float = 2.0,
    tell: Callable[[str], None] | None = None,
    **simulation: Any,
) -> Calibration:
    """Calibrate an accelerometer by six positions, or by arbitrary ones at rest.

    Parameters
    ----------
    file : path
        A CSV with the columns x, y, z (g, or the unit in brackets) and position (+x, -x … -z;
        any names where positions are arbitrary), perhaps repetition; a log in which the sensor
        rests in many positions; or a velocity scenario (YAML), the test of whose sensor is
        simulated.
    positions : "six", "arbitrary" or "rests"
        The six along the axes; any ten or more, by the norm of gravity; those in one log.
    weighted : bool
        Of six: each position's mean weighted by its own uncertainty.
    rate, shortest_rest : float
        Of a log: Hz where it has no time; the shortest rest that counts (s).
    tell : callable, optional
        Hears what was noticed about a file.
    **simulation
        How a scenario's test is simulated: ``samples``, ``repetitions``, ``alignment``, ``count``,
        ``seed`` of ``SimulatedTest``.

    Returns
    -------
    Calibration
        ``fit`` with ``matrix`` (3, 3) and ``bias`` (3,) in fractions of g, the tables ``table``
        and ``residuals``, the scenario's block as text, and ``write(folder)``.

    Raises
    ------
    InputError
        A file that cannot be read or is no such test, positions that cover too little, weights
        that nothing tells, or an angle that is none.
    """
    path, test = Path(file), SimulatedTest(**simulation)
    if weighted and positions != "six":
        raise InputError("--weighted: belongs to six positions; others are always weighted")
    is_simulated = is_scenario(path)
    options: dict[str, Any] = {"positions": positions} if positions != "six" else {}
    if is_simulated:
        options |= _told(test, positions)
    if weighted:
        options["weighted"] = True
    fit: SixPositionFit | NormFit
    if positions == "six":
        six = _six(path, test) if is_simulated else read_six_positions(path, tell)
        fit = calibrate_weighted(six) if weighted else fit_of(six)
    else:
        if positions == "rests":
            options |= {"rate": rate, "shortest_rest": shortest_rest}
        fit = _by_norm(path, positions, test, ReadOptions(rate=rate), shortest_rest, tell)
    origin = provenance_of("calibrate", [path], options, test.seed if is_simulated else None)
    return Calibration(fit, origin)


def _told(test: SimulatedTest, positions: Positions) -> dict[str, Any]:
    if positions == "six":
        return {
            "samples": test.samples,
            "repetitions": test.repetitions,
            "alignment": test.alignment,
        }
    return {"samples": test.samples, "count": test.count}


def _six(path: Path, test: SimulatedTest) -> SixPositions:
    return simulated_test(
        velocity_scenario(path), test.samples, test.repetitions, _angle(test.alignment), test.seed
    )


def _by_norm(
    path: Path,
    positions: Positions,
    test: SimulatedTest,
    options: ReadOptions,
    shortest_rest: float,
    tell: Callable[[str], None] | None,
) -> NormFit:
    found: RestPositions
    if is_scenario(path):
        found = simulated_positions(velocity_scenario(path), test.count, test.samples, test.seed)
    elif positions == "rests":
        found = find_rests(path, shortest_rest, options, tell)
    else:
        found = read_positions(path, tell)
    try:
        return calibrate_by_norm(found)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _angle(text: str) -> float:
    try:
        value = parse(text, KINDS["angle"])
    except UnitError as error:
        raise InputError(f"--alignment: {error}") from None
    if not 0.0 <= value < _LARGEST_ANGLE:
        raise InputError(f'--alignment: "{text}" must lie between 0 ° and 11 °')
    return value
