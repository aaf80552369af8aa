"""Terms of a sensor's error model: one file each, and one line here.

A term says which keys scenarios and sensor files have for it and by which mechanism it acts
(``mcsim.sensor_terms.mechanisms``).  From this list follow the blocks and their schema, the
kernels' error terms, simulated logs, the linear model and the names in budgets.
"""

from mcsim.errors import InputError
from mcsim.registry import Registry
from mcsim.sensor_terms import (
    ac_coupling,
    asymmetry,
    bandwidth,
    bias_instability,
    g_sensitivity,
    gauss_markov,
    measuring_range,
    misalignment,
    miscalibration,
    noise,
    nonlinearity,
    random_walk,
    resolution,
    resonance,
    scale_factor,
    spikes,
    temperature,
    turn_on_bias,
)
from mcsim.sensor_terms.channel import SIGNALS
from mcsim.sensor_terms.term import SensorKey, SensorTerm, check

#: In the order of the blocks' keys.
TERMS: Registry[SensorTerm] = Registry(
    "sensor term",
    (
        scale_factor.TERM,
        asymmetry.TERM,
        nonlinearity.SECOND_ORDER,
        nonlinearity.THIRD_ORDER,
        misalignment.TERM,
        resonance.TERM,
        ac_coupling.TERM,
        bandwidth.TERM,
        noise.TERM,
        miscalibration.TERM,
        turn_on_bias.TERM,
        g_sensitivity.TERM,
        *temperature.TERMS,
        bias_instability.TERM,
        random_walk.TERM,
        gauss_markov.TERM,
        resolution.TERM,
        measuring_range.TERM,
        spikes.TERM,
    ),
)
#: What stands in an element's block, or in its place in a sensor file, beside its terms.
RESERVED = ("model", "rate", "axes", "data_sheet", "measured")


def _refuse_taken(term: SensorTerm) -> None:
    """Refuse a term with a key that blocks have already."""
    for element in SIGNALS:
        taken = {path.partition(".")[0] for path in _keys(element)}.union(RESERVED)
        for name in (path.partition(".")[0] for path, _ in term.paths(element)):
            if name in taken:
                raise InputError(f"{term.name}: the {element} has a key `{name}` already")


def _keys(element: str) -> dict[str, SensorKey]:
    return {path: key for term in TERMS.values() for path, key in term.paths(element)}


TERMS.tell(check)
TERMS.tell(_refuse_taken)


def find_key(path: str, element: str) -> SensorKey:
    """The key at a dotted path below an element's block, such as ``spikes.rate``.

    Raises
    ------
    KeyError
        No term has it.
    """
    return _keys(element)[path]
