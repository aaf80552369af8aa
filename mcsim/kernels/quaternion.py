"""Unit quaternions (w, x, y, z): attitudes turned by small rotation vectors, without trigonometry.

An attitude rotates from the body to the level frame.  A rotation vector (a, b, c) about the
body's axes becomes an increment (d, a', b', c'), the quaternion (1 + d, a', b', c'): what is
added to 1 is kept apart, so that little turns lose no digits.
"""

from __future__ import annotations

import math

from mcsim.kernels.compilation import scalar

#: Largest rotation per step (rad) that the two polynomials are used for: their unit length
#: errs by less than 2e-15 and 3e-13 there.
LITTLE_ROTATION, LARGEST_ROTATION = 0.02, 0.5
#: Below this cosine of the pitch, roll and heading are one rotation: see ``euler_angles``.
LOCKED = 1e-6


@scalar
def increment_little(a, b, c):
    """Increment of a rotation vector: Taylor series in the half angle to the 4th order."""
    q = 0.25 * (a * a + b * b + c * c)
    s = 0.5 + q * (-1 / 12 + q * (1 / 240))
    return q * (-1 / 2 + q * (1 / 24)), s * a, s * b, s * c


@scalar
def increment(a, b, c):
    """Increment of a rotation vector: Taylor series in the half angle to the 8th order."""
    q = 0.25 * (a * a + b * b + c * c)
    s = 0.5 + q * (-1 / 12 + q * (1 / 240 + q * (-1 / 10080 + q * (1 / 725760))))
    d = q * (-1 / 2 + q * (1 / 24 + q * (-1 / 720 + q * (1 / 40320))))
    return d, s * a, s * b, s * c


@scalar
def increment_exactly(a, b, c):
    """Increment of a rotation vector of any size."""
    half = 0.5 * math.sqrt(a * a + b * b + c * c)
    s = 0.5 * math.sin(half) / half if half > 0.0 else 0.5
    return math.cos(half) - 1.0, s * a, s * b, s * c


@scalar
def compose(w, x, y, z, d, a, b, c):
    """The attitude turned about its own axes by an increment: the product q (1 + d, a, b, c)."""
    return (
        w + (w * d - x * a - y * b - z * c),
        x + (x * d + w * a + y * c - z * b),
        y + (y * d + w * b + z * a - x * c),
        z + (z * d + w * c + x * b - y * a),
    )


@scalar
def rotate(w, x, y, z, f, g, h):
    """A body vector (f, g, h) in the level frame: q v q*."""
    tx = 2.0 * (y * h - z * g)
    ty = 2.0 * (z * f - x * h)
    tz = 2.0 * (x * g - y * f)
    return (
        f + w * tx + (y * tz - z * ty),
        g + w * ty + (z * tx - x * tz),
        h + w * tz + (x * ty - y * tx),
    )


@scalar
def cross(a, b, c, f, g, h):
    """Vector product of (a, b, c) and (f, g, h)."""
    return b * h - c * g, c * f - a * h, a * g - b * f


@scalar
def attitude(roll, pitch, heading):
    """The attitude of Euler angles (rad): turned by the heading, then the pitch, then the roll."""
    cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    ch, sh = math.cos(0.5 * heading), math.sin(0.5 * heading)
    return (
        cr * cp * ch + sr * sp * sh,
        sr * cp * ch - cr * sp * sh,
        cr * sp * ch + sr * cp * sh,
        cr * cp * sh - sr * sp * ch,
    )


@scalar
def euler_angles(w, x, y, z):
    """Roll, pitch, heading (rad) of an attitude; at a pitch of ±90° the roll is zero."""
    c, s = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)
    upwards, level = 2.0 * (x * z - w * y), math.sqrt(c * c + s * s)
    if level < LOCKED:
        heading = math.atan2(2.0 * (w * z - x * y), 1.0 - 2.0 * (x * x + z * z))
        return 0.0, math.atan2(-upwards, 0.0), heading
    roll = math.atan2(2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))
    return roll, math.atan2(-upwards, level), math.atan2(s, c)
