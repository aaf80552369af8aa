"""Rules of integration that scenarios may name: ours, and those that a user adds."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, Field

from mcsim.registry import suggest
from mcsim.scenario.fields import reject

#: Our own rules by case, the default first.
SHIPPED = {
    "planar": ("rectangular", "trapezoidal"),
    "strapdown": ("rectangular", "forward_euler", "trapezoidal", "two_sample"),
}
_ADDED: dict[str, list[str]] = {case: [] for case in SHIPPED}


def known(case: str) -> tuple[str, ...]:
    """All rules of a case."""
    return (*SHIPPED[case], *_ADDED[case])


def add(case: str, name: str) -> None:
    """Let scenarios of a case name one more rule."""
    if name not in known(case):
        _ADDED[case].append(name)


def _checked(case: str) -> AfterValidator:
    def check(name: str) -> str:
        names = known(case)
        if name not in names:
            raise reject(f'"{name}" is not one of {", ".join(names)}{suggest(name, names)}')
        return name

    return AfterValidator(check)


def _listed(case: str) -> Any:
    return Field(json_schema_extra={"enum": list(SHIPPED[case])})


PlanarRule = Annotated[str, _checked("planar"), _listed("planar")]
StrapdownRule = Annotated[str, _checked("strapdown"), _listed("strapdown")]
