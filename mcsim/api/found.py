"""What the functions of ``mcsim`` return has in common: it can be written into a folder."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path

from mcsim.report import Report


class Found(ABC):
    """What a function found out."""

    @abstractmethod
    def report(self) -> Report:
        """Its tables, pictures and texts, with where they come from; pictures are drawn."""

    def write(self, folder: str | Path) -> list[Path]:
        """Write the report into ``folder``; the files.

        Raises
        ------
        InputError
            The folder cannot be written; nothing is then replaced.
        """
        return self.report().write(Path(folder))
