"""What a sensor can do to a signal: each mechanism in one file, for kernels and for simulated logs.

A mechanism says how it acts on one channel (its parameters), what the kernels and the linear
model take of it, and its form in plain numpy, which writes simulated logs.  Both draw from
the same distribution; ``tests/test_sensor_terms.py`` holds that over the list.
"""
