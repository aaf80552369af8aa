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
def _keep(state, j, w, x, y, z, vl, vd, vh, pl, pd, ph):
    state[W + j], state[X + j], state[Y + j], state[Z + j] = w, x, y, z
    state[VL + j], state[VD + j], state[VH + j] = vl, vd, vh
    state[PL + j], state[PD + j], state[PH + j] = pl, pd, ph


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
            f = measured(f0, state[OFFSETS + j], sf * planar[row + j])
            g = measured(l0, state[OFFSETS + LANES + j], sl * planar[row + LANES + j])
            c = measured(c0, state[OFFSETS + 2 * LANES + j], sc * planar[row + 2 * LANES + j])
            h = measured(u0, state[OFFSETS + 3 * LANES + j], su * spatial[row + j])
            a = measured(a0, state[OFFSETS + 4 * LANES + j], sa * spatial[row + LANES + j])
            b = measured(b0, state[OFFSETS + 5 * LANES + j], sb * spatial[row + 2 * LANES + j])
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
            f = measured(f0, state[OFFSETS + j], sf * planar[row + j])
            g = measured(l0, state[OFFSETS + LANES + j], sl * planar[row + LANES + j])
            c = measured(c0, state[OFFSETS + 2 * LANES + j], sc * planar[row + 2 * LANES + j])
            h = measured(u0, state[OFFSETS + 3 * LANES + j], su * spatial[row + j])
            a = measured(a0, state[OFFSETS + 4 * LANES + j], sa * spatial[row + LANES + j])
            b = measured(b0, state[OFFSETS + 5 * LANES + j], sb * spatial[row + 2 * LANES + j])
            pf, pg = state[PREVIOUS + j], state[PREVIOUS + LANES + j]
            pc, pu = state[PREVIOUS + 2 * LANES + j], state[PREVIOUS + 3 * LANES + j]
            pa, pb = state[PREVIOUS + 4 * LANES + j], state[PREVIOUS + 5 * LANES + j]
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
            state[PREVIOUS + j], state[PREVIOUS + LANES + j] = f, g
            state[PREVIOUS + 2 * LANES + j], state[PREVIOUS + 3 * LANES + j] = c, h
            state[PREVIOUS + 4 * LANES + j], state[PREVIOUS + 5 * LANES + j] = a, b

    return advance


_rectangular_little, _, _ = _make_steps(increment_little)
_rectangular, _forward_euler, _trapezoidal = _make_steps(increment)
_rectangular_exactly, _forward_euler_exactly, _trapezoidal_exactly = _make_steps(increment_exactly)

advance_little = _make_advance_one_step(_rectangular_little)
advance = _make_advance_one_step(_rectangular)
advance_euler = _make_advance_one_step(_forward_euler)
advance_two_samples = _make_advance_two_samples(_trapezoidal)
# Rotations beyond the polynomials are rare; with the previous sample's weight at zero, these
# serve the integrators of one sample as well.
advance_exactly = _make_advance_two_samples(_rectangular_exactly)
advance_euler_exactly = _make_advance_two_samples(_forward_euler_exactly)
advance_two_samples_exactly = _make_advance_two_samples(_trapezoidal_exactly)
