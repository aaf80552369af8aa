"""A sensor term of your own: a bias that is another at each run, and axes that show in others.

mcsim run docs/examples/run_to_run_bias.yaml --with docs/examples/run_to_run_bias.py
"""

import mcsim
from mcsim import mechanisms


def cross_axis(share):
    """Each other axis of the element shows by a share of its own."""
    return mechanisms.Coefficient(share, mechanisms.Source.OTHER_AXES)


BIAS = mcsim.SensorKey(
    "run_to_run_bias",
    "{signal}",  # an acceleration or an angular rate
    "Standard deviation of the bias drawn at each run.",
    role="deviation",  # of mechanisms.Offset
)
SHARE = mcsim.SensorKey(
    "cross_axis_sensitivity",
    "ratio",
    "Standard deviation of what each other axis adds.",
    role="share",
)

mcsim.add(mcsim.SensorTerm("run-to-run bias", mechanisms.Offset, (BIAS,), (BIAS,)))
mcsim.add(mcsim.SensorTerm("cross-axis sensitivity", cross_axis, accelerometer=(SHARE,)))
