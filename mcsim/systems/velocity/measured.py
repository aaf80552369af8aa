"""The linear model of groups whose accelerometer has more errors than white noise.

In-run noise goes on from the rest through all runs, so the runs of a group are correlated, beyond
what they share.  It is a sum of first-order processes; the errors of all runs are sums over
it, whose covariance follows process by process.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.process import Processes
from mcsim.sensors.measurement import Measurement
from mcsim.simulation.problem import LinearModel
from mcsim.simulation.running import LinearWeights
from mcsim.systems.velocity.linear import REST, VelocityWeights
from mcsim.systems.velocity.scatter import mean_scatter, mean_square_scatter, scatter_quantile

Array = NDArray[np.float64]

_AXES = 3


@dataclass(frozen=True)
class GroupSamples:
    """A group's samples: ``at_rest``, then those of ``runs`` runs of ``steps`` each.

    ``counts`` (k,) are the steps of a run until each instant.
    """

    at_rest: int
    steps: int
    runs: int
    counts: NDArray[np.int64]

    @property
    def total(self) -> int:
        return self.at_rest + self.steps * self.runs


@dataclass(frozen=True)
class ProcessSums:
    """Second moments of sums over a first-order process from the first sample at rest on.

    ``rest`` is the variance of its mean at rest, ``rest_end`` that mean's covariance with the
    last state there; ``own`` (M, k) are variances of the sums over each run until each
    instant, ``ends`` (M, k) their covariances with the last state summed; ``powers`` (k,) sums of
    the decay's powers.
    """

    group: GroupSamples
    decay: float
    rest: float
    rest_end: float
    own: Array
    ends: Array
    powers: Array

    @classmethod
    def of(
        cls, decay: float, step_variance: float, start: float, group: GroupSamples
    ) -> ProcessSums:
        """``start`` is the variance at the first sample; the others are per sample."""
        from scipy.signal import lfilter

        drive = np.full(group.total, step_variance)
        drive[0] = start
        variance = lfilter([1.0], [1.0, -decay * decay], drive)
        rest_own, rest_ends = _sums(variance[None, : group.at_rest], decay)
        own, ends = _sums(variance[group.at_rest :].reshape(group.runs, group.steps), decay)
        return cls(
            group,
            decay,
            float(rest_own[0, -1]) / group.at_rest**2,
            float(rest_ends[0, -1]) / group.at_rest,
            own[:, group.counts - 1],
            ends[:, group.counts - 1],
            power_sums(np.array([decay]), group.steps)[group.counts, 0],
        )

    def covariance(self, instant: int, of_run: float, of_rest: float) -> Array:
        """Covariance (M, M) of the runs' ``of_run`` times sum plus ``of_rest`` times mean."""
        group, until = self.group, int(self.group.counts[instant])
        run = np.arange(group.runs)
        # A later run begins this many samples after the last one that was summed.
        gaps = np.maximum(run * group.steps - until + 1, 0)
        later = self.powers[instant] * self.decay**gaps
        runs = self.ends[np.minimum.outer(run, run), instant]
        runs = runs * later[np.abs(np.subtract.outer(run, run))]
        np.fill_diagonal(runs, self.own[:, instant])
        with_rest = self.rest_end * self.powers[instant] * self.decay ** (1.0 + run * group.steps)
        return np.asarray(
            of_run**2 * runs
            + of_run * of_rest * np.add.outer(with_rest, with_rest)
            + of_rest**2 * self.rest,
            float,
        )


def _sums(variance: Array, decay: float) -> tuple[Array, Array]:
    """Variances of the running sums along the rows, and covariances with the last one summed."""
    from scipy.signal import lfilter

    ends = lfilter([1.0], [1.0, -decay], variance, axis=1)
    own = np.cumsum(variance, axis=1)
    own[:, 1:] += 2.0 * decay * np.cumsum(ends[:, :-1], axis=1)
    return own, ends


def power_sums(decay: Array, longest: int) -> Array:
    """Sums (longest + 1, p) of the first 0, 1, … powers of each decay (p,)."""
    powers = decay[None, :] ** np.arange(longest)[:, None]
    return np.concatenate([np.zeros((1, len(decay))), np.cumsum(powers, axis=0)])


@dataclass(frozen=True)
class _Moments:
    """Variances (k,) of the first run and of the mean, and mean square of the scatter."""

    first: Array
    mean: Array
    scatter: Array

    @property
    def rows(self) -> Array:
        return np.stack([self.first, self.mean, self.scatter], axis=1).ravel()


def _moments(covariances: Array) -> _Moments:
    """Moments from covariances (k, M, M) of the runs."""
    return _Moments(
        covariances[:, 0, 0].copy(),
        covariances.mean(axis=(1, 2)),
        np.array([mean_square_scatter(c) for c in covariances]),
    )


@dataclass(frozen=True)
class MeasuredGroups:
    """First-order effect of all disturbances of groups that are measured sample by sample.

    ``weights`` are those of the undisturbed run; ``run`` (n, 6 + v) and ``rest`` (6 + v,) the
    signals, the last v of which are means over runs and rest of what changes with the temperature:
    ``columns`` (M, n, v) in each run.
    """

    weights: VelocityWeights
    measurement: Measurement
    group: GroupSamples
    run: Array
    rest: Array
    columns: Array

    @property
    def _of_rest(self) -> Array:
        """Velocity (k, 3) per mean error of an axis at rest."""
        return self.weights.slopes[:, REST]

    @cached_property
    def _offsets(self) -> Array:
        """Velocity (k, 3) per constant offset of an axis."""
        return self._of_rest + np.outer(self.group.counts, self.weights.per_sample)

    @cached_property
    def _mixing(self) -> Array:
        """Velocity (k, m) per unit normal of each mixing coefficient."""
        sums = np.cumsum(self.run, axis=0)[self.group.counts - 1]
        columns = [
            m.deviation
            * (
                self.weights.per_sample[m.target] * sums[:, m.source]
                + self._of_rest[:, m.target] * self.rest[m.source]
            )
            for m in self.measurement.errors.mixing
        ]
        return np.stack(columns, axis=1) if columns else np.zeros((len(sums), 0))

    def _changing(self) -> Mapping[str, Array]:
        """Covariances (k, M, M) of the runs by source, from what may change from run to run."""
        counts, first = self.group.counts, len(self.rest) - self.columns.shape[2]
        sums = np.cumsum(self.columns, axis=1)[:, counts - 1]
        found: dict[str, Array] = {}
        for m in self.measurement.errors.mixing:
            if m.source >= first:
                of_run = self.weights.per_sample[m.target] * sums[:, :, m.source - first]
                of_rest = self._of_rest[:, m.target] * self.rest[m.source]
                each = m.deviation * (of_run + of_rest).T
                found[m.term] = found.get(m.term, 0.0) + each[:, :, None] * each[:, None, :]
        return found

    def kernel_weights(self) -> LinearWeights:
        """The weights as the kernel takes them.

        At rest those of each axis' mean error, in a run of the velocity at the end of the sample's
        segment; the last column is the interval's.
        """
        group, counts = self.group, self.group.counts
        most = self.measurement.terms.decay.shape[1]
        samples = np.zeros((group.total, 4))
        samples[group.at_rest :, 3] = np.tile(self.weights.steps[:, 3], group.runs)
        states = np.zeros((len(counts), 1, _AXES, most))
        left_at_rest = np.arange(group.at_rest)[::-1]
        left_in_run = np.tile(_left(group), group.runs)
        segments = np.diff(counts, prepend=0)
        for axis, own in enumerate(self.measurement.innovations):
            of_run, p = self.weights.per_sample[axis], len(own.decay)
            sums = power_sums(own.decay, max(group.at_rest, group.steps))
            left = np.append(left_at_rest, left_in_run)
            acts = own.deviations + np.sum(own.gains * sums[left], axis=1)
            samples[: group.at_rest, axis] = acts[: group.at_rest] / group.at_rest
            samples[group.at_rest :, axis] = of_run * acts[group.at_rest :]
            states[:, 0, axis, :p] = of_run * sums[segments]
        once = self.weights.group.copy()
        once[:, REST] = 0.0  # measured
        constants = np.concatenate(
            [once, self._offsets * self.measurement.offsets, self._mixing], axis=1
        )
        flat = states.reshape(len(counts), 1, _AXES * most)
        return LinearWeights(samples, constants, flat, np.ascontiguousarray(self._of_rest))

    def _common(self) -> Mapping[str, Array]:
        """Variances (k,) by source of what all runs share, in-run noise apart."""
        found = dict(self.weights.group_variances())
        mixed = self._mixing
        for column, entry in enumerate(self.measurement.errors.mixing):
            found[entry.term] = found.get(entry.term, 0.0) + mixed[:, column] ** 2
        return found

    def _independent(self) -> Mapping[str, Array]:
        """Variances (3,) of one sample by source, from errors that samples do not share."""
        m = self.measurement
        found = {}
        if np.any(m.resolutions):
            # A rounding error is uniform over a step, where the noise is no smaller.
            found["accelerometer quantisation"] = m.resolutions**2 / 12.0
        if len(m.spike_thresholds):
            probability = m.spike_thresholds * 2.0**-31
            found["accelerometer spikes"] = probability * m.spike_amplitudes**2
        return found

    def _coloured(self) -> Mapping[str, Array]:
        """Covariances (k, M, M) of the runs by source of in-run noise."""
        k, runs = len(self.group.counts), self.group.runs
        found: dict[str, Array] = {}
        for axis, processes in enumerate(self.measurement.errors.processes):
            for term in processes.terms:
                total = found.setdefault(f"accelerometer {term}", np.zeros((k, runs, runs)))
                for sums in _process_sums(processes.only(term), self.group):
                    for i in range(k):
                        total[i] += sums.covariance(
                            i, self.weights.per_sample[axis], self._of_rest[i, axis]
                        )
        return found

    def linear_model(self) -> LinearModel:
        """Moments of the linear errors: velocity, mean velocity, scatter per instant.

        The velocity is that of the first run after the rest.  The scatter is that of normal
        runs with the covariance of all that disturbs, exact but for spikes and rounding errors,
        which count as normal.
        """
        runs, counts = self.group.runs, self.group.counts
        common, steps = self._common(), self.weights.step_variances()
        coloured, independent = self._coloured(), self._independent()
        variances = {name: _shared(v).rows for name, v in common.items()}
        variances |= {name: _each(v, runs).rows for name, v in steps.items()}
        variances |= {name: _moments(c).rows for name, c in coloured.items()}
        controlled = np.sum(list(variances.values()), axis=0)
        changing = self._changing()
        # The controls hold their means over the runs.
        variances |= {name: _moments(c).rows for name, c in changing.items()}
        own = np.sum(list(steps.values()), axis=0)
        for name, variance in independent.items():
            at_rest = self._of_rest**2 @ variance / self.group.at_rest
            moving = np.asarray(counts * float(self.weights.per_sample**2 @ variance), float)
            own = own + moving
            variances[name] = np.add(_shared(at_rest).rows, _each(moving, runs).rows)
        of_runs = [np.zeros((len(counts), runs, runs)), *coloured.values(), *changing.values()]
        deviating = np.sum(of_runs, axis=0) + own[:, None, None] * np.eye(runs)
        mean = np.zeros(3 * len(counts))
        mean[2::3] = [mean_scatter(c) for c in deviating]
        controlled[2::3] = 0.0
        return LinearModel(
            mean=mean,
            second_moment=np.sum(list(variances.values()), axis=0),
            control_mean=np.zeros_like(mean),
            control_second_moment=controlled,
            variances=variances,
            quantiles={
                3 * i + 2: partial(scatter_quantile, c) for i, c in enumerate(deviating) if runs > 1
            },
        )


def _left(group: GroupSamples) -> NDArray[np.int64]:
    """Samples (n,) of a run that follow each one in its own segment, none beyond the last."""
    sample = np.arange(group.steps)
    ends = np.append(group.counts, group.steps)
    return np.asarray(ends[np.searchsorted(group.counts, sample, side="right")] - 1 - sample)


def _process_sums(processes: Processes, group: GroupSamples) -> list[ProcessSums]:
    return [
        ProcessSums.of(float(decay), float(step), float(start), group)
        for decay, step, start in zip(
            processes.decay, processes.step_variance, np.diag(processes.start), strict=True
        )
    ]


def _shared(variance: Array) -> _Moments:
    return _Moments(variance, variance, np.zeros_like(variance))


def _each(variance: Array, runs: int) -> _Moments:
    """Of errors that are independent between runs."""
    return _Moments(variance, variance / runs, variance if runs > 1 else np.zeros_like(variance))
