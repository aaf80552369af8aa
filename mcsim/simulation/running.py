"""Runs a system in the kernel frame: allocates the results and leaves out what is not wanted."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.adjoint import adjoint
from mcsim.kernels.frame import simulate
from mcsim.kernels.lane_steps import read_of
from mcsim.kernels.parts import kernel_of
from mcsim.kernels.system import Results, Sensors
from mcsim.kernels.system import Weights as LinearWeights
from mcsim.sensors.layout import no_terms
from mcsim.simulation.problem import Array

__all__ = ["LinearWeights", "Results", "Sensors", "adjoint_weights", "run", "run_into"]


def adjoint_weights(system: Any, signals: Array) -> tuple[Array, Array]:
    """Linear errors per unit of every disturbance, from the system's own steps.

    Weights (l, n + 1, c) of all that the samples' steps read, and (l, k) of what a realization
    draws once per unit of its deviation; see ``mcsim.kernels.adjoint``.
    """
    channels, rows = system.CHANNELS, len(system.LINEAR)
    samples = np.zeros((rows, len(signals), read_of(type(system))))
    constants = np.zeros((rows, system.CONSTANTS))
    sensors = Sensors(signals, np.zeros(channels), no_terms(channels))
    unit = system._replace(deviations=type(system.deviations)(*[1.0] * len(system.deviations)))
    kernel = _kernel_of(adjoint, system)
    kernel(unit, sensors, samples, constants, np.zeros((len(signals), system.STATE)))
    return samples, constants


def _kernel_of(compiled: Any, system: Any) -> Any:
    kind: Any = type(system)
    return kernel_of(compiled, kind)


_NO_WEIGHTS = LinearWeights(np.zeros((0, 0)), np.zeros((0, 0)))
_NONE_GIVEN = np.zeros((0, 0), np.float32)
_NO_HISTORY = np.empty((0, 0, 0))


def run(
    system: Any,
    key: int,
    first: int,
    count: int,
    sensors: Sensors,
    weights: LinearWeights | None = None,
    given: NDArray[np.float32] | None = None,
    history: Array | None = None,
) -> tuple[Array, Array]:
    """Errors (e, count) and, with weights, linear errors (l, count), else (l, 0).

    Parameters as in ``mcsim.kernels.frame.simulate``; ``history`` (h, n + 1, count) is written at
    every sample if given.
    """
    errors = np.empty((system.ERRORS, count))
    linear = np.empty((len(system.LINEAR), 0 if weights is None else count))
    recorded = np.arange(0 if history is None else history.shape[1])
    results = Results(errors, linear, _NO_HISTORY if history is None else history, recorded)
    run_into(system, key, first, count, sensors, weights, given, results)
    return errors, linear


def run_into(
    system: Any,
    key: int,
    first: int,
    count: int,
    sensors: Sensors,
    weights: LinearWeights | None,
    given: NDArray[np.float32] | None,
    results: Results,
) -> None:
    """Run a system, its results written into the arrays given; see ``simulate``."""
    kernel = _kernel_of(simulate, system)
    kernel(
        system,
        np.uint64(key),
        np.uint64(first),
        count,
        sensors,
        weights or _NO_WEIGHTS,
        _NONE_GIVEN if given is None else given,
        results,
    )
