"""Terms of a sensor's error model: one file each, and one line here.

A term says which keys scenarios and sensor files have for it and by which mechanism it acts
(``mcsim.sensor_terms.mechanisms``).  From this list follow the blocks and their schema, the
kernels' error terms, simulated logs, the linear model and the names in budgets.
"""

from mcsim.registry import Registry
from mcsim.sensor_terms import (
    bandwidth,
    bias_instability,
    g_sensitivity,
    gauss_markov,
    measuring_range,
    misalignment,
    miscalibration,
    noise,
    random_walk,
    resolution,
    scale_factor,
    spikes,
    turn_on_bias,
)
from mcsim.sensor_terms.term import Key, Term, check

#: In the order of the blocks' keys.
TERMS: Registry[Term] = Registry(
    "sensor term",
    (
        scale_factor.TERM,
        misalignment.TERM,
        bandwidth.TERM,
        noise.TERM,
        miscalibration.TERM,
        turn_on_bias.TERM,
        g_sensitivity.TERM,
        bias_instability.TERM,
        random_walk.TERM,
        gauss_markov.TERM,
        resolution.TERM,
        measuring_range.TERM,
        spikes.TERM,
    ),
)
for _term in TERMS.values():
    check(_term)
TERMS.tell(check)


def find_key(path: str, element: str) -> Key:
    """The key at a dotted path below an element's block, such as ``spikes.rate``.

    Raises
    ------
    KeyError
        No term has it.
    """
    return {own: key for term in TERMS.values() for own, key in term.paths(element)}[path]
