"""Allan analysis: plan a test, curves of theory, densities and their deviations; ``mcsim allan``.

``plan`` says how long a sensor must be logged, ``curves`` what theory says of its terms,
``from_density`` and ``to_density`` go by Eq. (3.12) of the thesis, ``deviations`` are modified,
Hadamard and total deviation of a log.
"""

from mcsim.api.allan.curves import AllanCurves, curves
from mcsim.api.allan.density import AllanOfDensity, from_density
from mcsim.api.allan.deviations import AllanDeviations, deviations
from mcsim.api.allan.plan import AllanPlan, plan
from mcsim.api.allan.terms_density import DensityOfTerms, to_density

__all__ = [
    "AllanCurves",
    "AllanDeviations",
    "AllanOfDensity",
    "AllanPlan",
    "DensityOfTerms",
    "curves",
    "deviations",
    "from_density",
    "plan",
    "to_density",
]
