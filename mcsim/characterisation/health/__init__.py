"""Is the log that of a healthy sensor at rest?  A module for each way in which it may not be.

``CHECKS`` lists those that look at a channel without its isolated spikes, before anything else is
taken out of it.  Each takes a ``Record`` and returns sentences, or refuses the log where nothing
that is fitted to it would describe the sensor.
"""

from collections.abc import Callable

from mcsim.characterisation.health.clipping import check_clipping
from mcsim.characterisation.health.noise_level import check_noise_level
from mcsim.characterisation.health.record import Finding, Record
from mcsim.characterisation.health.stuck import check_stuck

#: Every check of a channel without its spikes.
CHECKS: tuple[Callable[[Record], list[Finding]], ...] = (
    check_stuck,
    check_clipping,
    check_noise_level,
)

__all__ = ["CHECKS", "Finding", "Record"]
