"""How a vehicle's body answers acceleration: a block that several cases have."""

from __future__ import annotations

from typing import Annotated, Any

from annotated_types import Ge, Le
from pydantic import model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.fields import AngleGradient, Frequency, NotNegative, Ratio, reject
from mcsim.scenario.idle import IdleKey


class Response(Block):
    """How the body turns about one axis under acceleration: a gradient and its dynamics."""

    gradient: Annotated[AngleGradient, NotNegative] = 0.0
    """Steady angle per acceleration, as sheets give it."""
    natural_frequency: Annotated[Frequency, Ge(0.0), Le(50.0)] = 1.5
    """Undamped natural frequency; zero for an angle that follows the acceleration at once."""
    damping: Annotated[Ratio, Ge(0.05), Le(2.0)] = 0.3
    """Damping as a share of the critical one, `30 %`."""

    @model_validator(mode="after")
    def _frequency_is_sane(self) -> Response:
        if 0.0 < self.natural_frequency < 0.05:
            raise reject("natural_frequency must be 0 Hz (at once) or at least 0.05 Hz")
        return self


def idle_response(path: str) -> tuple[IdleKey, ...]:
    """The keys without effect of a response at ``path``, such as ``body.roll``."""

    def response(model: Any) -> Any:
        for key in path.split("."):
            model = getattr(model, key)
        return model

    def stiff(model: Any) -> bool:
        return bool(response(model).gradient == 0.0)

    def at_once(model: Any) -> bool:
        return response(model).natural_frequency == 0.0 and not stiff(model)

    deciding = (f"{path}.gradient", f"{path}.natural_frequency")
    no_lean = f"`{path}.gradient` is zero: the body does not lean"
    follows = f"`{path}.natural_frequency` is zero: the body follows at once"
    return (
        IdleKey(f"{path}.natural_frequency", deciding, stiff, no_lean),
        IdleKey(f"{path}.damping", deciding, stiff, no_lean),
        IdleKey(f"{path}.damping", deciding, at_once, follows),
    )
