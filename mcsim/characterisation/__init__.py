"""What a static log says about its sensor.

``characterise`` does it all; its parts serve on their own: ``allan_curve`` and
``fit_noise`` (Allan variance and coefficients), ``spectrum_of`` and ``find_lines``,
``smooth``, ``correlation_model``, ``track_bias``, ``kalman_rmse`` and ``mean_rmse`` (the
slowly varying bias).  Arrays and numbers are in SI units; N is Allan's, two-sided.
"""

from mcsim.characterisation.allan import AllanCurve, allan_curve
from mcsim.characterisation.analysis import Characterisation, Settings, characterise
from mcsim.characterisation.bias import (
    analyse_bias,
    correlation_model,
    kalman_rmse,
    mean_rmse,
    smooth,
    track_bias,
)
from mcsim.characterisation.fit import NoiseFit, fit_noise
from mcsim.characterisation.process import GaussMarkov
from mcsim.characterisation.spectrum import Spectrum, find_lines, spectrum_of

__all__ = [
    "AllanCurve",
    "Characterisation",
    "GaussMarkov",
    "NoiseFit",
    "Settings",
    "Spectrum",
    "allan_curve",
    "analyse_bias",
    "characterise",
    "correlation_model",
    "find_lines",
    "fit_noise",
    "kalman_rmse",
    "mean_rmse",
    "smooth",
    "spectrum_of",
    "track_bias",
]
