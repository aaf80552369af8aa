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
  (0, 0, 1) in fractions of the local g; tilt is positive where gravity shows in +x: nose up.
  The truth is the velocity of the wheels; a sensor on a pitching body has a swing of its own.
  A group of runs is one turn-on: a rest, then its runs without a pause.  Offsets, scale
  factors and misalignment are drawn once for it; in-run noise starts with the rest and goes
  on through all its runs.  The error of a run is that of the first one.
* A noise density is one-sided, as data sheets print it: one sample at rate fs has
  variance ND^2 fs / 2.  Allan's N belongs to a two-sided density, variance N^2 fs.
* A sensor measures in this order: resonance, AC coupling, low-pass, mixing of the channels
  (scale factor, misalignment, g-sensitivity) with non-linearity and temperature, offsets,
  jitter, coloured and white noise, spikes, saturation, quantisation.  A noise density is that
  of the output.
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

Public names
------------
SI everywhere; tables (pandas) name their units.  What returns an answer with tables also has
``answer.write(folder)``: tables, pictures and provenance.

Scenarios and results:

* ``Scenario``: ``Scenario.from_yaml(file)`` or ``.from_dict(tree)``, validated;
  ``with_values({path: value})`` is another one.
* ``run(scenario)``: every point of its sweep, as ``Results``, written with ``output=folder``.
* ``Results``: ``table``, a row per point, error and statistic, ``budget``, ``history``, ``tracks``.
* ``load(folder)``: the table of a stored result.

What the commands do:

* ``budget(scenario)``: uncertainty of a velocity scenario (GUM) beside Monte Carlo; m/s, m/s^2.
* ``calibrate(file)``: matrix (3, 3) and bias (3,) of positions at rest, in fractions of g.
* ``linearity(file)``: slope and offset of a shaker test, with uncertainties.
* ``characterise(log)``: a sensor's noise from a static log: a sensor file, Allan curve, spectrum.
* ``characterise_several(logs)``: several of them, with one Allan plot.
* ``compare_stretches(log)``: level, deviation and N before and after a bad stretch.
* ``read_parameters(file)``: ready parameters in any dialect, as a sensor file.
* ``convert(sensor, to)``: a sensor in another noise dialect, as text.
* ``convert_quantity("0.2 °/√h")``: a noise figure in all units and dialects.
* ``allan``: ``plan``, ``curves``, ``from_density``, ``to_density``, ``deviations``, as in
  ``mcsim allan``.
* ``analyse_vibration(file)``: peaks, spectra and orders of a log, or of a simulated scenario.
* ``velocity(files, calibration)``: recorded runs to v(t) of each, their mean and uc; m/s.
* ``compare_vibrations(files)``: what several sensors saw of one vibration, beside each other.
* ``table(name)``: a printed table of a source beside what is computed.
* ``validate(file)``, ``schema(kind)``: a scenario checked without a run; the JSON schema.

Parts of one's own, for ``add(part)`` in a file that ``--with FILE.py`` loads:

* ``Track``: a shape of track, a block (``TrackBlock``; ``DrivenTrackBlock`` has a speed) and its
  manoeuvre, which ``along`` makes of a curve (``curves``, m).
* ``Excitation``: a shape of vibration, a block (``ExcitationBlock``) and its acceleration (m/s^2).
* ``SensorTerm``: a term of the error model, its ``SensorKey`` and one of ``mechanisms``.
* ``Statistic``: ``value(errors)``, of realizations (…, r) to (…); ``percentile(p)`` is one.
* ``Picture``: of the results of every run.
* ``PaperTable`` with ``Computed`` and ``Setting``, ``PaperFigure``: beside those of the papers.
* ``Command``: a click command of ``mcsim``; ``Report`` writes its folder.
* ``Dialect``: how a tool writes a sensor's noise; ``dialects`` has what it reads and writes.
* ``LogFormat``: of measured values, whose columns ``log_columns`` makes of arrays.
* ``Case``: a system that can be simulated; ``ErrorQuantity``: an error that it reports.

Rules and cases of one's own:

* ``add_rule(case, name, …)``: a reconstruction of three small functions in a shipped case.
* ``algorithm(name, …)``: one for a case of one's own, which ``OwnReckoning`` runs.
* ``driven(trajectory, sensors, folder)``: signals (n + 1, 3) of a drive, with their errors and the
  truth; ``samples_of``: how many samples.
* ``CaseScenario``, ``Block``: bases of a case's scenario and of its blocks; ``Trajectory``,
  ``Sensors``: the blocks of the shipped ones; ``fields``: quantities with units (``fields.Speed``);
  ``IdleKey``: a key without effect in some scenarios.

Exceptions: ``McsimError``, and of that kind ``InputError`` (a scenario, an option, a file),
``UnitError`` (an ``InputError``), ``PartialError`` (some points failed), ``InterruptedRun``.

Scalar functions and motions for rules stand in ``mcsim.kernels``: ``planar.Motion``,
``strapdown.Motion``, ``rotation`` (angles), ``quaternion`` (attitudes).
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from mcsim.errors import InputError, InterruptedRun, McsimError, PartialError, UnitError
from mcsim.version import __version__

if TYPE_CHECKING:
    from mcsim import dialects
    from mcsim.adding import add
    from mcsim.api import allan
    from mcsim.api.budget import budget
    from mcsim.api.calibrate import calibrate
    from mcsim.api.characterise import characterise
    from mcsim.api.compare_stretches import compare_stretches
    from mcsim.api.convert import convert, convert_quantity, read_parameters
    from mcsim.api.linearity import linearity
    from mcsim.api.run import run
    from mcsim.api.scenario_files import schema, validate
    from mcsim.api.sensor_comparison import compare_vibrations
    from mcsim.api.several_logs import characterise_several
    from mcsim.api.velocity import velocity
    from mcsim.api.vibration import analyse_vibration
    from mcsim.cli.command import Command
    from mcsim.dialects import Dialect
    from mcsim.figures import Picture
    from mcsim.logs import LogFormat, log_columns
    from mcsim.papers import Computed, PaperFigure, PaperTable, Setting
    from mcsim.papers.table import table
    from mcsim.report import Report
    from mcsim.results import Results
    from mcsim.scenario import fields
    from mcsim.scenario.block import Block
    from mcsim.scenario.case import CaseScenario
    from mcsim.scenario.error_quantities import ErrorQuantity
    from mcsim.scenario.idle import IdleKey
    from mcsim.scenario.sensors import Sensors
    from mcsim.scenario_file import Scenario
    from mcsim.sensor_terms import mechanisms
    from mcsim.sensor_terms.term import SensorKey, SensorTerm
    from mcsim.simulation.case import Case
    from mcsim.simulation.driven import driven, samples_of
    from mcsim.simulation.own_motion import OwnReckoning, algorithm
    from mcsim.statistics import Statistic, percentile
    from mcsim.store import load
    from mcsim.systems.own_rules import add_rule
    from mcsim.tracks import DrivenTrackBlock, Track, TrackBlock, Trajectory, along
    from mcsim.trajectory import curves
    from mcsim.vibration.excitations import Excitation, ExcitationBlock

__all__ = [
    "Block",
    "Case",
    "CaseScenario",
    "Command",
    "Computed",
    "Dialect",
    "DrivenTrackBlock",
    "ErrorQuantity",
    "Excitation",
    "ExcitationBlock",
    "IdleKey",
    "InputError",
    "InterruptedRun",
    "LogFormat",
    "McsimError",
    "OwnReckoning",
    "PaperFigure",
    "PaperTable",
    "PartialError",
    "Picture",
    "Report",
    "Results",
    "Scenario",
    "SensorKey",
    "SensorTerm",
    "Sensors",
    "Setting",
    "Statistic",
    "Track",
    "TrackBlock",
    "Trajectory",
    "UnitError",
    "__version__",
    "add",
    "add_rule",
    "algorithm",
    "allan",
    "along",
    "analyse_vibration",
    "budget",
    "calibrate",
    "characterise",
    "characterise_several",
    "compare_stretches",
    "compare_vibrations",
    "convert",
    "convert_quantity",
    "curves",
    "dialects",
    "driven",
    "fields",
    "linearity",
    "load",
    "log_columns",
    "mechanisms",
    "percentile",
    "read_parameters",
    "run",
    "samples_of",
    "schema",
    "table",
    "validate",
    "velocity",
]

#: Where public names are imported from when they are first used.
_WHERE = {
    # Scenarios and results.
    "Results": "mcsim.results",
    "Scenario": "mcsim.scenario_file",
    "load": "mcsim.store",
    "run": "mcsim.api.run",
    # What the commands do.
    "analyse_vibration": "mcsim.api.vibration",
    "budget": "mcsim.api.budget",
    "calibrate": "mcsim.api.calibrate",
    "characterise": "mcsim.api.characterise",
    "compare_vibrations": "mcsim.api.sensor_comparison",
    "characterise_several": "mcsim.api.several_logs",
    "compare_stretches": "mcsim.api.compare_stretches",
    "convert": "mcsim.api.convert",
    "convert_quantity": "mcsim.api.convert",
    "linearity": "mcsim.api.linearity",
    "read_parameters": "mcsim.api.convert",
    "schema": "mcsim.api.scenario_files",
    "table": "mcsim.papers.table",
    "validate": "mcsim.api.scenario_files",
    "velocity": "mcsim.api.velocity",
    # Parts of one's own.
    "Case": "mcsim.simulation.case",
    "Command": "mcsim.cli.command",
    "Computed": "mcsim.papers",
    "Dialect": "mcsim.dialects",
    "DrivenTrackBlock": "mcsim.tracks",
    "ErrorQuantity": "mcsim.scenario.error_quantities",
    "Excitation": "mcsim.vibration.excitations",
    "ExcitationBlock": "mcsim.vibration.excitations",
    "LogFormat": "mcsim.logs",
    "PaperFigure": "mcsim.papers",
    "PaperTable": "mcsim.papers",
    "Picture": "mcsim.figures",
    "Report": "mcsim.report",
    "SensorKey": "mcsim.sensor_terms.term",
    "SensorTerm": "mcsim.sensor_terms.term",
    "Setting": "mcsim.papers",
    "Statistic": "mcsim.statistics",
    "Track": "mcsim.tracks",
    "TrackBlock": "mcsim.tracks",
    "add": "mcsim.adding",
    "along": "mcsim.tracks",
    "log_columns": "mcsim.logs",
    "percentile": "mcsim.statistics",
    # Rules and cases of one's own.
    "Block": "mcsim.scenario.block",
    "CaseScenario": "mcsim.scenario.case",
    "IdleKey": "mcsim.scenario.idle",
    "OwnReckoning": "mcsim.simulation.own_motion",
    "Sensors": "mcsim.scenario.sensors",
    "Trajectory": "mcsim.tracks",
    "add_rule": "mcsim.systems.own_rules",
    "algorithm": "mcsim.simulation.own_motion",
    "driven": "mcsim.simulation.driven",
    "samples_of": "mcsim.simulation.driven",
}
#: Modules that are public as a whole.
_MODULES = {
    "allan": "mcsim.api.allan",
    "curves": "mcsim.trajectory.curves",
    "dialects": "mcsim.dialects",
    "fields": "mcsim.scenario.fields",
    "mechanisms": "mcsim.sensor_terms.mechanisms",
}


def __getattr__(name: str) -> Any:
    """Import public names when they are first used, so that ``mcsim --help`` is instant."""
    if name in _WHERE:
        return getattr(import_module(_WHERE[name]), name)
    if name in _MODULES:
        return import_module(_MODULES[name])
    raise AttributeError(f"module 'mcsim' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
