"""Where the strapdown kernel keeps what: channels, constants of a realization, rows of the state.

Channels are ordered forward, left, yaw turn (those of the planar kernel), then up, roll turn,
pitch turn; turns are rates times sampling interval.
"""

from __future__ import annotations

from mcsim.kernels.lanes import LANES

CHANNELS = 6
RECTANGULAR, FORWARD_EULER, TRAPEZOIDAL, TWO_SAMPLE = range(4)
#: Streams of the channels and constants that the planar case does not have.
SPATIAL_NOISE, SPATIAL_CONSTANTS, MIXING_CONSTANTS = 16, 17, 18
#: Rows of the result: along, across, height, position, roll, pitch, heading, course.
ERRORS = 8
#: Rows of the linear errors: along, across, height, course, roll, pitch, heading.
LINEAR_ERRORS = 7
OF_ALL_CHANNELS = 4
TURNS = (2, 4, 5)
#: Whether a channel is one of specific force.
FORCE = (True, True, False, True, False, False)
#: Weights per sample: four errors of six channels, three attitude errors of three turns.
WEIGHTS = CHANNELS * OF_ALL_CHANNELS + 3 * len(TURNS)
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
W, X, Y, Z = (LANES * row for row in range(4))
VL, VD, VH = (LANES * row for row in range(4, 7))
PL, PD, PH = (LANES * row for row in range(7, 10))
OFFSETS = LANES * 10
PREVIOUS = LANES * 16
LINEAR = LANES * 22
A, B, C, D, E, F, G, H = (LANES * row for row in range(29, 37))
N_STATE = LANES * 37

#: Below this cosine of the pitch, roll and heading are one rotation: see ``euler_angles``.
LOCKED = 1e-6
