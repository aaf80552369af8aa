"""``mcsim.calibrate``: the six-position test of an accelerometer, measured or simulated."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.api.found import Found
from mcsim.calibration import SixPositionFit, SixPositions, read_six_positions
from mcsim.calibration import calibrate as fit_of
from mcsim.calibration.simulated import is_scenario, simulated_test, velocity_scenario
from mcsim.calibration.tables import parameter_table, residual_table, scenario_block
from mcsim.calibration.words import calibration_words
from mcsim.errors import InputError, UnitError
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.units import KINDS, parse

if TYPE_CHECKING:
    import pandas as pd

_LARGEST_ANGLE = 0.2


@dataclass(frozen=True)
class Calibration(Found):
    """Matrix and bias of an accelerometer.

    Attributes
    ----------
    fit : mcsim.calibration.SixPositionFit
        ``matrix`` (3, 3), ``bias`` (3,) in fractions of g, ``correction`` (3, 3), uncertainties.
    origin : mapping
        Where it comes from: the provenance of its files.
    """

    fit: SixPositionFit
    origin: Mapping[str, Any]

    @property
    def table(self) -> pd.DataFrame:
        """One row per element of matrix and bias; biases in g."""
        return parameter_table(self.fit)

    @property
    def residuals(self) -> pd.DataFrame:
        """Residuals of the equations (g) by repetition and position."""
        return residual_table(self.fit)

    @property
    def scenario(self) -> str:
        """The block ``calibration`` of a velocity scenario."""
        return scenario_block(self.fit)

    @property
    def words(self) -> str:
        """Where the uncertainties come from."""
        return calibration_words(self.fit)

    def report(self) -> Report:
        """Files ``calibration.csv``, ``residuals.csv`` and ``calibration.yaml``."""
        return Report(
            provenance=self.origin,
            tables={"calibration": self.table, "residuals": self.residuals},
            texts={"calibration.yaml": self.scenario},
        )


def calibrate(
    file: str | Path,
    *,
    samples: int = 1000,
    repetitions: int = 2,
    alignment: str = "0.1 °",
    seed: int = 1,
    tell: Callable[[str], None] | None = None,
) -> Calibration:
    """Calibrate an accelerometer by a six-position test.

    Parameters
    ----------
    file : path
        A CSV with the columns position (+x, -x … -z), x, y, z (g, or the unit in brackets) and
        perhaps repetition; or a velocity scenario (YAML), the test of whose sensor is simulated.
    samples, repetitions : int
        Simulation: samples per position, and how often the test is made.
    alignment : str
        Simulation: standard deviation of each position's angles, with its unit.
    seed : int
        Of the simulation.
    tell : callable, optional
        Hears what was noticed about a CSV.

    Returns
    -------
    Calibration
        ``fit`` with ``matrix`` (3, 3) and ``bias`` (3,) in fractions of g, the tables ``table``
        and ``residuals``, the scenario's block as text, and ``write(folder)``.

    Raises
    ------
    InputError
        A file that cannot be read or is no such test, or an angle that is none.
    """
    path, simulated = Path(file), is_scenario(Path(file))
    test: SixPositions
    options: dict[str, Any] = {}
    if simulated:
        test = simulated_test(
            velocity_scenario(path), samples, repetitions, _angle(alignment), seed
        )
        options = {"samples": samples, "repetitions": repetitions, "alignment": alignment}
    else:
        test = read_six_positions(path, tell)
    origin = provenance_of("calibrate", [path], options, seed if simulated else None)
    return Calibration(fit_of(test), origin)


def _angle(text: str) -> float:
    try:
        value = parse(text, KINDS["angle"])
    except UnitError as error:
        raise InputError(f"--alignment: {error}") from None
    if not 0.0 <= value < _LARGEST_ANGLE:
        raise InputError(f'--alignment: "{text}" must lie between 0 ° and 11 °')
    return value
