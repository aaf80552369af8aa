"""The one writer: tables, pictures, texts and provenance of a command, in one folder."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.provenance import MARKS, PROVENANCE, mark_of
from mcsim.writing import (
    Writer,
    csv_writer,
    parquet_writer,
    readable_errors,
    remove_stale,
    text_writer,
    written_beside,
)

if TYPE_CHECKING:
    import pandas as pd

_OF_TABLES, _OF_PICTURES = ("csv", "parquet"), ("png", "svg")
#: How tables are written whose digits beyond these say nothing.
_NINE_DIGITS = "%.9g"


@dataclass(frozen=True)
class Report:
    """Everything that a command writes into a folder.

    Attributes
    ----------
    provenance : mapping
        Where it comes from (``mcsim.provenance``); digests of the tables are added.
    tables : mapping
        By the names of their files, without ending.
    pictures : mapping
        By the names of their files, what writes each of them (``mcsim.figures.style.printed``).
    texts : mapping
        By the names of their files.
    formats : tuple of str
        Of the tables: ``csv``, ``parquet``.
    nine_digits : collection of str
        Tables whose floats are rounded to nine digits; those of others are exact.
    obsolete : collection of str
        Tables and pictures, without ending, that an earlier command may have left and that would
        not belong to this one: removed where this one does not write them.
    """

    provenance: Mapping[str, Any]
    tables: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    pictures: Mapping[str, Writer] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)
    formats: tuple[str, ...] = ("csv",)
    nine_digits: Collection[str] = ()
    obsolete: Collection[str] = ()

    def write(self, folder: Path) -> list[Path]:
        """Write it; the files, the provenance last.

        Nothing is replaced unless everything could be written.  Then files that do not belong to
        it go, and the new ones are moved into place: the provenance comes last, so that what is
        stopped in between is not taken for whole.

        Raises
        ------
        InputError
            The folder cannot be written.
        """
        with readable_errors(folder), ExitStack() as stack:
            folder.mkdir(parents=True, exist_ok=True)

            def beside(name: str, write: Writer) -> Path:
                return stack.enter_context(written_beside(folder / name, write))

            tables = {name: beside(name, write) for name, write in self._tables()}
            marks = {name: mark_of(file.read_bytes()) for name, file in tables.items()}
            texts = {name: text_writer(text) for name, text in self.texts.items()}
            others = {n: beside(n, write) for n, write in {**self.pictures, **texts}.items()}
            provenance = {**self.provenance, **({MARKS: marks} if marks else {})}
            told = text_writer(json.dumps(provenance, indent=2, ensure_ascii=False) + "\n")
            files = {**tables, **others, PROVENANCE: beside(PROVENANCE, told)}
            for file in self._obsolete(folder):
                if file.name not in files:
                    file.unlink(missing_ok=True)
                    remove_stale(file)
            return [file.replace(folder / name) for name, file in files.items()]

    def _tables(self) -> Iterator[tuple[str, Writer]]:
        for name, table in self.tables.items():
            for ending in self.formats:
                numbers = _NINE_DIGITS if name in self.nine_digits else None
                writer = parquet_writer(table) if ending == "parquet" else None
                yield f"{name}.{ending}", writer or csv_writer(table, numbers)

    def _obsolete(self, folder: Path) -> Iterator[Path]:
        """What must not stay beside the new files."""
        for name in self.tables:
            yield from (folder / f"{name}.{ending}" for ending in _OF_TABLES)
        for name in self.obsolete:
            yield from (folder / f"{name}.{ending}" for ending in (*_OF_TABLES, *_OF_PICTURES))
        yield from (folder / name for name in _marked(folder))


def _marked(folder: Path) -> Iterator[str]:
    """Tables that the provenance in a folder tells of, if it does."""
    file = folder / PROVENANCE
    if not file.is_file():
        return
    try:
        names = list(json.loads(file.read_bytes())[MARKS])
    except (ValueError, LookupError, TypeError, RecursionError):
        return  # whatever else stands there
    for name in map(str, names):
        if Path(name).name == name and name.endswith(_OF_TABLES):
            yield name
