"""One sample of the strapdown kernel: measured channels, and the integrators' steps over lanes."""

from __future__ import annotations

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import LANES
from mcsim.kernels.quaternion import (
    compose,
    cross,
    increment,
    increment_exactly,
    increment_little,
    rotate,
)
from mcsim.kernels.strapdown_layout import (
    OFFSETS,
    PD,
    PH,
    PL,
    PREVIOUS,
    VD,
    VH,
    VL,
    W,
    X,
    Y,
    Z,
)


@scalar
def measured(ideal, offset, noise):
    """One channel of one sample as the sensor reports it; every integrator reads it here."""
    return ideal + offset + noise


def _make_steps(increment_of):
    """The integrators' steps, with the given way of turning rotation vectors to increments."""

    @scalar
    def rectangular(motion, read, gravity):
        """New attitude first, then velocity, then position."""
        w, x, y, z, vl, vd, vh, pl, pd, ph = motion
        f, g, h, a, b, c = read
        d, a, b, c = increment_of(a, b, c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        vl, vd, vh = vl + al, vd + ad, vh + (ah - gravity)
        return w, x, y, z, vl, vd, vh, pl + vl, pd + vd, ph + vh

    @scalar
    def forward_euler(motion, read, gravity):
        """Position from the old velocity, velocity from the old attitude."""
        w, x, y, z, vl, vd, vh, pl, pd, ph = motion
        f, g, h, a, b, c = read
        pl, pd, ph = pl + vl, pd + vd, ph + vh
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        d, a, b, c = increment_of(a, b, c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        return w, x, y, z, vl + al, vd + ad, vh + (ah - gravity), pl, pd, ph

    @scalar
    def trapezoidal(motion, read, gravity):
        """Half of the turn before the interval's mean acceleration acts, half after it."""
        w, x, y, z, vl, vd, vh, pl, pd, ph = motion
        f, g, h, a, b, c = read
        d, a, b, c = increment_of(0.5 * a, 0.5 * b, 0.5 * c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        ah = ah - gravity
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        return (
            w,
            x,
            y,
            z,
            vl + al,
            vd + ad,
            vh + ah,
            pl + (vl + 0.5 * al),
            pd + (vd + 0.5 * ad),
            ph + (vh + 0.5 * ah),
        )

    return rectangular, forward_euler, trapezoidal


@scalar
def _ideal(signals, white, i):
    """A sample's undisturbed channels and the deviations of their noise, out of the lane loop."""
    truth = signals[i, 0], signals[i, 1], signals[i, 2], signals[i, 3], signals[i, 4], signals[i, 5]
    return truth, (white[0], white[1], white[2], white[3], white[4], white[5])


@scalar
def _read(ideal, state, noise, at, j):
    """Measured force (forward, left, up) and turns (roll, pitch, yaw) of one lane's sample.

    Every integrator reads its channels here; ``at`` is the sample's first row of normals.
    """
    truth, deviation = ideal
    planar, spatial = noise
    forward = measured(truth[0], state[OFFSETS + j], deviation[0] * planar[at + j])
    left = measured(truth[1], state[OFFSETS + LANES + j], deviation[1] * planar[at + LANES + j])
    yaw = measured(
        truth[2], state[OFFSETS + 2 * LANES + j], deviation[2] * planar[at + 2 * LANES + j]
    )
    up = measured(truth[3], state[OFFSETS + 3 * LANES + j], deviation[3] * spatial[at + j])
    roll = measured(
        truth[4], state[OFFSETS + 4 * LANES + j], deviation[4] * spatial[at + LANES + j]
    )
    pitch = measured(
        truth[5], state[OFFSETS + 5 * LANES + j], deviation[5] * spatial[at + 2 * LANES + j]
    )
    return forward, left, up, roll, pitch, yaw


@scalar
def _load(state, j):
    return (
        state[W + j],
        state[X + j],
        state[Y + j],
        state[Z + j],
        state[VL + j],
        state[VD + j],
        state[VH + j],
        state[PL + j],
        state[PD + j],
        state[PH + j],
    )


@scalar
def _keep(state, j, motion):
    state[W + j], state[X + j], state[Y + j], state[Z + j] = (
        motion[0],
        motion[1],
        motion[2],
        motion[3],
    )
    state[VL + j], state[VD + j], state[VH + j] = motion[4], motion[5], motion[6]
    state[PL + j], state[PD + j], state[PH + j] = motion[7], motion[8], motion[9]


@scalar
def _load_previous(state, j):
    return (
        state[PREVIOUS + j],
        state[PREVIOUS + LANES + j],
        state[PREVIOUS + 3 * LANES + j],
        state[PREVIOUS + 4 * LANES + j],
        state[PREVIOUS + 5 * LANES + j],
        state[PREVIOUS + 2 * LANES + j],
    )


@scalar
def _keep_previous(state, j, read):
    state[PREVIOUS + j], state[PREVIOUS + LANES + j] = read[0], read[1]
    state[PREVIOUS + 3 * LANES + j] = read[2]
    state[PREVIOUS + 4 * LANES + j], state[PREVIOUS + 5 * LANES + j] = read[3], read[4]
    state[PREVIOUS + 2 * LANES + j] = read[5]


def _make_advance_one_sample(step):
    """Advance a block by sample ``i``, number ``k`` of its group, or by the four of a group."""

    @scalar
    def advance(i, k, noise, signals, white, gravity, state):
        at = 3 * k * LANES
        ideal = _ideal(signals, white, i)
        for j in range(LANES):
            read = _read(ideal, state, noise, at, j)
            _keep(state, j, step(_load(state, j), read, gravity))

    @scalar
    def advance_four(i, noise, signals, white, gravity, state):
        first, second = _ideal(signals, white, i), _ideal(signals, white, i + 1)
        third, fourth = _ideal(signals, white, i + 2), _ideal(signals, white, i + 3)
        for j in range(LANES):
            motion = _load(state, j)
            motion = step(motion, _read(first, state, noise, 0, j), gravity)
            motion = step(motion, _read(second, state, noise, 3 * LANES, j), gravity)
            motion = step(motion, _read(third, state, noise, 6 * LANES, j), gravity)
            motion = step(motion, _read(fourth, state, noise, 9 * LANES, j), gravity)
            _keep(state, j, motion)

    return advance, advance_four


@scalar
def _mean(previous, own, weights):
    """Mean of two samples over the interval of the second, and their corrections."""
    f0, g0, h0, a0, b0, c0 = previous
    f, g, h, a, b, c = own
    previous_share, coning = weights
    share = 1.0 - previous_share
    s1, s2, s3 = cross(a0, b0, c0, f, g, h)
    r1, r2, r3 = cross(f0, g0, h0, a, b, c)
    k1, k2, k3 = cross(a0, b0, c0, a, b, c)
    return (
        share * f + previous_share * f0 + coning * (s1 + r1),
        share * g + previous_share * g0 + coning * (s2 + r2),
        share * h + previous_share * h0 + coning * (s3 + r3),
        share * a + previous_share * a0 + coning * k1,
        share * b + previous_share * b0 + coning * k2,
        share * c + previous_share * c0 + coning * k3,
    )


def _make_advance_two_samples(step):
    """The same for integrators that use the previous sample.

    ``mean`` holds its weight in the interval's mean, and the weight, 1/12 or none, of what two
    neighbouring samples tell of the turning within the interval: sculling
    ``turn_0 x f + f_0 x turn``, coning ``turn_0 x turn``; exact for rates that change linearly.
    """

    @scalar
    def advance(i, k, noise, signals, white, gravity, mean, state):
        at = 3 * k * LANES
        ideal = _ideal(signals, white, i)
        for j in range(LANES):
            read = _read(ideal, state, noise, at, j)
            over = _mean(_load_previous(state, j), read, mean)
            _keep(state, j, step(_load(state, j), over, gravity))
            _keep_previous(state, j, read)

    @scalar
    def advance_four(i, noise, signals, white, gravity, mean, state):
        first, second = _ideal(signals, white, i), _ideal(signals, white, i + 1)
        third, fourth = _ideal(signals, white, i + 2), _ideal(signals, white, i + 3)
        for j in range(LANES):
            motion = _load(state, j)
            before = _load_previous(state, j)
            read = _read(first, state, noise, 0, j)
            motion = step(motion, _mean(before, read, mean), gravity)
            before = _read(second, state, noise, 3 * LANES, j)
            motion = step(motion, _mean(read, before, mean), gravity)
            read = _read(third, state, noise, 6 * LANES, j)
            motion = step(motion, _mean(before, read, mean), gravity)
            before = _read(fourth, state, noise, 9 * LANES, j)
            motion = step(motion, _mean(read, before, mean), gravity)
            _keep(state, j, motion)
            _keep_previous(state, j, before)

    return advance, advance_four


_little, _, _ = _make_steps(increment_little)
_rectangular, _forward_euler, _trapezoidal = _make_steps(increment)
_rectangular_exactly, _forward_euler_exactly, _trapezoidal_exactly = _make_steps(increment_exactly)

#: The fast path: little rotations, the rule of the planar case.
_, advance_four_little = _make_advance_one_sample(_little)
advance, advance_four = _make_advance_one_sample(_rectangular)
advance_euler, _ = _make_advance_one_sample(_forward_euler)
advance_two_samples, advance_two_samples_four = _make_advance_two_samples(_trapezoidal)
# Rotations beyond the polynomials are rare; with the previous sample's weight at zero, these
# serve the integrators of one sample as well.
advance_exactly, _ = _make_advance_two_samples(_rectangular_exactly)
advance_euler_exactly, _ = _make_advance_two_samples(_forward_euler_exactly)
advance_two_samples_exactly, _ = _make_advance_two_samples(_trapezoidal_exactly)
