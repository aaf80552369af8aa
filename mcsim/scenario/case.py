"""What the scenarios of all cases have in common."""

from __future__ import annotations

from typing import ClassVar

from mcsim.scenario.block import Block
from mcsim.scenario.error_quantities import ErrorRow
from mcsim.scenario.figure import Figure, Panel
from mcsim.scenario.run import MonteCarlo, Outputs
from mcsim.statistics import PERCENTILES, Statistic, estimated


class CaseScenario(Block):
    """A scenario of some case; each case adds the system that it simulates.

    A case says its ``ERRORS`` in the order of every table, which of them are ``DRAWN`` in a panel
    of their own, and perhaps its ``PERCENTILES``; it narrows ``case`` to its own name and adds its
    blocks.  Quantities are written with units and are SI floats in the model.
    """

    #: Errors that the case reports, in the order of every table.
    ERRORS: ClassVar[tuple[str, ...]]
    #: Errors that have a panel of their own where the figure block names none.
    DRAWN: ClassVar[tuple[str, ...]]
    #: Percentiles of every error that tables hold.
    PERCENTILES: ClassVar[tuple[float, ...]] = PERCENTILES

    case: str
    title: str | None = None
    """One line for people."""
    monte_carlo: MonteCarlo
    outputs: Outputs = Outputs()
    figure: Figure = Figure()

    @classmethod
    def statistics(cls) -> dict[str, Statistic]:
        """The statistics of every error by name, in the order of every table."""
        return estimated(cls.PERCENTILES)

    @property
    def error_rows(self) -> tuple[ErrorRow, ...]:
        """The errors that every point reports, in order."""
        return tuple(ErrorRow(name) for name in self.ERRORS)

    @property
    def files(self) -> tuple[str, ...]:
        """Files that the scenario refers to, as written."""
        return ()

    @property
    def panels(self) -> tuple[Panel, ...]:
        """The figure's panels: those that the scenario names, or one per error drawn."""
        return self.figure.panels or tuple(Panel(errors=(name,)) for name in self.DRAWN)
