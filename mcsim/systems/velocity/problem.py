"""The velocity case: a scenario's point as arrays for the velocity kernel."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.velocity import drawn_rows
from mcsim.kernels.velocity_system import PER_INSTANT, RUN, Deviations, Inputs, Velocity
from mcsim.sensors.error_model import ChannelErrors
from mcsim.sensors.measurement import Measurement
from mcsim.simulation.limits import SMALL_TILT, Units, sensor_limits
from mcsim.simulation.nets import net_normals
from mcsim.simulation.problem import Array, History, Limit, LinearModel, Sample
from mcsim.simulation.running import LinearWeights, Results, Sensors, run_into
from mcsim.systems.velocity.linear import (
    BIAS,
    LX,
    LZ,
    REST,
    VelocityWeights,
    velocity_linear_model,
    velocity_weights,
)
from mcsim.systems.velocity.measured import GroupSamples, MeasuredGroups
from mcsim.systems.velocity.raw_output import raw_errors
from mcsim.systems.velocity.samples import rest_output, run_samples
from mcsim.systems.velocity.scenario import Bias, Number, VelocityScenario
from mcsim.systems.velocity.steps import check_group, rest_steps, step_count, steps_until
from mcsim.systems.velocity.truth import true_run

#: Errors at every instant: velocity of a run, of the mean, standard deviation of the runs.
_OF_FIRST, _OF_MEAN, _OF_SCATTER = range(PER_INSTANT)
_MOST_TRACKS = 1000
#: Share of a run after its last sample that is more than rounding.
_MOST_LEFT = 1e-9
_TILT_ORDERS = ("first", "second", "exact")
_NO_CURVES = np.zeros((0, 0, 0))


@dataclass(frozen=True)
class VelocityProblem:
    """Arrays and numbers of one point; see ``mcsim.kernels.velocity``.

    ``raw`` (n, 3) holds the undisturbed raw output at the steps, ``truth`` (n + 1,) the true
    velocity before each step and after the last; ``steps`` (k,) how many steps each asked
    instant takes; ``at_rest`` the samples of the rest.

    A group of runs is one turn-on: the rest, then all runs without a pause.  Offsets, scale
    factors and misalignment are drawn once for all of it; in-run noise starts with the rest and
    goes on to the end of the last run, so that the first run, whose error is reported, is the
    one nearest the rest.
    """

    raw: Array
    truth: Array
    inputs: Array
    uncertainties: Array
    sensor_errors: ChannelErrors
    at_rest: int
    interval: float
    time_error: float
    stamps: bool
    tilt_order: int
    runs: int
    steps: NDArray[np.int64]
    error_names: tuple[str, ...]
    percentiles: tuple[float, ...] = VelocityScenario.PERCENTILES
    told: tuple[Limit, ...] = ()

    @classmethod
    def from_model(cls, model: VelocityScenario, folder: Path = Path()) -> VelocityProblem:
        """Truth, calibration and errors of one point; ``folder`` is where recorded files lie.

        Raises
        ------
        InputError
            An instant earlier than the first sample, an absurdly long run, or a run that cannot
            be read or driven.
        """
        sensor, gravity = model.sensor, model.gravity
        n = step_count(model)
        interval = 1.0 / sensor.rate
        times = np.arange(n + 1, dtype=float) / sensor.rate
        run = true_run(model, folder)
        errors = raw_errors(model)
        raw = run_samples(model, run, times, errors.filters)
        samples = rest_steps(model)
        c = model.calibration
        numbers: list[Number | Bias] = [
            *(c.lxx, c.lxy, c.lxz, c.lzx, c.lzy, c.lzz),
            *(c.bx, c.by, c.bz),
        ]
        problem = cls(
            raw=raw,
            truth=run.profile.velocity(times),
            inputs=np.array(
                [*(q.estimate for q in numbers), *rest_output(model), 0.0, gravity.local_gravity]
            ),
            uncertainties=np.array(
                [
                    *(q.uncertainty for q in numbers),
                    *errors.white / math.sqrt(samples),
                    model.tilt.change,
                    gravity.uncertainty,
                ]
            ),
            sensor_errors=errors,
            at_rest=samples,
            interval=interval,
            time_error=sensor.time_error,
            stamps=sensor.time_errors == "stamps",
            tilt_order=_TILT_ORDERS.index(model.tilt.order),
            runs=model.runs,
            steps=np.array([steps_until(t, sensor.rate) for t in model.reported]),
            error_names=tuple(row.label for row in model.error_rows),
            told=tuple(_told(model)),
        )
        if problem.is_measured:
            check_group(model)
        return problem

    @property
    def white(self) -> Array:
        """u(am): standard deviations (3,) of one raw sample's white noise (fractions of g)."""
        return self.sensor_errors.white

    @property
    def is_measured(self) -> bool:
        """Whether every sample is measured; white noise and offsets alone need no such thing."""
        return len(self.measurement.innovations) > 0

    @property
    def n_samples(self) -> int:
        return self._group.total if self.is_measured else len(self.raw) * self.runs

    @property
    def _group(self) -> GroupSamples:
        return GroupSamples(self.at_rest, len(self.raw), self.runs, self.steps)

    @cached_property
    def signals(self) -> Array:
        """Raw output and what the axes sense (n + 1, 6): at rest, and at a run's steps."""
        raw = np.concatenate([self.inputs[None, REST], self.raw])
        return np.concatenate([raw, raw - self.inputs[BIAS]], axis=1)

    @cached_property
    def measurement(self) -> Measurement:
        """The sensor errors as the kernels take them."""
        # Courses change from run to run.
        signals = self._all_samples if self.sensor_errors.columns else self.signals
        return Measurement.of(self.sensor_errors, signals, self.interval, self._group.total)

    @property
    def missing(self) -> Mapping[str, str]:
        if self.runs > 1:
            return {}
        reason = "a single run has no scatter; raise `runs`"
        return dict.fromkeys(self.error_names[_OF_SCATTER::PER_INSTANT], reason)

    @cached_property
    def weights(self) -> VelocityWeights:
        """First-order weights of all disturbances."""
        return velocity_weights(self)

    @cached_property
    def _measured(self) -> MeasuredGroups:
        group, run, rest = self._group, self.signals[1:], self.signals[0]
        columns = np.zeros((group.runs, group.steps, 0))
        if self.sensor_errors.columns:
            everything = self._all_samples
            runs = everything[group.at_rest :].reshape(group.runs, group.steps, -1)
            columns, run = runs[:, :, len(rest) :], runs.mean(axis=0)
            rest = everything[: group.at_rest].mean(axis=0)
        return MeasuredGroups(self.weights, self.measurement, group, run, rest, columns)

    @cached_property
    def linear(self) -> LinearModel:
        if not self.is_measured:
            return velocity_linear_model(self.weights, self.runs)
        model, m = self._measured.linear_model(), self.measurement
        # Of all samples of the group; those at rest weigh less, and are more.
        spikes = self._group.total * float(np.sum(m.spike_thresholds)) * 2.0**-31
        return replace(model, spike_events=np.full(len(model.mean), spikes))

    def limits(self, key: int, count: int) -> tuple[Limit, ...]:
        found = list(self.told)
        at_rest = self.inputs[REST] - self.inputs[BIAS]
        tilt = math.atan(float(self.inputs[LX] @ at_rest) / float(self.inputs[LZ] @ at_rest))
        if self.tilt_order == 0 and abs(tilt) > SMALL_TILT:
            found.append(
                Limit(
                    f"tilt.order: the sensor is tilted by {math.degrees(tilt):.3g}°, where "
                    f"`first` errs by {0.5 * tilt**2:.1%} of gravity's share; write `exact`"
                )
            )
        if self.is_measured:
            units = Units(np.ones(3), ("g",) * 3)
            found += sensor_limits(
                self.measurement,
                self.signals,
                units,
                self.interval,
                lambda m: self._measured_by(m).simulate(key, 0, count).errors,
            )
        return tuple(found)

    def _measured_by(self, measurement: Measurement) -> VelocityProblem:
        other = replace(self)
        other.__dict__["measurement"] = measurement
        return other

    @cached_property
    def _method_errors(self) -> Array:
        still = replace(
            self,
            uncertainties=0.0 * self.uncertainties,
            sensor_errors=self.sensor_errors.silent(),
            time_error=0.0,
        )
        return still._run(0, 0, 1)[0][:, 0]

    def method_errors(self) -> Array:
        return self._method_errors

    def simulate(
        self, key: int, first: int, count: int, controls: bool = False, net: int = 0
    ) -> Sample:
        return Sample(*self._run(key, first, count, controls, net))

    def velocities(self, key: int, first: int, count: int, net: int = 0) -> Array:
        """Velocities (n, runs, count) of every run of some groups after every step, in m/s."""
        at_all = replace(self, steps=np.arange(1, len(self.raw) + 1))
        curves = np.empty((len(self.raw), self.runs, count))
        at_all._run(key, first, count, net=net, curves=curves)
        return curves

    def errors_over_time(self, key: int, first: int, count: int, net: int = 0) -> Array:
        """The three errors (3, n + 1, count) before the first step and after every one."""
        at_all = replace(self, steps=np.arange(1, len(self.raw) + 1))
        errors, _ = at_all._run(key, first, count, net=net)
        over_time = errors.reshape(len(self.raw), PER_INSTANT, count).swapaxes(0, 1)
        return np.concatenate([np.zeros((PER_INSTANT, 1, count)), over_time], axis=1)

    def history(self, key: int, first: int, count: int, net: int = 0) -> History:
        runs = min(count, _MOST_TRACKS)
        curves = self.velocities(key, first, -(-runs // self.runs), net)
        # Runs of the first group, then of the next.
        tracks = curves.transpose(0, 2, 1).reshape(len(self.raw), -1)[:, :runs]
        return History(
            time=np.arange(len(self.truth), dtype=float) * self.interval,
            tracks=np.concatenate([np.zeros((1, runs)), tracks])[None],
            truth=self.truth[None],
            errors=self.errors_over_time(key, first, count, net),
            coordinates=("velocity [m/s]",),
        )

    def _run(
        self,
        key: int,
        first: int,
        count: int,
        controls: bool = False,
        net: int = 0,
        curves: Array = _NO_CURVES,
    ) -> tuple[Array, Array]:
        """Errors (3 k, count) and linear errors of the same shape or (3 k, 0)."""
        m, rows = self.measurement, PER_INSTANT * len(self.steps)
        errors = np.empty((rows, count))
        linear = np.empty((rows, count if controls else 0))
        drawn = drawn_rows(self.is_measured, m.coefficients)
        run_into(
            self._system,
            key,
            first,
            count,
            Sensors(self._group_signals, self.white, m.terms),
            self._kernel_weights if controls else None,
            net_normals(key, first, count, net, drawn) if net else None,
            Results(errors, linear, curves, self.steps),
        )
        for row in (_OF_FIRST, _OF_MEAN):
            errors[row::PER_INSTANT] -= self.truth[self.steps, None]
        if self.runs == 1:
            errors[_OF_SCATTER::PER_INSTANT] = np.nan
        return errors, linear

    @cached_property
    def _system(self) -> Velocity:
        """The numbers of the system; without a rest an offset acts as an error of the zero bias."""
        offsets, uncertainties = self.measurement.offsets, self.uncertainties
        if not self.is_measured:
            uncertainties = uncertainties.copy()
            uncertainties[BIAS] = np.hypot(uncertainties[BIAS], self.sensor_errors.offsets)
            offsets = np.zeros_like(offsets)
        return Velocity(
            way=RUN,
            draws=True,
            runs=self.runs,
            samples=len(self.raw) if self.is_measured else int(self.steps[-1]),
            at_rest=self.at_rest if self.is_measured else 0,
            order=self.tilt_order,
            interval=self.interval,
            time_error=self.time_error * (math.sqrt(0.5) if self.stamps else 1.0),
            difference=1.0 if self.stamps else 0.0,
            inputs=Inputs(*map(float, self.inputs)),
            deviations=Deviations(*map(float, (*offsets, *uncertainties))),
        )

    @cached_property
    def _group_signals(self) -> Array:
        """The signals of all samples of a group that is measured, else (n + 1, 6) of one run."""
        return self._all_samples if self.is_measured else self.signals

    @cached_property
    def _all_samples(self) -> Array:
        """The signals of all samples of a group, with the courses that follow from them."""
        rest, run = self.signals[:1], self.signals[1:]
        return self.sensor_errors.with_columns(
            np.concatenate([np.tile(rest, (self.at_rest, 1)), np.tile(run, (self.runs, 1))])
        )

    @cached_property
    def _kernel_weights(self) -> LinearWeights:
        return (
            self._measured.kernel_weights() if self.is_measured else self.weights.kernel_weights()
        )


def _told(model: VelocityScenario) -> Iterator[Limit]:
    """What the samples do not hold: swings that are too fast, the end of the run."""
    run, half = model.trajectory, 0.5 * model.sensor.rate
    left = run.duration - model.last_sample
    if model.instants is None and left > _MOST_LEFT * run.duration:
        yield Limit(
            f"trajectory.duration: {run.duration:.6g} s is no multiple of the sampling interval; "
            f"errors are those at the last sample, {model.last_sample:.6g} s, {left:.2g} s before "
            "the end"
        )
    body = model.body.pitch
    if body.gradient != 0.0 and body.natural_frequency > half:
        yield Limit(
            f"sensor.rate: `body.pitch` swings at {body.natural_frequency:.4g} Hz, above half the "
            f"sampling rate, {half:.4g} Hz: samples fold it"
        )
    for name, swing in (("pitch", run.pitch), ("vertical", run.vertical)):
        if swing.amplitude != 0.0 and swing.frequency > half:
            yield Limit(
                f"sensor.rate: `trajectory.{name}` swings at {swing.frequency:.4g} Hz, above half "
                f"the sampling rate, {half:.4g} Hz: samples fold it"
            )
