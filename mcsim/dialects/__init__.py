"""Noise specifications in the dialects of data sheets, Allan analysis and other tools.

Every dialect is read into one description (SI, mcsim's keys) and written from it, so
that any converts to any other.  The trap that they share is a factor of √2: a data
sheet's noise density is one-sided, ``ND² fs / 2`` is the variance of one sample; the
white noise coefficient N of Allan analysis, and most tools' "noise density", belongs to a
two-sided density, ``N² fs``.  Each dialect says in ``convention`` which it means, and what
was established from.  What a dialect leaves open is asked, never guessed.
"""

from mcsim.dialects.description import Assumptions, Description, Reading, describe_file
from mcsim.dialects.registry import DIALECTS, Dialect, read_sensor, recognise, write_sensor

__all__ = [
    "DIALECTS",
    "Assumptions",
    "Description",
    "Dialect",
    "Reading",
    "describe_file",
    "read_sensor",
    "recognise",
    "write_sensor",
]
