"""imu_utils' result files: read, never written, since their numbers do not say what they are.

``*_n`` is the Allan deviation at 1 s, Allan's N, in some published results, and the deviation
of one sample (N √rate) in others; ``*_w`` is documented as a bias instability, used as Kalibr's
random walk, and computed as the least Allan deviation.
"""

from __future__ import annotations

import math

from mcsim.dialects.description import (
    AXES,
    BIAS_WALK,
    RANDOM_WALK,
    Assumptions,
    Description,
    Reading,
    Values,
)
from mcsim.dialects.foreign import plain_numbers, required
from mcsim.scenario.document import parse_document

CONVENTION = "n is Allan's N or N √rate, w the least Allan deviation or something else: say which"
#: Floor of the Allan deviation of flicker noise over B: √(2 ln 2 / π).
FLOOR = math.sqrt(2.0 * math.log(2.0) / math.pi)
_SECTIONS = {"accelerometer": ("Acc", "acc"), "gyroscope": ("Gyr", "gyr")}
_N = {
    "continuous": "Allan's N, the Allan deviation at 1 s",
    "per_sample": "the deviation of one sample, N √rate (needs --rate)",
}
_W = {
    "allan_minimum": "the least Allan deviation, 0.664 B (what the program computes)",
    "bias_instability": "B itself",
    "random_walk": "Allan's K",
    "ignore": "leave it out",
}


def read(text: str, source: str, assumptions: Assumptions) -> Reading:
    """A ``*_imu_param.yaml``, axis by axis.

    Raises
    ------
    InputError
        A number is missing, or one of the questions was not answered.
    """
    if text.startswith("%YAML"):  # OpenCV's head, which is no YAML
        text = "#" + text[1:].replace("---", "", 1)
    document = parse_document(text, source)
    white = assumptions.answer("n", f"{source}: gyr_n and acc_n mean one of two things", _N)
    drift = assumptions.answer("w", f"{source}: gyr_w and acc_w mean one of several things", _W)
    scale = 1.0
    if white == "per_sample":
        rate = assumptions.required_rate("the deviation of one sample depends on the rate")
        scale = 1.0 / math.sqrt(rate)
    elements: dict[str, dict[str, Values]] = {}
    for element, (section, prefix) in _SECTIONS.items():
        n, w = (
            tuple(
                plain_numbers(*required(document, (section, f"{axis}-axis", f"{prefix}_{name}")))[0]
                for axis in AXES
            )
            for name in ("n", "w")
        )
        elements[element] = {RANDOM_WALK[element]: tuple(scale * value for value in n)}
        if drift == "random_walk":
            elements[element][BIAS_WALK[element]] = w
        elif drift != "ignore":
            floor = FLOOR if drift == "allan_minimum" else 1.0
            elements[element]["bias_instability"] = tuple(value / floor for value in w)
    name = document.tree.get("name")
    return Reading(Description(str(name) if name else None, assumptions.rate, elements))
