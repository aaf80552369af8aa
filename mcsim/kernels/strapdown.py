"""Strapdown dead reckoning in space of many disturbed realizations, as lanes of a block.

The application note's equations: the measured specific force is turned into the level frame
and gravity is added, ``a_I = R a_m - (0, 0, g)`` (height counts upwards here, downwards in
the note), then summed to velocity and position.  The attitude is a unit quaternion, turned at
each sample by a rotation vector (see ``quaternion``).  Four integrators share everything else:

* ``RECTANGULAR``: attitude, velocity, position, each from the one before: in the plane this is
  the planar kernel's recursion, Eq. (2)-(3) of the planar paper.
* ``FORWARD_EULER``: position, velocity, attitude, each from the old values: the note's
  ``v[k+1] = v[k] + T a_I[k]``, ``r[k+1] = r[k] + T v[k]``.  Its sample k stands in row k + 1.
* ``TRAPEZOIDAL``: interval means turned by the mid-interval attitude; second order.
* ``TWO_SAMPLE``: the same with the coning and sculling terms of two neighbouring samples
  (Savage, "Strapdown inertial navigation integration algorithm design", 1998).

Random numbers: forward and left acceleration and yaw rate take the planar kernel's streams,
so that on a level road with a stiff vehicle both kernels see the same noise; the other three
channels take streams of their own.  Channels are ordered accordingly, everywhere: forward,
left, yaw turn, then up, roll turn, pitch turn (turns are rates times sampling interval).

As in the planar kernel the sampling interval is factored out of the sums and angles come as
increments.
"""

from __future__ import annotations

import math

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel, scalar
from mcsim.kernels.lanes import (
    CONSTANTS,
    GROUP,
    LANES,
    WHITE_NOISE,
    draw_group,
    draw_normals,
    seed_lanes,
)
from mcsim.kernels.quaternion import (
    LARGEST_ROTATION,
    LITTLE_ROTATION,
    compose,
    cross,
    increment,
    increment_exactly,
    increment_little,
    rotate,
)
from mcsim.kernels.rotation import LARGEST_TURN, angles_from, turn, turn_exactly, wrap

Array = NDArray[np.float64]

CHANNELS = 6
RECTANGULAR, FORWARD_EULER, TRAPEZOIDAL, TWO_SAMPLE = range(4)
#: Streams of the channels and constants that the planar case does not have.
SPATIAL_NOISE, SPATIAL_CONSTANTS = 16, 17
#: Rows of the result: along, across, height, position, roll, pitch, heading, course.
ERRORS = 8
#: Rows of the linear errors: along, across, height, course, roll, pitch, heading.
LINEAR_ERRORS = 7
_OF_ALL_CHANNELS = 4
_TURNS = (2, 4, 5)
#: Weights per sample: four errors of six channels, three attitude errors of three turns.
WEIGHTS = CHANNELS * _OF_ALL_CHANNELS + 3 * len(_TURNS)
#: Rows of a recorded history: position, velocity (along, across, height), roll, pitch, heading.
HISTORY_ROWS = 9

# Constants of a realization.  The first twelve are the planar kernel's: offsets of its three
# channels, initial speed, direction, heading, course, one spare, noise of sample 0, one spare.
# Then offsets of the other three channels, initial roll and pitch, noise of the levelling's
# means (forward, left, up), noise of sample 0 of the other three channels, one spare.
N_CONSTANTS = 24
SPEED, DIRECTION, HEADING, COURSE, FIRST_PLANAR = 3, 4, 5, 6, 8
SPATIAL, ROLL, PITCH, REST, FIRST_SPATIAL = 12, 15, 16, 17, 20

# Rows of the state: quaternion, velocity, position, offsets and previous sample of the
# channels, linear errors, and rows for angles and vectors at the start and the end.
_W, _X, _Y, _Z = (LANES * row for row in range(4))
_VL, _VD, _VH = (LANES * row for row in range(4, 7))
_PL, _PD, _PH = (LANES * row for row in range(7, 10))
_OFFSETS = LANES * 10
_PREVIOUS = LANES * 16
_LINEAR = LANES * 22
_A, _B, _C, _D, _E, _F, _G, _H = (LANES * row for row in range(29, 37))
_N_STATE = LANES * 37

#: Below this cosine of the pitch, roll and heading are one rotation: see ``euler_angles``.
_LOCKED = 1e-6


@scalar
def measured(ideal, offset, noise):
    """One channel of one sample as the sensor reports it; every integrator reads it here."""
    return ideal + offset + noise


def _make_steps(increment_of):
    """The integrators' steps, with the given way of turning rotation vectors to increments."""

    @scalar
    def rectangular(w, x, y, z, vl, vd, vh, pl, pd, ph, f, g, h, a, b, c, gravity):
        """New attitude first, then velocity, then position."""
        d, a, b, c = increment_of(a, b, c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        vl, vd, vh = vl + al, vd + ad, vh + (ah - gravity)
        return w, x, y, z, vl, vd, vh, pl + vl, pd + vd, ph + vh

    @scalar
    def forward_euler(w, x, y, z, vl, vd, vh, pl, pd, ph, f, g, h, a, b, c, gravity):
        """Position from the old velocity, velocity from the old attitude."""
        pl, pd, ph = pl + vl, pd + vd, ph + vh
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        d, a, b, c = increment_of(a, b, c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        return w, x, y, z, vl + al, vd + ad, vh + (ah - gravity), pl, pd, ph

    @scalar
    def trapezoidal(w, x, y, z, vl, vd, vh, pl, pd, ph, f, g, h, a, b, c, gravity):
        """Half of the turn before the interval's mean acceleration acts, half after it."""
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
def corrections(f0, g0, h0, a0, b0, c0, f, g, h, a, b, c):
    """What two neighbouring samples tell of the turning within an interval, times 12.

    Specific forces (f, g, h) and turns (a, b, c): sculling ``turn_0 x f + f_0 x turn`` and
    coning ``turn_0 x turn``; with their factor 1/12 exact for rates that change linearly.
    """
    s1, s2, s3 = cross(a0, b0, c0, f, g, h)
    r1, r2, r3 = cross(f0, g0, h0, a, b, c)
    k1, k2, k3 = cross(a0, b0, c0, a, b, c)
    return s1 + r1, s2 + r2, s3 + r3, k1, k2, k3


@scalar
def _load(state, j):
    return (
        state[_W + j],
        state[_X + j],
        state[_Y + j],
        state[_Z + j],
        state[_VL + j],
        state[_VD + j],
        state[_VH + j],
        state[_PL + j],
        state[_PD + j],
        state[_PH + j],
    )


@scalar
def _keep(state, j, w, x, y, z, vl, vd, vh, pl, pd, ph):
    state[_W + j], state[_X + j], state[_Y + j], state[_Z + j] = w, x, y, z
    state[_VL + j], state[_VD + j], state[_VH + j] = vl, vd, vh
    state[_PL + j], state[_PD + j], state[_PH + j] = pl, pd, ph


def _make_advance_one_step(step):
    """Advance a block by sample ``i``, number ``k`` of its group; one sample per interval."""

    @scalar
    def advance(i, k, planar, spatial, signals, white, gravity, state):
        row = 3 * k * LANES
        f0, l0, c0 = signals[i, 0], signals[i, 1], signals[i, 2]
        u0, a0, b0 = signals[i, 3], signals[i, 4], signals[i, 5]
        sf, sl, sc, su, sa, sb = white[0], white[1], white[2], white[3], white[4], white[5]
        for j in range(LANES):
            w, x, y, z, vl, vd, vh, pl, pd, ph = _load(state, j)
            f = measured(f0, state[_OFFSETS + j], sf * planar[row + j])
            g = measured(l0, state[_OFFSETS + LANES + j], sl * planar[row + LANES + j])
            c = measured(c0, state[_OFFSETS + 2 * LANES + j], sc * planar[row + 2 * LANES + j])
            h = measured(u0, state[_OFFSETS + 3 * LANES + j], su * spatial[row + j])
            a = measured(a0, state[_OFFSETS + 4 * LANES + j], sa * spatial[row + LANES + j])
            b = measured(b0, state[_OFFSETS + 5 * LANES + j], sb * spatial[row + 2 * LANES + j])
            w, x, y, z, vl, vd, vh, pl, pd, ph = step(
                w, x, y, z, vl, vd, vh, pl, pd, ph, f, g, h, a, b, c, gravity
            )
            _keep(state, j, w, x, y, z, vl, vd, vh, pl, pd, ph)

    return advance


def _make_advance_two_samples(step):
    """The same for integrators that use the previous sample.

    ``previous_share`` is its weight in the interval's mean, ``coning`` that of the corrections.
    """

    @scalar
    def advance(i, k, planar, spatial, signals, white, gravity, previous_share, coning, state):
        row = 3 * k * LANES
        f0, l0, c0 = signals[i, 0], signals[i, 1], signals[i, 2]
        u0, a0, b0 = signals[i, 3], signals[i, 4], signals[i, 5]
        sf, sl, sc, su, sa, sb = white[0], white[1], white[2], white[3], white[4], white[5]
        share = 1.0 - previous_share
        for j in range(LANES):
            w, x, y, z, vl, vd, vh, pl, pd, ph = _load(state, j)
            f = measured(f0, state[_OFFSETS + j], sf * planar[row + j])
            g = measured(l0, state[_OFFSETS + LANES + j], sl * planar[row + LANES + j])
            c = measured(c0, state[_OFFSETS + 2 * LANES + j], sc * planar[row + 2 * LANES + j])
            h = measured(u0, state[_OFFSETS + 3 * LANES + j], su * spatial[row + j])
            a = measured(a0, state[_OFFSETS + 4 * LANES + j], sa * spatial[row + LANES + j])
            b = measured(b0, state[_OFFSETS + 5 * LANES + j], sb * spatial[row + 2 * LANES + j])
            pf, pg = state[_PREVIOUS + j], state[_PREVIOUS + LANES + j]
            pc, pu = state[_PREVIOUS + 2 * LANES + j], state[_PREVIOUS + 3 * LANES + j]
            pa, pb = state[_PREVIOUS + 4 * LANES + j], state[_PREVIOUS + 5 * LANES + j]
            mf = share * f + previous_share * pf
            mg = share * g + previous_share * pg
            mh = share * h + previous_share * pu
            ma = share * a + previous_share * pa
            mb = share * b + previous_share * pb
            mc = share * c + previous_share * pc
            df, dg, dh, da, db, dc = corrections(pf, pg, pu, pa, pb, pc, f, g, h, a, b, c)
            mf, mg, mh = mf + coning * df, mg + coning * dg, mh + coning * dh
            ma, mb, mc = ma + coning * da, mb + coning * db, mc + coning * dc
            w, x, y, z, vl, vd, vh, pl, pd, ph = step(
                w, x, y, z, vl, vd, vh, pl, pd, ph, mf, mg, mh, ma, mb, mc, gravity
            )
            _keep(state, j, w, x, y, z, vl, vd, vh, pl, pd, ph)
            state[_PREVIOUS + j], state[_PREVIOUS + LANES + j] = f, g
            state[_PREVIOUS + 2 * LANES + j], state[_PREVIOUS + 3 * LANES + j] = c, h
            state[_PREVIOUS + 4 * LANES + j], state[_PREVIOUS + 5 * LANES + j] = a, b

    return advance


_rectangular_little, _, _ = _make_steps(increment_little)
_rectangular, _forward_euler, _trapezoidal = _make_steps(increment)
_rectangular_exactly, _forward_euler_exactly, _trapezoidal_exactly = _make_steps(increment_exactly)

_advance_little = _make_advance_one_step(_rectangular_little)
_advance = _make_advance_one_step(_rectangular)
_advance_euler = _make_advance_one_step(_forward_euler)
_advance_two_samples = _make_advance_two_samples(_trapezoidal)
# Rotations beyond the polynomials are rare; with the previous sample's weight at zero, these
# serve the integrators of one sample as well.
_advance_exactly = _make_advance_two_samples(_rectangular_exactly)
_advance_euler_exactly = _make_advance_two_samples(_forward_euler_exactly)
_advance_two_samples_exactly = _make_advance_two_samples(_trapezoidal_exactly)


@scalar
def _turned_halves(angle, extra_row, state, cos_row, sin_row):
    """Cosines and sines of half of ``angle`` plus each lane's own (radians)."""
    c0 = math.cos(0.5 * angle)
    s0 = math.sin(0.5 * angle)
    for j in range(LANES):
        state[cos_row + j], state[sin_row + j] = turn(c0, s0, 0.5 * state[extra_row + j])
    for j in range(LANES):
        if abs(state[extra_row + j]) > LARGEST_TURN:
            c, s = turn_exactly(c0, s0, 0.5 * state[extra_row + j])
            state[cos_row + j], state[sin_row + j] = c, s


@scalar
def _start_motion(constants, deviations, initial, interval, state):
    """Velocity and position rows; the direction error turns the velocity about the vertical."""
    for j in range(LANES):
        direction = deviations[DIRECTION] * constants[DIRECTION * LANES + j]
        course = deviations[COURSE] * constants[COURSE * LANES + j]
        # Twice the angle: the rows get cosine and sine of its half.
        state[_A + j] = 2.0 * (direction + course)
        heading = deviations[HEADING] * constants[HEADING * LANES + j]
        state[_B + j] = direction + heading
    _turned_halves(2.0 * initial[8], _A, state, _VL, _VD)
    cos_climb = math.cos(initial[4])
    sin_climb = math.sin(initial[4])
    t2 = interval * interval
    for j in range(LANES):
        speed = (initial[3] + deviations[SPEED] * constants[SPEED * LANES + j]) / interval
        state[_VL + j] *= speed * cos_climb
        state[_VD + j] *= speed * cos_climb
        state[_VH + j] = speed * sin_climb
        state[_PL + j] = initial[0] / t2
        state[_PD + j] = initial[1] / t2
        state[_PH + j] = initial[2] / t2


@scalar
def _level(constants, deviations, rest, initial, state):
    """Roll and pitch errors (rows C, D) that levelling by the mean specific force at rest makes.

    ``roll = atan2(left, up)``, ``pitch = atan2(-forward, |(left, up)|)``; the accelerometers
    have the offsets that they keep.
    """
    for j in range(LANES):
        forward = rest[0] + state[_OFFSETS + j]
        left = rest[1] + state[_OFFSETS + LANES + j]
        up = rest[2] + state[_OFFSETS + 3 * LANES + j]
        forward += deviations[REST] * constants[REST * LANES + j]
        left += deviations[REST + 1] * constants[(REST + 1) * LANES + j]
        up += deviations[REST + 2] * constants[(REST + 2) * LANES + j]
        across = math.sqrt(left * left + up * up)
        state[_C + j] += wrap(math.atan2(left, up) - initial[5])
        state[_D + j] += wrap(math.atan2(-forward, across) - initial[6])


@scalar
def _start_attitude(initial, state):
    """Quaternion rows from true angles (initial 5 ... 7) and errors in the rows C, D, B."""
    _turned_halves(initial[5], _C, state, _E, _F)
    _turned_halves(initial[6], _D, state, _G, _H)
    _turned_halves(initial[7], _B, state, _C, _D)
    for j in range(LANES):
        cr, sr = state[_E + j], state[_F + j]
        cp, sp = state[_G + j], state[_H + j]
        ch, sh = state[_C + j], state[_D + j]
        state[_W + j] = cr * cp * ch + sr * sp * sh
        state[_X + j] = sr * cp * ch - cr * sp * sh
        state[_Y + j] = cr * sp * ch + sr * cp * sh
        state[_Z + j] = cr * cp * sh - sr * sp * ch


@scalar
def _constant_of(channel, planar, spatial):
    """Number of a channel's constant; the planar channels' lie apart from the others'."""
    return planar + channel if channel < 3 else spatial + channel - 3


@scalar
def _start(constants, deviations, initial, rest, levelled, signals, interval, state):
    """State rows at sample 0, from the true state and the realization's constants."""
    for channel in range(CHANNELS):
        row = channel * LANES
        fixed = _constant_of(channel, 0, SPATIAL)
        first = _constant_of(channel, FIRST_PLANAR, FIRST_SPATIAL)
        for j in range(LANES):
            offset = deviations[fixed] * constants[fixed * LANES + j]
            noise = deviations[first] * constants[first * LANES + j]
            state[_OFFSETS + row + j] = offset
            state[_PREVIOUS + row + j] = measured(signals[0, channel], offset, noise)
    _start_motion(constants, deviations, initial, interval, state)
    for j in range(LANES):
        state[_C + j] = deviations[ROLL] * constants[ROLL * LANES + j]
        state[_D + j] = deviations[PITCH] * constants[PITCH * LANES + j]
    if levelled:
        _level(constants, deviations, rest, initial, state)
    _start_attitude(initial, state)


@scalar
def _start_linear(constants, linear_constants, state):
    """Linear errors from what is drawn once per realization."""
    for error in range(LINEAR_ERRORS):
        row = _LINEAR + error * LANES
        for j in range(LANES):
            state[row + j] = 0.0
        for k in range(N_CONSTANTS):
            weight = linear_constants[error, k]
            for j in range(LANES):
                state[row + j] += weight * constants[k * LANES + j]


@scalar
def _add_linear(i, k, planar, spatial, sensitivity, state):
    """Add sample ``i``'s noise to the linear errors."""
    row = 3 * k * LANES
    for error in range(_OF_ALL_CHANNELS):
        at = CHANNELS * error
        a0, a1, a2 = sensitivity[i, at], sensitivity[i, at + 1], sensitivity[i, at + 2]
        a3, a4, a5 = sensitivity[i, at + 3], sensitivity[i, at + 4], sensitivity[i, at + 5]
        to = _LINEAR + error * LANES
        for j in range(LANES):
            total = a0 * planar[row + j]
            total = total + a1 * planar[row + LANES + j]
            total = total + a2 * planar[row + 2 * LANES + j]
            total = total + a3 * spatial[row + j]
            total = total + a4 * spatial[row + LANES + j]
            total = total + a5 * spatial[row + 2 * LANES + j]
            state[to + j] += total
    for error in range(3):
        at = CHANNELS * _OF_ALL_CHANNELS + 3 * error
        a0, a1, a2 = sensitivity[i, at], sensitivity[i, at + 1], sensitivity[i, at + 2]
        to = _LINEAR + (_OF_ALL_CHANNELS + error) * LANES
        for j in range(LANES):
            total = a0 * planar[row + 2 * LANES + j]
            total = total + a1 * spatial[row + LANES + j]
            total = total + a2 * spatial[row + 2 * LANES + j]
            state[to + j] += total


@scalar
def _axes(state):
    """Direction cosines that Euler angles need: forward and up as rows A ... E.

    A, B, C: the forward axis along, across, upwards; D, E: the left and up axes upwards.
    """
    for j in range(LANES):
        w, x, y, z = state[_W + j], state[_X + j], state[_Y + j], state[_Z + j]
        state[_A + j] = 1.0 - 2.0 * (y * y + z * z)
        state[_B + j] = 2.0 * (x * y + w * z)
        state[_C + j] = 2.0 * (x * z - w * y)
        state[_D + j] = 2.0 * (y * z + w * x)
        state[_E + j] = 1.0 - 2.0 * (x * x + y * y)


@scalar
def _unlock(state):
    """Euler angles' convention where the pitch is ±90°: no roll, the heading turns it all."""
    for j in range(LANES):
        forward = state[_A + j] * state[_A + j] + state[_B + j] * state[_B + j]
        if forward < _LOCKED * _LOCKED:
            w, x, y, z = state[_W + j], state[_X + j], state[_Y + j], state[_Z + j]
            state[_A + j] = 1.0 - 2.0 * (x * x + z * z)
            state[_B + j] = 2.0 * (w * z - x * y)
            state[_D + j] = 0.0
            state[_E + j] = 1.0
            state[_F + j] = 0.0
        else:
            state[_F + j] = math.sqrt(forward)


@scalar
def _record(state, sample, start, filled, interval, history):
    """States after ``sample``."""
    t2 = interval * interval
    _axes(state)
    _unlock(state)
    for j in range(filled):
        history[0, sample, start + j] = t2 * state[_PL + j]
        history[1, sample, start + j] = t2 * state[_PD + j]
        history[2, sample, start + j] = t2 * state[_PH + j]
        history[3, sample, start + j] = interval * state[_VL + j]
        history[4, sample, start + j] = interval * state[_VD + j]
        history[5, sample, start + j] = interval * state[_VH + j]
        history[6, sample, start + j] = math.atan2(state[_D + j], state[_E + j])
        history[7, sample, start + j] = math.atan2(-state[_C + j], state[_F + j])
        history[8, sample, start + j] = math.atan2(state[_B + j], state[_A + j])


@scalar
def _finish(state, start, filled, interval, final, errors, linear):
    """Errors at the last sample; linear errors where they are wanted."""
    t2 = interval * interval
    for j in range(filled):
        along = t2 * state[_PL + j] - final[0]
        across = t2 * state[_PD + j] - final[1]
        height = t2 * state[_PH + j] - final[2]
        errors[0, start + j] = along
        errors[1, start + j] = across
        errors[2, start + j] = height
        errors[3, start + j] = math.sqrt(along * along + across * across + height * height)
    _axes(state)
    _unlock(state)
    for j in range(LANES):
        state[_C + j] = -state[_C + j]
    angles_from(final[3], _E, _D, state, _G)
    angles_from(final[4], _F, _C, state, _H)
    for j in range(filled):
        errors[4, start + j] = state[_G + j]
        errors[5, start + j] = state[_H + j]
    angles_from(final[5], _A, _B, state, _G)
    angles_from(final[6], _VL, _VD, state, _H)
    for j in range(filled):
        errors[6, start + j] = state[_G + j]
        errors[7, start + j] = state[_H + j]
    if linear.shape[1] > 0:
        for error in range(LINEAR_ERRORS):
            for j in range(filled):
                linear[error, start + j] = state[_LINEAR + error * LANES + j]


@kernel
def simulate(
    key: np.uint64,
    first: np.uint64,
    count: int,
    signals: Array,
    white: Array,
    deviations: Array,
    initial: Array,
    final: Array,
    rest: Array,
    levelled: bool,
    gravity: float,
    interval: float,
    method: int,
    previous_share: float,
    largest_turn: float,
    sensitivity: Array,
    linear_constants: Array,
    errors: Array,
    linear: Array,
    history: Array,
) -> None:
    """Reconstruct ``count`` realizations from number ``first`` on; their errors at the last sample.

    Parameters
    ----------
    key, first : uint64
        Key of the random numbers and index of the first realization.
    count : int
    signals : float64 (n + 1, 6)
        Undisturbed specific force (m/s^2) and turns per interval (rad) at samples 0 ... n,
        in the order forward, left, yaw, up, roll, pitch; sample 0 is the known initial state.
        For ``FORWARD_EULER`` row k + 1 holds sample k.
    white : float64 (6,)
        Standard deviation of the white noise of one sample, per channel.
    deviations : float64 (24,)
        Standard deviation of each constant of a realization, in the order of this module.
    initial : float64 (9,)
        True state at sample 0: along, across, height (m), speed (m/s), climb
        spare, roll, pitch, heading, course (rad).
    final : float64 (7,)
        Truth at sample n: along, across, height (m), roll, pitch, heading, course (rad; NaN
        if undefined).
    rest : float64 (3,)
        Specific force at rest in the initial attitude: forward, left, up (m/s^2).
    levelled : bool
        Roll and pitch are initialised from the measured specific force at rest.
    gravity : float
        m/s^2, downwards.
    interval : float
        Sampling interval T (s).
    method : int
        ``RECTANGULAR``, ``FORWARD_EULER``, ``TRAPEZOIDAL`` or ``TWO_SAMPLE``.
    previous_share : float
        Weight of the previous sample in the interval's mean, for the last two: 1/2 for
        momentary samples, 0 for samples that are already means over the interval.
    largest_turn : float
        A bound of the rotation per sample (rad); it decides how rotations are computed.
    sensitivity : float64 (n + 1, WEIGHTS)
        Linear errors per unit normal at each sample: along, across, height and course from
        each channel, then roll, pitch and heading from the turns (yaw, roll, pitch).
    linear_constants : float64 (7, 24)
        Linear errors per unit normal of each constant.
    errors : float64 (8, count), written
        along, across, height, position (m), roll, pitch, heading, course (rad).
    linear : float64 (7, count) or (7, 0), written
        Linear errors of the same realizations, unless empty.
    history : float64 (HISTORY_ROWS, n + 1, count) or (0, 0, 0), written
        Reconstructed states at every sample, unless empty.
    """
    n = signals.shape[0] - 1
    record = history.shape[1] > 0
    with_linear = linear.shape[1] > 0
    little = largest_turn <= LITTLE_ROTATION
    exact = largest_turn > LARGEST_ROTATION
    one_sample = method in (RECTANGULAR, FORWARD_EULER)
    coning = 1 / 12 if method == TWO_SAMPLE else 0.0
    if one_sample:
        previous_share = 0.0
    with_constants = levelled
    for k in range(N_CONSTANTS):
        with_constants = with_constants or deviations[k] != 0.0
    planar_state = np.empty(4 * LANES, np.uint32)
    spatial_state = np.empty(4 * LANES, np.uint32)
    planar = np.empty(3 * GROUP * LANES, np.float32)
    spatial = np.empty(3 * GROUP * LANES, np.float32)
    constants = np.zeros(N_CONSTANTS * LANES, np.float32)
    state = np.empty(_N_STATE, np.float64)
    half = N_CONSTANTS // 2
    for block in range((count + LANES - 1) // LANES):
        start = block * LANES
        filled = min(LANES, count - start)
        block_first = first + uint64(start)
        if with_constants:
            draw_normals(key, block_first, CONSTANTS, half, constants)
            draw_normals(key, block_first, SPATIAL_CONSTANTS, half, constants[half * LANES :])
        _start(constants, deviations, initial, rest, levelled, signals, interval, state)
        if with_linear:
            _start_linear(constants, linear_constants, state)
        seed_lanes(key, block_first, WHITE_NOISE, planar_state)
        seed_lanes(key, block_first, SPATIAL_NOISE, spatial_state)
        if record:
            _record(state, 0, start, filled, interval, history)
        for i in range(1, n + 1, GROUP):
            draw_group(planar_state, planar)
            draw_group(spatial_state, spatial)
            for k in range(min(GROUP, n + 1 - i)):
                if with_linear:
                    _add_linear(i + k, k, planar, spatial, sensitivity, state)
                if one_sample and not exact:
                    if method == FORWARD_EULER:
                        _advance_euler(i + k, k, planar, spatial, signals, white, gravity, state)
                    elif little:
                        _advance_little(i + k, k, planar, spatial, signals, white, gravity, state)
                    else:
                        _advance(i + k, k, planar, spatial, signals, white, gravity, state)
                elif not exact:
                    _advance_two_samples(
                        i + k,
                        k,
                        planar,
                        spatial,
                        signals,
                        white,
                        gravity,
                        previous_share,
                        coning,
                        state,
                    )
                elif method == RECTANGULAR:
                    _advance_exactly(
                        i + k, k, planar, spatial, signals, white, gravity, 0.0, 0.0, state
                    )
                elif method == FORWARD_EULER:
                    _advance_euler_exactly(
                        i + k, k, planar, spatial, signals, white, gravity, 0.0, 0.0, state
                    )
                else:
                    _advance_two_samples_exactly(
                        i + k,
                        k,
                        planar,
                        spatial,
                        signals,
                        white,
                        gravity,
                        previous_share,
                        coning,
                        state,
                    )
                if record:
                    _record(state, i + k, start, filled, interval, history)
        _finish(state, start, filled, interval, final, errors, linear)
