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
``mcsim.errors``.  What the commands do: ``budget``, ``characterise``, ``read_parameters``,
``calibrate``, ``linearity``, ``convert``, ``convert_quantity``, ``analyse_vibration``, ``table``,
``validate``, ``schema``.  Most return data classes with tables (pandas) and ``write(folder)``,
which writes them with pictures and provenance.  Parts of one's own: ``Picture``, ``PaperTable``
with ``Computed`` and ``Setting``, ``PaperFigure``, ``Command``; ``Report`` writes a folder.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mcsim.errors import InputError, McsimError
from mcsim.version import __version__

if TYPE_CHECKING:
    from mcsim.api.budget import budget
    from mcsim.api.calibrate import calibrate
    from mcsim.api.characterise import characterise
    from mcsim.api.convert import convert, convert_quantity, read_parameters
    from mcsim.api.linearity import linearity
    from mcsim.api.run import run
    from mcsim.api.scenario_files import schema, validate
    from mcsim.api.vibration import analyse_vibration
    from mcsim.cli.command import Command
    from mcsim.figures import Picture
    from mcsim.papers import Computed, PaperFigure, PaperTable, Setting
    from mcsim.papers.table import table
    from mcsim.report import Report
    from mcsim.results import Results
    from mcsim.scenario_file import Scenario
    from mcsim.store import load
    from mcsim.systems.own_rules import add_rule

__all__ = [
    "Command",
    "Computed",
    "InputError",
    "McsimError",
    "PaperFigure",
    "PaperTable",
    "Picture",
    "Report",
    "Results",
    "Scenario",
    "Setting",
    "__version__",
    "add_rule",
    "analyse_vibration",
    "budget",
    "calibrate",
    "characterise",
    "convert",
    "convert_quantity",
    "linearity",
    "load",
    "read_parameters",
    "run",
    "schema",
    "table",
    "validate",
]

_WHERE = {
    "add": "mcsim.adding",
    "add_rule": "mcsim.systems.own_rules",
    "algorithm": "mcsim.simulation.own_motion",
    "along": "mcsim.tracks",
    "Block": "mcsim.scenario.block",
    "Excitation": "mcsim.vibration.excitations",
    "Track": "mcsim.tracks",
    "Case": "mcsim.simulation.case",
    "CaseScenario": "mcsim.scenario.case",
    "driven": "mcsim.simulation.driven",
    "DrivenTrackBlock": "mcsim.tracks",
    "ErrorQuantity": "mcsim.scenario.error_quantities",
    "OwnReckoning": "mcsim.simulation.own_motion",
    "percentile": "mcsim.statistics",
    "samples_of": "mcsim.simulation.driven",
    "Sensors": "mcsim.scenario.sensors",
    "TrackBlock": "mcsim.tracks",
    "Trajectory": "mcsim.tracks",
    "SensorKey": "mcsim.sensor_terms.term",
    "SensorTerm": "mcsim.sensor_terms.term",
    "mechanisms": "mcsim.sensor_terms",
    "Results": "mcsim.results",
    "Scenario": "mcsim.scenario_file",
    "load": "mcsim.store",
    "run": "mcsim.api.run",
    "analyse_vibration": "mcsim.api.vibration",
    "budget": "mcsim.api.budget",
    "calibrate": "mcsim.api.calibrate",
    "characterise": "mcsim.api.characterise",
    "convert": "mcsim.api.convert",
    "convert_quantity": "mcsim.api.convert",
    "linearity": "mcsim.api.linearity",
    "read_parameters": "mcsim.api.convert",
    "schema": "mcsim.api.scenario_files",
    "table": "mcsim.papers.table",
    "validate": "mcsim.api.scenario_files",
    "Command": "mcsim.cli.command",
    "Computed": "mcsim.papers",
    "PaperFigure": "mcsim.papers",
    "PaperTable": "mcsim.papers",
    "Picture": "mcsim.figures",
    "Report": "mcsim.report",
    "Setting": "mcsim.papers",
    "Statistic": "mcsim.statistics",
}


def __getattr__(name: str) -> Any:
    """Import public names when they are first used, so that ``mcsim --help`` is instant."""
    if name in _WHERE:
        from importlib import import_module

        return getattr(import_module(_WHERE[name]), name)
    raise AttributeError(f"module 'mcsim' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
