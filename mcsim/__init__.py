"""mcsim: how well a vehicle knows where it is, from inertial sensors alone.

A Monte-Carlo simulator of track reconstruction.  The street runs one way::

    scenario -> trajectory -> sensors -> kernel -> statistics -> results -> figures

Conventions (the whole package keeps them)
------------------------------------------
* SI inside: m, s, rad, m/s^2, rad/s.  Other units exist only in scenario files,
  tables and figures, and are converted by the closed table in ``mcsim.units``.
* Standard gravity 9.80665 m/s^2.
* Road frame: ``along`` in the initial direction of movement, ``across`` to the left
  of it.  ``heading`` is the direction of the vehicle's axis, ``course`` that of its
  velocity; both from ``along``, counter-clockwise positive, errors in (-pi, pi].
  Side-slip is course minus heading.
* Body axes: forward, left.  Channels are always ordered forward acceleration, left
  acceleration, yaw rate.
* In space (strapdown case): ``height`` upwards, body axes forward, left, up; Euler angles
  heading, pitch, roll (Z-Y-X); roll positive with the left side up, pitch with the nose
  down (ISO 8855).  Accelerometers measure specific force, +g upwards at rest.  At a pitch
  of +-90 deg the roll is zero by convention.  The frame is level and does not turn with
  the earth.  Channels: the planar three, then upward force, roll rate, pitch rate; errors:
  along, across, height, position, roll, pitch, heading, course.
* Time 0 is where the manoeuvre starts; sample 0, the known initial state, lies one
  lead before it.
* Velocity case: sensor axes x forward, z up, so that a level sensor at rest reads
  (0, 0, 1) in fractions of the local g; tilt is positive where gravity shows in +x.
  A group of runs is one turn-on: a rest, then its runs without a pause.  Offsets, scale
  factors and misalignment are drawn once for it; in-run noise starts with the rest and goes
  on through all its runs.  The error of a run is that of the first one.
* A noise density is one-sided, as data sheets print it: one sample at rate fs has
  variance ND^2 fs / 2.  Allan's N belongs to a two-sided density, variance N^2 fs.
* A sensor measures in this order: low-pass, mixing of the channels (scale factor,
  misalignment, g-sensitivity), offsets, jitter, coloured and white noise, spikes,
  saturation, quantisation.  A noise density is that of the output.
* Before the run the vehicle may rest: first biases are calibrated, in a known attitude, then
  the attitude is levelled, then it drives; in-run noise goes on through all three.  At rest a
  sensor sees gravity, and calibration takes away whatever stands there beyond the truth.
* Errors are reconstruction minus truth at the last sample, in the order along,
  across, position, heading, course (velocity case: of a run, of the mean of runs,
  standard deviation of the runs).  Standard deviations are those of the
  population: rms^2 = mean^2 + std^2.  Percentiles are those of the signed error.
* ``method`` is the error of the undisturbed reconstruction: sampling and
  integration alone, no sensor error.
* A realization's random numbers depend on the seed, its point's own coordinates and
  its index: not on threads, blocks, order, or other points.

Public names: ``Scenario``, ``run``, ``Results``, ``load``, ``add_rule``, and the exceptions of
``mcsim.errors``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mcsim.errors import InputError, McsimError
from mcsim.version import __version__

if TYPE_CHECKING:
    from mcsim.api import run
    from mcsim.results import Results
    from mcsim.scenario_file import Scenario
    from mcsim.store import load
    from mcsim.systems.own_rules import add_rule

__all__ = [
    "InputError",
    "McsimError",
    "Results",
    "Scenario",
    "__version__",
    "add_rule",
    "load",
    "run",
]

_WHERE = {
    "add": "mcsim.adding",
    "add_rule": "mcsim.systems.own_rules",
    "algorithm": "mcsim.simulation.own_motion",
    "along": "mcsim.tracks",
    "Block": "mcsim.scenario.block",
    "Case": "mcsim.simulation.case",
    "CaseScenario": "mcsim.scenario.case",
    "driven": "mcsim.simulation.driven",
    "DrivenTrackBlock": "mcsim.tracks",
    "ErrorQuantity": "mcsim.scenario.error_quantities",
    "OwnReckoning": "mcsim.simulation.own_motion",
    "percentile": "mcsim.statistics",
    "samples_of": "mcsim.simulation.driven",
    "Sensors": "mcsim.scenario.sensors",
    "Statistic": "mcsim.statistics",
    "Track": "mcsim.tracks",
    "TrackBlock": "mcsim.tracks",
    "Trajectory": "mcsim.tracks",
    "Results": "mcsim.results",
    "Scenario": "mcsim.scenario_file",
    "load": "mcsim.store",
    "run": "mcsim.api",
}


def __getattr__(name: str) -> Any:
    """Import public names when they are first used, so that ``mcsim --help`` is instant."""
    if name in _WHERE:
        from importlib import import_module

        return getattr(import_module(_WHERE[name]), name)
    raise AttributeError(f"module 'mcsim' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
