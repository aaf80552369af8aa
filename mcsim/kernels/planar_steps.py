"""One sample of the planar kernel: measured channels, and the integrators' steps over lanes."""

from __future__ import annotations

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import LANES
from mcsim.kernels.planar_layout import (
    COS,
    FORWARD,
    HALF_TURN,
    LEFT,
    OFFSETS,
    PD,
    PL,
    SIN,
    VD,
    VL,
    YAW,
)
from mcsim.kernels.rotation import turn, turn_exactly, turn_little


def _make_steps(turn_by):
    """The two integrators' steps, with the given way of turning the heading."""

    @scalar
    def rectangular(c, s, vl, vd, pl, pd, forward, left, angle):
        """Eq. (2), (3): new heading first, then velocity, then position."""
        c, s = turn_by(c, s, angle)
        vl = vl + c * forward
        vl = vl - s * left
        vd = vd + s * forward
        vd = vd + c * left
        return c, s, vl, vd, pl + vl, pd + vd

    @scalar
    def trapezoidal(c, s, vl, vd, pl, pd, forward, left, angle):
        """(c, s) is the mid-interval heading, inputs are means over the interval."""
        c, s = turn_by(c, s, angle)
        al = c * forward - s * left
        ad = s * forward + c * left
        return c, s, vl + al, vd + ad, pl + (vl + 0.5 * al), pd + (vd + 0.5 * ad)

    return rectangular, trapezoidal


_step_little, _ = _make_steps(turn_little)
rectangular_step, _trapezoidal_step = _make_steps(turn)
_step_exactly, _trapezoidal_step_exactly = _make_steps(turn_exactly)


@scalar
def measure_plainly(i, row, normals, signals, white, state, measured):
    """Measured channels of sample ``i`` where offsets and white noise are all there is."""
    for channel in range(3):
        value, deviation = signals[i, channel], white[channel]
        own = channel * LANES
        drawn = normals[row * LANES + own : row * LANES + own + LANES]
        for j in range(LANES):
            measured[own + j] = value + state[OFFSETS + own + j] + deviation * drawn[j]


@scalar
def keep_measured(measured, state):
    """Sample 0 as the previous one (for the trapezoidal rule)."""
    for j in range(3 * LANES):
        state[FORWARD + j] = measured[j]


def _make_advance_four(step, with_offsets):
    """Advance a block by four samples, rectangular, with or without constant offsets."""

    @scalar
    def disturbed(undisturbed, offset, noise):
        return undisturbed + offset + noise if with_offsets else undisturbed + noise

    @scalar
    def advance_four(i, normals, signals, white, state):
        f0, l0, w0 = signals[i, 0], signals[i, 1], signals[i, 2]
        f1, l1, w1 = signals[i + 1, 0], signals[i + 1, 1], signals[i + 1, 2]
        f2, l2, w2 = signals[i + 2, 0], signals[i + 2, 1], signals[i + 2, 2]
        f3, l3, w3 = signals[i + 3, 0], signals[i + 3, 1], signals[i + 3, 2]
        sf, sl, sw = white[0], white[1], white[2]
        for j in range(LANES):
            c, s = state[COS + j], state[SIN + j]
            vl, vd = state[VL + j], state[VD + j]
            pl, pd = state[PL + j], state[PD + j]
            bf = state[OFFSETS + j]
            bl = state[OFFSETS + LANES + j]
            bw = state[OFFSETS + 2 * LANES + j]
            forward = disturbed(f0, bf, sf * normals[j])
            left = disturbed(l0, bl, sl * normals[LANES + j])
            angle = disturbed(w0, bw, sw * normals[2 * LANES + j])
            c, s, vl, vd, pl, pd = step(c, s, vl, vd, pl, pd, forward, left, angle)
            forward = disturbed(f1, bf, sf * normals[3 * LANES + j])
            left = disturbed(l1, bl, sl * normals[4 * LANES + j])
            angle = disturbed(w1, bw, sw * normals[5 * LANES + j])
            c, s, vl, vd, pl, pd = step(c, s, vl, vd, pl, pd, forward, left, angle)
            forward = disturbed(f2, bf, sf * normals[6 * LANES + j])
            left = disturbed(l2, bl, sl * normals[7 * LANES + j])
            angle = disturbed(w2, bw, sw * normals[8 * LANES + j])
            c, s, vl, vd, pl, pd = step(c, s, vl, vd, pl, pd, forward, left, angle)
            forward = disturbed(f3, bf, sf * normals[9 * LANES + j])
            left = disturbed(l3, bl, sl * normals[10 * LANES + j])
            angle = disturbed(w3, bw, sw * normals[11 * LANES + j])
            c, s, vl, vd, pl, pd = step(c, s, vl, vd, pl, pd, forward, left, angle)
            state[COS + j], state[SIN + j] = c, s
            state[VL + j], state[VD + j] = vl, vd
            state[PL + j], state[PD + j] = pl, pd

    return advance_four


#: The fast paths: little turns and nothing but noise, and everything else.
advance_four_little = _make_advance_four(_step_little, with_offsets=False)
advance_four = _make_advance_four(rectangular_step, with_offsets=True)


def _make_advance(rectangular, trapezoidal):
    """Advance a block by one measured sample, with the given steps."""

    @scalar
    def advance_rectangular(measured, state):
        for j in range(LANES):
            c, s, vl, vd, pl, pd = rectangular(
                state[COS + j],
                state[SIN + j],
                state[VL + j],
                state[VD + j],
                state[PL + j],
                state[PD + j],
                measured[j],
                measured[LANES + j],
                measured[2 * LANES + j],
            )
            state[COS + j], state[SIN + j] = c, s
            state[VL + j], state[VD + j] = vl, vd
            state[PL + j], state[PD + j] = pl, pd

    @scalar
    def advance_trapezoidal(measured, previous_share, state):
        share = 1.0 - previous_share
        for j in range(LANES):
            forward, left = measured[j], measured[LANES + j]
            angle = measured[2 * LANES + j]
            half_turn = 0.5 * (share * angle + previous_share * state[YAW + j])
            c, s, vl, vd, pl, pd = trapezoidal(
                state[COS + j],
                state[SIN + j],
                state[VL + j],
                state[VD + j],
                state[PL + j],
                state[PD + j],
                share * forward + previous_share * state[FORWARD + j],
                share * left + previous_share * state[LEFT + j],
                # From the middle of the last interval to the middle of this one.
                state[HALF_TURN + j] + half_turn,
            )
            state[COS + j], state[SIN + j] = c, s
            state[VL + j], state[VD + j] = vl, vd
            state[PL + j], state[PD + j] = pl, pd
            state[FORWARD + j], state[LEFT + j] = forward, left
            state[YAW + j], state[HALF_TURN + j] = angle, half_turn

    return advance_rectangular, advance_trapezoidal


advance, advance_trapezoidal = _make_advance(rectangular_step, _trapezoidal_step)
advance_exactly, advance_trapezoidal_exactly = _make_advance(
    _step_exactly, _trapezoidal_step_exactly
)
