"""What a sensor element makes of an ideal signal: its error terms, sample by sample.

Plain numpy, made to be read.  An element is set up once, which draws what is constant
(scale factors, misalignments, biases), and then takes its signal in pieces of any size; the
result does not depend on how the signal is cut.  The order is that of a real element: the
low-pass, the scale factors and axes, the added biases and noise, saturation, quantisation.
White noise is added behind the low-pass: its density is that of the output.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.scenario.sensor_block import AccelerometerErrors, GyroscopeErrors
from mcsim.sensors.noise_processes import Flicker, GaussMarkov, LowPass, RandomWalk
from mcsim.units import density_from_random_walk, sample_deviation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SignalErrors:
    """Error terms of one element, SI; arrays (axes,), zero (or infinite) where there is none.

    ``noise_density`` is one-sided; ``bias_instability`` is Allan's B, ``random_walk`` Allan's K;
    ``offset`` is the standard deviation of all constant offsets together.
    """

    noise_density: Array
    bias_instability: Array
    random_walk: Array
    drift: Array
    drift_time: Array
    offset: Array
    scale_factor: Array
    misalignment: Array
    g_sensitivity: Array
    bandwidth: Array
    range: Array
    resolution: Array
    spike_rate: float = 0.0
    spike_amplitude: float = 0.0

    @property
    def axes(self) -> int:
        """Number of axes."""
        return len(self.noise_density)


def signal_errors(block: AccelerometerErrors | GyroscopeErrors, axes: int = 3) -> SignalErrors:
    """The terms of a sensor block for one or three axes.

    Raises
    ------
    ValueError
        Another number of axes.
    """
    if axes not in (1, 3):
        raise ValueError(f"a sensor has one axis or three, not {axes}")

    def of(values: tuple[float, ...] | None, absent: float = 0.0) -> Array:
        given = (absent,) if values is None else values
        return np.broadcast_to(np.asarray(given[:axes], float), (axes,)).copy()

    if isinstance(block, AccelerometerErrors):
        white, walk = block.velocity_random_walk, block.acceleration_random_walk
        sensitivity = None
    else:
        white, walk = block.angle_random_walk, block.rate_random_walk
        sensitivity = block.g_sensitivity
    density = of(block.noise_density)
    if white is not None:
        density = density_from_random_walk(1.0) * of(white)
    process, spikes = block.gauss_markov, block.spikes
    return SignalErrors(
        noise_density=density,
        bias_instability=of(block.bias_instability),
        random_walk=of(walk),
        drift=of(process.deviation if process else None),
        drift_time=of(process.correlation_time if process else None, math.inf),
        offset=np.hypot(of(block.miscalibration), of(block.turn_on_bias)),
        scale_factor=of(block.scale_factor_error),
        misalignment=of(block.misalignment),
        g_sensitivity=of(sensitivity),
        bandwidth=of(block.bandwidth, math.inf),
        range=of(block.range, math.inf),
        resolution=of(block.resolution),
        spike_rate=spikes.rate if spikes else 0.0,
        spike_amplitude=spikes.amplitude if spikes else 0.0,
    )


class Element:
    """One sensing element at work: ideal signal in, measured signal out.

    Parameters
    ----------
    errors : SignalErrors
    rate : float
        Output rate (Hz).
    duration : float
        Length of the whole log (s); flicker noise reaches that far.
    seed : int
        Seed of all its random numbers.
    oversampling : int
        Ideal samples per output sample; the low-pass works on the dense signal, which is then
        picked, aliasing included.
    """

    def __init__(
        self,
        errors: SignalErrors,
        rate: float,
        duration: float,
        seed: int,
        oversampling: int = 1,
    ) -> None:
        self.errors = errors
        step = 1.0 / rate
        self._step, self._oversampling, self._phase = step, oversampling, 0
        # One stream per term: a term that comes or goes shifts no other's numbers.
        streams = [np.random.default_rng([seed, term]) for term in range(7)]
        constants = streams[0]
        axes = errors.axes
        self._mixing = _mixing(errors, constants)
        self._offset = errors.offset * constants.standard_normal(axes)
        self._g_sensitivity = errors.g_sensitivity * constants.standard_normal(axes)
        self._low_pass = LowPass(errors.bandwidth, rate * oversampling)
        self._white = sample_deviation(1.0, rate) * errors.noise_density
        self._white_random, self._spike_random = streams[1], streams[2]
        self._sign_random = streams[3]
        self._added: list[GaussMarkov | Flicker | RandomWalk] = []
        if errors.bias_instability.any():
            self._added.append(Flicker(errors.bias_instability, step, duration, streams[4]))
        if errors.drift.any():
            self._added.append(GaussMarkov(errors.drift, errors.drift_time, step, streams[5]))
        if errors.random_walk.any():
            self._added.append(RandomWalk(errors.random_walk, step, streams[6]))

    def measure(self, ideal: Array, specific_force: Array | None = None) -> Array:
        """What the element outputs for the next piece of its ideal signal.

        Parameters
        ----------
        ideal : ndarray (n, axes)
            At ``oversampling`` times the output rate.
        specific_force : ndarray (n, axes), optional
            At the same times, m/s²; what a gyroscope's g-sensitivity acts on.

        Returns
        -------
        ndarray (about n / oversampling, axes)
        """
        dense = self._low_pass.pass_on(np.asarray(ideal, float))
        first = -self._phase % self._oversampling
        self._phase = (self._phase + len(dense)) % self._oversampling
        picked = dense[first :: self._oversampling]
        # Not by a library's matrix product, whose rounding depends on the size of the pieces.
        measured = (picked[:, None, :] * self._mixing).sum(axis=-1) + self._offset
        if specific_force is not None:
            measured += self._g_sensitivity * specific_force[first :: self._oversampling]
        shape = measured.shape
        if self._white.any():
            measured += self._white * self._white_random.standard_normal(shape)
        for term in self._added:
            measured += term.take(len(measured))
        return self._digitise(measured + self._spikes(shape))

    def _spikes(self, shape: tuple[int, ...]) -> Array:
        errors = self.errors
        if errors.spike_rate == 0.0 or errors.spike_amplitude == 0.0:
            return np.zeros(shape)
        count = self._spike_random.poisson(errors.spike_rate * self._step, shape)
        sign = np.where(self._sign_random.random(shape) < 0.5, -1.0, 1.0)
        return errors.spike_amplitude * sign * count

    def _digitise(self, signal: Array) -> Array:
        """Saturation, then the nearest step of the quantisation."""
        signal = np.clip(signal, -self.errors.range, self.errors.range)
        coarse = self.errors.resolution > 0.0
        step = np.where(coarse, self.errors.resolution, 1.0)
        return np.where(coarse, step * np.round(signal / step), signal)


def _mixing(errors: SignalErrors, random: np.random.Generator) -> Array:
    """Scale factors on the diagonal, small angles between the axes beside it."""
    axes = errors.axes
    angles = errors.misalignment[:, None] * random.standard_normal((axes, axes))
    np.fill_diagonal(angles, 0.0)
    return np.diag(1.0 + errors.scale_factor * random.standard_normal(axes)) + angles
