"""A shape of track and a statistic of your own: a road that winds, the mean size of errors.

mcsim run docs/examples/winding_road.yaml --with docs/examples/winding_road.py
"""

from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge

import mcsim


class Winding(mcsim.DrivenTrackBlock):
    """A sine across the road, in whole waves from a turning point on."""

    shape: Literal["winding"]
    amplitude: mcsim.fields.Length
    """How far it winds to either side."""
    wavelength: Annotated[mcsim.fields.Length, mcsim.fields.Positive]
    """Along the road."""
    waves: Annotated[int, Ge(1)] = 1
    """How many there are."""


def curve(block):
    k = 2.0 * np.pi / block.wavelength

    def evaluate(u):
        wave, slope = block.amplitude * np.cos(k * u), block.amplitude * np.sin(k * u)
        ones, zeros = np.ones_like(u), np.zeros_like(u)
        return mcsim.curves.Derivatives(u, -wave, ones, k * slope, zeros, k * k * wave)

    return mcsim.curves.ParametricCurve(evaluate, block.wavelength * np.arange(block.waves + 1.0))


def magnitude(errors):
    return np.mean(np.abs(errors), axis=-1)


mcsim.add(mcsim.Track("winding", Winding, mcsim.along(curve)))
mcsim.add(mcsim.Statistic("magnitude", "mean magnitude", magnitude, never_negative=True))
