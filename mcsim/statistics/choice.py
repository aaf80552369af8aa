"""Which statistics are estimated: the list, and the percentiles that a case asks for."""

from __future__ import annotations

import re
from collections.abc import Mapping

from mcsim.errors import InputError
from mcsim.registry import Registry
from mcsim.statistics.collector import PERCENTILES
from mcsim.statistics.deviation import DEVIATION
from mcsim.statistics.mean import MEAN
from mcsim.statistics.percentile import percentile
from mcsim.statistics.rms import RMS
from mcsim.statistics.statistic import Statistic

#: What rows of tables hold besides estimates: the error of the undisturbed reconstruction.
METHOD = "method"
#: Those that are worked out together; percentiles follow them in every table.
MOMENTS = (MEAN, DEVIATION, RMS)
#: Statistics of every error of every case; what is added stands last in every table.
STATISTICS: Registry[Statistic] = Registry("statistic", MOMENTS)

_LIKE_A_PERCENTILE = re.compile(r"p\d")


def _refuse_misleading(statistic: Statistic) -> None:
    """Names that tables use for something else."""
    name = statistic.name
    alike = _LIKE_A_PERCENTILE.match(name) and not statistic.percentiles
    if name == METHOD or alike:
        raise InputError(f"{name}: tables call something else so; give the statistic another name")


STATISTICS.tell(_refuse_misleading)


def estimated(percentiles: tuple[float, ...] = PERCENTILES) -> dict[str, Statistic]:
    """The statistics of every error by name, in the order of every table."""
    chosen = (*MOMENTS, *map(percentile, percentiles), *STATISTICS.values())
    return {statistic.name: statistic for statistic in chosen}


def percentiles_of(statistics: Mapping[str, Statistic]) -> tuple[float, ...]:
    """The percentiles that realizations must be kept around for their estimates."""
    wanted = (p for statistic in statistics.values() for p in statistic.percentiles)
    return tuple(dict.fromkeys(wanted))
