"""What a sensor can do to a signal: each mechanism in one file, for kernels and for simulated logs.

A mechanism says how it acts on one channel (its parameters), what the kernels and the linear
model take of it, and its form in plain numpy, which writes simulated logs.  Both draw from
the same distribution; ``tests/test_sensor_terms.py`` holds that over the list.
"""

from mcsim.sensor_terms.mechanisms.digitise import Quantisation, Saturation
from mcsim.sensor_terms.mechanisms.event import Event
from mcsim.sensor_terms.mechanisms.high_pass import HighPass
from mcsim.sensor_terms.mechanisms.low_pass import LowPass
from mcsim.sensor_terms.mechanisms.mixing import Coefficient, Source
from mcsim.sensor_terms.mechanisms.offset import Offset
from mcsim.sensor_terms.mechanisms.process import FirstOrder, Process, gauss_markov, random_walk
from mcsim.sensor_terms.mechanisms.resonance import Resonance
from mcsim.sensor_terms.mechanisms.shaped import Shaped
from mcsim.sensor_terms.mechanisms.white import White

__all__ = [
    "Coefficient",
    "Event",
    "FirstOrder",
    "HighPass",
    "LowPass",
    "Offset",
    "Process",
    "Quantisation",
    "Resonance",
    "Saturation",
    "Shaped",
    "Source",
    "White",
    "gauss_markov",
    "random_walk",
]
