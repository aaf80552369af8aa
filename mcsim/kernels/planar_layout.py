"""Where the planar kernel keeps what: constants of a realization, rows of the state."""

from __future__ import annotations

from mcsim.kernels.lanes import LANES

#: Rows of the result: along, across, position, heading, course.
ERRORS = 5
#: Rows of the linear errors: along, across, course, heading.
LINEAR_ERRORS = 4
#: Normals drawn once per realization.
N_CONSTANTS = 12
#: Row of the constants where the normals of sample 0 begin.
NOISE_0 = 8
# Constants of a realization (see ``lanes``): three miscalibrations, initial speed,
# direction, heading and course errors, one spare, then the noise of sample 0, which the
# trapezoidal rule uses and which coloured noise starts from, one spare; mixing coefficients.

# Rows of the state: heading vector, velocity, position, four linear errors, the
# previous sample's channels, half of the previous interval's turn, three offsets, and
# one for angles at the start and the end.
COS, SIN, VL, VD, PL, PD = (LANES * row for row in range(6))
LINEAR = LANES * 6
FORWARD, LEFT, YAW, HALF_TURN = (LANES * row for row in range(10, 14))
OFFSETS = LANES * 14
COURSE = LANES * 17
N_STATE = LANES * 18

#: Rows of a recorded history: along, across, velocity along, velocity across, heading.
HISTORY_ROWS = 5
