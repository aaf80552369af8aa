"""Velocity by integration of a tri-axial accelerometer: groups of runs as a system of the frame.

A group is a realization: what is drawn once (calibration, rest phase, tilt, gravity) belongs to
all its runs, noise and time errors to every step of every run.  Its legs are the runs and, where
every sample is measured, the rest before them: in-run noise then goes on without a pause from the
first sample of the rest to the last one of the last run.

The corrected, tilt-corrected acceleration is linear in the raw output,

    aX = kx (rx - Bx) + ky (ry - By) + kz (rz - Bz),    k = (p lx. - q lz.) g,

with p, q from the tilt: Eq. (15) has p = 1 and q = theta.  So a group needs four numbers
only, and a step eight multiplications.

The linear error of a run needs one weight per normal for all the instants it is asked at: from
one instant to the next a normal acts by its own segment's weights, and what it has left in
the processes acts as their states, weighed where a segment begins.
"""

from __future__ import annotations

import math

import numpy as np

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lane_loops import row_of
from mcsim.kernels.lanes import LANES, NORMALS, WHITE_NOISE, draw_constants, draw_group, seed_lanes
from mcsim.kernels.parts import loader, of, take
from mcsim.kernels.system import (
    add_linear,
    begin,
    draw_once,
    enter,
    finish,
    finish_linear,
    keep,
    leg,
    legs,
    outcome,
    record,
    rows_of,
    seed,
    start_linear,
)
from mcsim.kernels.velocity_system import (
    EXACT,
    PER_INSTANT,
    REST,
    REST_NOISE,
    RUN,
    SECOND_ORDER,
    Inputs,
    Resting,
    Velocity,
)

#: Normals that a sample takes of a draw: of three axes, and in a run of the interval.
_AT_REST, _IN_RUN = 3, 4
#: Beyond the number of any instant.
_NONE = 1 << 40

_SPEED, _STAMP, _K0, _KX, _KY, _KZ, _SUM_X, _SUM_Y, _SUM_Z = (
    LANES * row for row in range(len(Resting._fields))
)
_, _LINEAR, _REST_LINEAR, _ = rows_of(Velocity)
_LINEAR_STAMP = _REST_LINEAR + 3 * LANES
_load_normals = loader(Inputs)
_INPUT_ROWS = -(-len(Inputs._fields) // 4) * 4


def drawn_rows(measured: bool, mixing: int) -> int:
    """Rows of what a group draws once, with ``mixing`` coefficients; a multiple of four."""
    return -(-(Velocity.CONSTANTS + mixing) // 4) * 4 if measured else _INPUT_ROWS


@of(draw_once, Velocity)
def _draw_once(system, key, first, rows, constants):
    draw_constants(key, first, rows if system.at_rest > 0 else _INPUT_ROWS, constants)


@scalar
def _drawn(system, constants, j):
    """Inputs as lane ``j`` has drawn them."""
    estimate, u, z = system.inputs, system.deviations, _load_normals(constants, j)
    return Inputs(
        estimate.lxx + u.lxx * np.float64(z.lxx),
        estimate.lxy + u.lxy * np.float64(z.lxy),
        estimate.lxz + u.lxz * np.float64(z.lxz),
        estimate.lzx + u.lzx * np.float64(z.lzx),
        estimate.lzy + u.lzy * np.float64(z.lzy),
        estimate.lzz + u.lzz * np.float64(z.lzz),
        estimate.bx + u.bx * np.float64(z.bx),
        estimate.by + u.by * np.float64(z.by),
        estimate.bz + u.bz * np.float64(z.bz),
        estimate.rest_x + u.rest_x * np.float64(z.rest_x),
        estimate.rest_y + u.rest_y * np.float64(z.rest_y),
        estimate.rest_z + u.rest_z * np.float64(z.rest_z),
        estimate.tilt + u.tilt * np.float64(z.tilt),
        estimate.gravity + u.gravity * np.float64(z.gravity),
    )


@scalar
def _mean_at_rest(system, drawn, rows, j):
    """Mean raw output at rest: measured, or drawn."""
    if system.at_rest > 0:
        samples = system.at_rest
        return rows[_SUM_X + j] / samples, rows[_SUM_Y + j] / samples, rows[_SUM_Z + j] / samples
    return drawn.rest_x, drawn.rest_y, drawn.rest_z


@scalar
def tilt_factors(theta, order):
    """p and q in aX = (p acx - q acz) g."""
    if order == EXACT:
        return math.cos(theta), math.sin(theta)
    if order == SECOND_ORDER:
        return 1.0 / (1.0 + theta * theta), theta / (1.0 + theta * theta)
    return 1.0, theta


@scalar
def _product(a, b, c, x, y, z):
    """A row of the calibration matrix times a vector."""
    total = 0.0
    total += a * x
    total += b * y
    total += c * z
    return total


@scalar
def _start_group(system, constants, rows):
    """The four numbers of each lane, Eq. (4), (5), (15), (19), (20)."""
    for j in range(LANES):
        d = _drawn(system, constants, j)
        rx, ry, rz = _mean_at_rest(system, d, rows, j)
        rx, ry, rz = rx - d.bx, ry - d.by, rz - d.bz
        x = _product(d.lxx, d.lxy, d.lxz, rx, ry, rz)
        z = _product(d.lzx, d.lzy, d.lzz, rx, ry, rz)
        p, q = tilt_factors(math.atan2(x, z) + d.tilt, system.order)
        kx = (p * d.lxx - q * d.lzx) * d.gravity
        ky = (p * d.lxy - q * d.lzy) * d.gravity
        kz = (p * d.lxz - q * d.lzz) * d.gravity
        rows[_K0 + j] = -_product(kx, ky, kz, d.bx, d.by, d.bz)
        rows[_KX + j] = kx
        rows[_KY + j] = ky
        rows[_KZ + j] = kz


@of(begin, Velocity)
def _begin(system, constants, sensors, scratch, rows):
    """Nothing is measured yet; the state begins with the first run."""
    for j in range(3 * LANES):
        rows[_SUM_X + j] = 0.0


@of(keep, Velocity)
def _keep(system, constants, measured, rows):
    """Nothing: no sample is before the first one."""


@scalar
def _run_of(system, number):
    """Number of the run that a leg is; the rest is -1."""
    return number - 1 if system.at_rest > 0 else number


@of(legs, Velocity)
def _legs(system):
    return system.runs + 1 if system.at_rest > 0 else system.runs


@of(leg, Velocity)
def _leg(system, number, n):
    """Where only noise disturbs them, all runs have the same rows of signals."""
    run, rest, samples = _run_of(system, number), system.at_rest, system.samples
    if run < 0:
        return REST, -1, rest, _AT_REST, _NONE
    return RUN, rest - 1 + run * samples if rest > 0 else 0, samples, _IN_RUN, 0


@of(seed, Velocity)
def _seed(system, number, key, first, streams, normals):
    """Noise goes on from run to run; a first stamp is drawn by itself."""
    run = _run_of(system, number)
    if run <= 0:
        seed_lanes(key, first, REST_NOISE if run < 0 else WHITE_NOISE, streams)
    if run >= 0 and system.difference != 0.0:
        draw_group(streams, normals)


@of(enter, Velocity)
def _enter(system, number, constants, normals, rows):
    """Standstill; the first of the normals is the first stamp's, if stamps err."""
    run = _run_of(system, number)
    if run == 0:
        _start_group(system, constants, rows)
    for j in range(LANES):
        stamp = np.float64(normals[j]) if system.difference != 0.0 else 0.0
        rows[_SPEED + j] = 0.0
        rows[_STAMP + j] = stamp
        rows[_LINEAR + j] = 0.0
        rows[_LINEAR_STAMP + j] = stamp


@of(start_linear, Velocity)
def _start_linear(system, constants, weights, rows):
    for j in range(3 * LANES):
        rows[_REST_LINEAR + j] = 0.0


@scalar
def _add_rest(i, row, normals, weights, rows):
    """Add a sample at rest to the linear errors of the means."""
    for axis in range(3):
        weight = weights[i, axis]
        own, drawn = row_of(rows, _REST_LINEAR // LANES + axis), row_of(normals, row + axis)
        for j in range(LANES):
            own[j] += weight * np.float64(drawn[j])


@scalar
def _add_rest_of_four(i, normals, samples, rows):
    """The same for all samples that a draw serves."""
    first, second, third, fourth = samples[i], samples[i + 1], samples[i + 2], samples[i + 3]
    for axis in range(3):
        a, b, c, d = first[axis], second[axis], third[axis], fourth[axis]
        own = row_of(rows, _REST_LINEAR // LANES + axis)
        w, x = row_of(normals, axis), row_of(normals, _AT_REST + axis)
        y, z = row_of(normals, 2 * _AT_REST + axis), row_of(normals, 3 * _AT_REST + axis)
        for j in range(LANES):
            total = own[j]
            total += a * np.float64(w[j])
            total += b * np.float64(x[j])
            total += c * np.float64(y[j])
            total += d * np.float64(z[j])
            own[j] = total


@scalar
def _share(system, weights, x, y, z, interval, before):
    """A step's share of the linear error; ``before`` is the last stamp's normal."""
    a, b, c, d = weights
    return a * x + b * y + c * z + d * (interval - system.difference * before)


@scalar
def _weights(samples, i):
    return samples[i, 0], samples[i, 1], samples[i, 2], samples[i, 3]


@scalar
def _add_one(system, i, row, normals, samples, rows):
    """Add a step's share to the linear error of a run."""
    weights = _weights(samples, i)
    x, y = row_of(normals, row), row_of(normals, row + 1)
    z, interval = row_of(normals, row + 2), row_of(normals, row + 3)
    for j in range(LANES):
        e = np.float64(interval[j])
        rows[_LINEAR + j] += _share(system, weights, x[j], y[j], z[j], e, rows[_LINEAR_STAMP + j])
        rows[_LINEAR_STAMP + j] = e


@scalar
def _add_three(system, i, normals, samples, rows):
    """The same for all steps that a draw serves."""
    first, second, third = _weights(samples, i), _weights(samples, i + 1), _weights(samples, i + 2)
    for j in range(LANES):
        x0, y0, z0, e0, x1, y1, z1, e1, x2, y2, z2, e2 = take(normals, j, NORMALS)
        a, b, c = np.float64(e0), np.float64(e1), np.float64(e2)
        total = rows[_LINEAR + j]
        total += _share(system, first, x0, y0, z0, a, rows[_LINEAR_STAMP + j])
        total += _share(system, second, x1, y1, z1, b, a)
        total += _share(system, third, x2, y2, z2, c, b)
        rows[_LINEAR + j] = total
        rows[_LINEAR_STAMP + j] = c


@of(add_linear, Velocity)
def _add_linear(system, way, i, k, until, normals, weights, rows):
    if way == REST and _AT_REST * (until - k) == NORMALS:
        _add_rest_of_four(i, normals, weights, rows)
    elif way == REST:
        for sample in range(k, until):
            _add_rest(i + sample, _AT_REST * sample, normals, weights, rows)
    elif _IN_RUN * (until - k) == NORMALS:
        _add_three(system, i, normals, weights, rows)
    else:
        for sample in range(k, until):
            _add_one(system, i + sample, _IN_RUN * sample, normals, weights, rows)


@scalar
def _gather(run, value, start, filled, results):
    """Rows of the results: first run; then of the others, as differences to the first, sum and
    sum of squares, so that none of the digits is lost."""
    first, sums, squares = results[0], results[1], results[2]
    for j in range(filled):
        if run == 0:
            first[start + j] = value[j]
            sums[start + j] = 0.0
            squares[start + j] = 0.0
        else:
            more = value[j] - first[start + j]
            sums[start + j] += more
            squares[start + j] += more * more


@of(record, Velocity)
def _record(system, number, asked, start, filled, rows, errors, linear, history):
    run, row = _run_of(system, number), PER_INSTANT * asked
    if run >= 0:
        _gather(run, row_of(rows, _SPEED // LANES), start, filled, errors[row : row + PER_INSTANT])
        if linear.shape[1] > 0:
            own = row_of(rows, _LINEAR // LANES)
            _gather(run, own, start, filled, linear[row : row + PER_INSTANT])
        if history.shape[0] > 0:
            for j in range(filled):
                history[asked, run, start + j] = rows[_SPEED + j]


@of(finish, Velocity)
def _finish(system, rows, start, filled, errors):
    """Velocities of the first run and mean of all, and their scatter, at every instant."""
    runs = system.runs
    for row in range(0, len(errors), PER_INSTANT):
        for j in range(start, start + filled):
            mean = errors[row + 1, j] / runs
            spread = errors[row + 2, j] - runs * mean * mean
            errors[row + 1, j] = errors[row, j] + mean
            errors[row + 2, j] = math.sqrt(max(spread, 0.0) / (runs - 1)) if runs > 1 else 0.0


@scalar
def _add_constants(weights, constants, own):
    """Add the linear error that what is drawn once makes."""
    for k in range(len(weights)):
        weight, drawn = weights[k], row_of(constants, k)
        for j in range(LANES):
            own[j] += weight * np.float64(drawn[j])


@of(finish_linear, Velocity)
def _finish_linear(system, constants, weights, start, filled, rows, linear):
    """Linear errors of the same; there is none of the scatter."""
    own, rest = row_of(rows, _LINEAR // LANES), rows[_REST_LINEAR:]
    for instant in range(len(linear) // PER_INSTANT):
        own[:] = 0.0
        _add_constants(weights.constants[instant], constants, own)
        if weights.rest.shape[0] > 0:
            for axis in range(3):
                weight, mean = weights.rest[instant, axis], row_of(rest, axis)
                for j in range(LANES):
                    own[j] += weight * mean[j]
        row = PER_INSTANT * instant
        for j in range(filled):
            common = own[j] + linear[row, start + j]
            linear[row, start + j] = common
            linear[row + 1, start + j] = common + linear[row + 1, start + j] / system.runs
            linear[row + 2, start + j] = 0.0


@of(outcome, Velocity)
def _outcome(system, rows, errors):
    for j in range(LANES):
        errors[0, j] = rows[_SPEED + j]
