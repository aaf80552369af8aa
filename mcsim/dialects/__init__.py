"""Noise specifications in the dialects of data sheets, Allan analysis and other tools.

Every dialect is read into one description (SI, mcsim's keys) and written from it, so
that any converts to any other.  The trap that they share is a factor of √2: a data
sheet's noise density is one-sided, ``ND² fs / 2`` is the variance of one sample; the
white noise coefficient N of Allan analysis, and most tools' "noise density", belongs to a
two-sided density, ``N² fs``.  Each dialect says in ``convention`` which it means, and what
was established from.  What a dialect leaves open is asked, never guessed; what its reader
does not understand is named, never passed over.
"""

from mcsim.dialects.description import Assumptions, Description, Reading, describe_file, two_sided
from mcsim.dialects.dialect import Dialect
from mcsim.dialects.foreign import without_words
from mcsim.dialects.registry import (
    DIALECTS,
    endings,
    read_file,
    read_sensor,
    readable,
    recognise,
    writable,
    write_sensor,
)
from mcsim.dialects.terms import Term

__all__ = [
    "DIALECTS",
    "Assumptions",
    "Description",
    "Dialect",
    "Reading",
    "Term",
    "describe_file",
    "endings",
    "read_file",
    "read_sensor",
    "readable",
    "recognise",
    "two_sided",
    "without_words",
    "writable",
    "write_sensor",
]
