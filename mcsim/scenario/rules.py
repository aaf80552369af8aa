"""Rules of integration that scenarios may name: ours, and those that a user adds."""

from __future__ import annotations

from typing import Any

from pydantic import AfterValidator, Field

from mcsim.registry import suggest
from mcsim.scenario.fields import reject


class Rules:
    """The rules of one case, the default first."""

    def __init__(self, *shipped: str) -> None:
        self.shipped = shipped
        self._added: list[str] = []

    @property
    def known(self) -> tuple[str, ...]:
        """All rules."""
        return (*self.shipped, *self._added)

    def add(self, name: str) -> None:
        """Let scenarios name one more."""
        if name not in self.known:
            self._added.append(name)

    def checked(self) -> AfterValidator:
        """Refuses names that no rule has."""

        def check(name: str) -> str:
            if name not in self.known:
                raise reject(
                    f'"{name}" is not one of {", ".join(self.known)}{suggest(name, self.known)}'
                )
            return name

        return AfterValidator(check)

    def listed(self) -> Any:
        """Names the shipped rules in the JSON schema."""
        return Field(json_schema_extra={"enum": list(self.shipped)})
