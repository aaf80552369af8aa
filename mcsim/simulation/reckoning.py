"""A point of any case of dead reckoning: what the engine asks for, from what the case says.

A case says what its sensors would measure, their errors, what errs at the start, and the numbers
of its kernel system.  Everything else follows: realizations, the linear model by the system's own
steps (``mcsim.kernels.adjoint``), controls, budget, limits.  Closed forms of the weights may
replace the adjoint's, as fast paths; a test holds them against it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from mcsim.scenario.case import CaseScenario
from mcsim.sensor_terms.mechanisms.jitter import JITTER
from mcsim.sensors.error_model import ChannelErrors
from mcsim.sensors.measurement import AtRest, Measurement, NormalWeights
from mcsim.sensors.schedule import STAMPS, Schedule
from mcsim.simulation.limits import (
    angle_limits,
    loss_limits,
    rate_limits,
    sensor_limits,
    units_of,
)
from mcsim.simulation.linear_errors import Errors, Weights, variances_of
from mcsim.simulation.nets import net_normals
from mcsim.simulation.problem import Array, History, Limit, LinearModel, Sample
from mcsim.simulation.running import LinearWeights, Sensors, adjoint_weights, run
from mcsim.simulation.time_errors import clock_of, instant_weights, stamp_weights, truth_late


@dataclass(frozen=True)
class Description:
    """What a case's system measures and errs in, by name.

    ``errors`` are in the order of the kernel's; ``lengths`` those that are the length of a vector,
    with its components; ``wrapping`` angles whose errors wrap at half a turn.  ``signals`` are the
    channels in words.  ``initial`` maps what errs at the start, by its name in budgets, to places
    among the kernel's constants.
    """

    errors: tuple[str, ...]
    signals: tuple[str, ...]
    lengths: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    wrapping: tuple[str, ...] = ()
    initial: Mapping[str, Iterable[int]] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Reckoning:
    """Arrays and numbers of a system that dead-reckons.

    ``signals`` (n + 1, c) are what the channels would measure, with turns per interval in the
    place of angular rates, as in all ``sensor_errors``; further columns are channels that show in
    them by misalignment.  ``initial_deviations`` (k,) are those of what errs at the start, in the
    places of the kernel's constants.  ``interval`` is that of the samples (s).  ``missing`` tells
    errors that are undefined, with the reason; of each ``beyond_rate`` (c,) is the share of power
    that the sampling rate does not hold.
    """

    signals: Array
    sensor_errors: ChannelErrors
    initial_deviations: Array
    interval: float
    missing: Mapping[str, str] = field(default_factory=dict)
    beyond_rate: Array = field(default_factory=lambda: np.zeros(1))
    percentiles: tuple[float, ...] = CaseScenario.PERCENTILES

    # --- what a case says ---------------------------------------------------------------

    @property
    def description(self) -> Description:
        """What the system measures and errs in."""
        raise NotImplementedError

    @property
    def kernel(self) -> Any:
        """The class of the kernel system."""
        raise NotImplementedError

    def system(self, measurement: Measurement, disturbed: bool) -> Any:
        """The numbers of the kernel system, with a measurement's offsets."""
        raise NotImplementedError

    def history(self, key: int, first: int, count: int, net: int = 0) -> History:
        """The same realizations over time."""
        raise NotImplementedError

    @cached_property
    def weights(self) -> Weights:
        """First-order weights of all disturbances: by the system's own steps."""
        samples, constants = self._by_steps
        return Weights.without_rest(samples[:, :, : self.kernel.CHANNELS], constants)

    @property
    def at_rest(self) -> AtRest | None:
        """A rest before the run that the run's start is taken from."""
        return None

    @property
    def rows(self) -> Array:
        """The signals as the integrator takes them; one may be a sample behind."""
        return self.signals

    @property
    def first(self) -> int:
        """The first row that is measured."""
        return 0

    def laid_out(self, samples: Array) -> Array:
        """Weights (l, n + 1, c) of the samples' normals as the kernel's ``add_linear`` reads them.

        Every channel may act on every error, unless the system has a form of its own.
        """
        return np.moveaxis(samples, 0, 1).reshape(samples.shape[1], -1)

    def further_limits(self, key: int, count: int) -> Iterator[Limit]:  # noqa: ARG002
        """Limits of this case alone."""
        return iter(())

    # --- what follows from it -----------------------------------------------------------

    @property
    def error_names(self) -> tuple[str, ...]:
        return self.description.errors

    @property
    def n_samples(self) -> int:
        return len(self.signals) - 1

    @cached_property
    def errors(self) -> Errors:
        """How the reported errors follow from the kernel's linear ones."""
        places = self.error_names.index
        lengths = {places(n): tuple(map(places, of)) for n, of in self.description.lengths.items()}
        return Errors(tuple(self.kernel.LINEAR), lengths)

    @property
    def schedule(self) -> Schedule | None:
        """When samples are taken, and what integrators know of it; None where that is even."""
        return self.sensor_errors.schedule

    @property
    def timed(self) -> bool:
        """Whether the system reads an interval with each sample."""
        return self.schedule is not None and self.schedule.varies

    @property
    def times(self) -> Array:
        """Times (n + 1,) of the samples, in s from the first."""
        schedule = self.schedule
        if schedule is None or schedule.instants is None or schedule.instants.even:
            return np.arange(self.n_samples + 1, dtype=float) * self.interval
        return schedule.instants.true

    @property
    def longest(self) -> float:
        """The longest interval, in sampling intervals, that practically any realization has."""
        return 1.0 if self.schedule is None else self.schedule.longest

    @cached_property
    def read(self) -> Array:
        """The rows as the kernel reads them: with the interval before each, where it varies."""
        if not self.timed or self.schedule is None:
            return self.rows
        return np.column_stack([self.rows, self.schedule.ratios])

    @cached_property
    def _by_steps(self) -> tuple[Array, Array]:
        """Weights of all that steps read and of what is drawn once; see ``adjoint_weights``."""
        system = self.system(Measurement.none(self.sensor_errors), disturbed=False)
        return adjoint_weights(system, self.read)

    @cached_property
    def measurement(self) -> Measurement:
        """The sensor errors as the kernel takes them."""
        m = Measurement.of(self.sensor_errors, self.rows, self.interval, first=self.first)
        if self.timed and len(m.jitter):
            # Time begins at the first instant.
            m = replace(m, jitter=np.concatenate([0.0 * m.jitter[:1], m.jitter[1:]]))
        return m

    def measured_by(self, measurement: Measurement) -> Self:
        """The same problem with other sensors."""
        other = replace(self)
        other.__dict__["measurement"] = measurement
        return other

    @cached_property
    def normal_weights(self) -> NormalWeights:
        """Linear errors per unit normal of the sensors' random numbers."""
        return self.measurement.fold(self.weights.samples, self.rows, self.at_rest)

    @cached_property
    def control_covariance(self) -> Array:
        """Covariance (l, l) of the linear errors that the controls hold."""
        initial = self.weights.constants * self.initial_deviations
        return self.normal_weights.covariance + initial @ initial.T

    @cached_property
    def variances_by_source(self) -> Mapping[str, Array]:
        """Variance (l,) of the linear errors by source."""
        found = dict(self.measurement.variances(self.weights.samples, self.rows, self.at_rest))
        found |= variances_of(
            self.weights.constants, self.initial_deviations, self.description.initial
        )
        found |= self._time_variances()
        if self.at_rest is not None:
            found["levelling noise"] = self.measurement.levelling_noise(self.at_rest)
        return found

    def _time_variances(self) -> dict[str, Array]:
        """Variances (l,) by what instants and stamps of samples err."""
        schedule, jitters = self.schedule, self.measurement.jitter
        if schedule is None or not schedule.varies:
            return {}
        found, intervals = {}, self._by_steps[0][:, :, -1]
        if len(jitters):
            signals = np.einsum("enc,nc->en", self.weights.samples, jitters)
            instants = instant_weights(schedule, intervals, signals)
            found[JITTER] = np.sum(instants**2, axis=1)
        if schedule.times.stamp_jitter and not schedule.nominal:
            found[STAMPS] = np.sum(stamp_weights(schedule, intervals) ** 2, axis=1)
        return found

    @cached_property
    def linear(self) -> LinearModel:
        model = self.errors.model(
            self.control_covariance, self.variances_by_source, self.method_errors()
        )
        events = self.measurement.spike_events(self.weights.samples)
        return replace(model, spike_events=self.errors.spike_events(events))

    def limits(self, key: int, count: int) -> tuple[Limit, ...]:
        spread, wrapping = self.linear.spread, self.description.wrapping
        return (
            *sensor_limits(
                self.measurement,
                self.rows,
                units_of(self.sensor_errors, self.interval),
                self.interval,
                lambda m: self.measured_by(m).simulate(key, 0, count).errors,
            ),
            *rate_limits(self.beyond_rate, 1.0 / self.interval, self.description.signals),
            *loss_limits(self.schedule),
            *self.further_limits(key, count),
            *angle_limits(self.error_names, wrapping, self.method_errors(), spread),
        )

    @cached_property
    def _method_errors(self) -> Array:
        return self.run(0, 0, 1, disturbed=False)[0][:, 0]

    def method_errors(self) -> Array:
        return self._method_errors

    def simulate(
        self, key: int, first: int, count: int, controls: bool = False, net: int = 0
    ) -> Sample:
        errors, linear = self.run(key, first, count, with_linear=controls, net=net)
        if controls:
            linear = self.errors.controls(linear, self.method_errors())
        return Sample(errors, linear)

    def states(self, key: int, first: int, count: int, net: int = 0) -> Array:
        """What the system records at every sample (h, n + 1, count)."""
        history = np.empty((self.kernel.HISTORY, self.n_samples + 1, count))
        self.run(key, first, count, history=history, net=net)
        return history

    def run(
        self,
        key: int,
        first: int,
        count: int,
        disturbed: bool = True,
        with_linear: bool = False,
        history: Array | None = None,
        net: int = 0,
    ) -> tuple[Array, Array]:
        """Errors (e, count) and linear errors (l, count or 0)."""
        m = self.measurement if disturbed else Measurement.none(self.sensor_errors)
        return run(
            self.system(m, disturbed),
            key,
            first,
            count,
            Sensors(self.read, m.white, m.terms, clock_of(self.schedule, disturbed)),
            self._kernel_weights if with_linear else None,
            net_normals(key, first, count, net, self.drawn(m)) if net else None,
            history,
        )

    def drawn(self, measurement: Measurement) -> int:
        """Normals that the kernel draws once per realization, in fours."""
        return int(self.kernel.CONSTANTS) + -(-measurement.coefficients // 4) * 4

    def deviations(self, measurement: Measurement, disturbed: bool) -> Array:
        """Deviations (k,) of what a realization draws once, in the places of the constants."""
        if not disturbed:
            return np.zeros(self.kernel.CONSTANTS)
        deviations = self.initial_deviations.copy()
        deviations[self._offsets] = measurement.offsets
        return deviations

    @property
    def _offsets(self) -> list[int]:
        """Places of the channels' offsets among the constants."""
        return [first + k for first in self.kernel.FIXED for k in range(3)]

    @property
    def first_noise(self) -> list[int]:
        """Places of the noise of sample 0 among the constants."""
        return [first + k for first in self.kernel.FIRST for k in range(3)]

    def late(self, states: Array, truth: Array) -> tuple[Array, Array]:
        """Recorded states without how late samples are, and the truth (k, n + 1, r or 1) then.

        ``truth`` (k, n + 1) is that at the ``times``.
        """
        if not self.timed:
            return states, truth[:, :, None]
        if self.measurement.jitter.shape[0] == 0:
            return states[:-1], truth[:, :, None]
        return states[:-1], truth_late(truth, self.times, states[-1])

    @cached_property
    def _kernel_weights(self) -> LinearWeights:
        """Weights per normal, laid out for the kernel; sample 0 is among the constants."""
        w, fixed = self.normal_weights, int(self.kernel.CONSTANTS)
        constants = np.zeros((len(w.samples), fixed + w.mixing.shape[1]))
        constants[:, :fixed] = self.weights.constants * self.initial_deviations
        constants[:, self._offsets] = w.offsets
        constants[:, self.first_noise] = w.samples[:, 0]
        self.add_levelling(w, constants)
        constants[:, fixed:] = w.mixing
        return LinearWeights(self.laid_out(w.samples), constants)

    def add_levelling(self, weights: NormalWeights, constants: Array) -> None:
        """Put the weights of the means at rest into their places, where a case levels."""
