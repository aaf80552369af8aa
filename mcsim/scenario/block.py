"""The base of all blocks of a scenario."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, BeforeValidator, ConfigDict

from mcsim.scenario.fields import reject


class Block(BaseModel):
    """Base of all blocks: unknown keys are errors, values never change."""

    # Models are built when first used: a run uses those of one case.
    model_config = ConfigDict(
        extra="forbid", frozen=True, use_attribute_docstrings=True, defer_build=True
    )


def _no_boolean(value: Any) -> Any:
    if isinstance(value, bool):
        raise reject(f"a whole number is needed here, not {str(value).lower()}")
    return value


Whole = BeforeValidator(_no_boolean)
