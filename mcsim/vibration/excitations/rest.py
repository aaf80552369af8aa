"""Nothing that shakes: what is left are the sensors' own noises."""

from __future__ import annotations

from typing import Literal

import numpy as np

from mcsim.vibration.excitations.excitation import Array, Excitation, ExcitationBlock


class Rest(ExcitationBlock):
    """A platform at rest."""

    shape: Literal["rest"]


def _acceleration(block: Rest, time: Array, _: float) -> Array:
    del block
    return np.zeros_like(time)


EXCITATION = Excitation("rest", Rest, _acceleration)
