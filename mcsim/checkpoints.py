"""Finished points of an unfinished sweep, kept until its results are written."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from mcsim.engine import PointResult
from mcsim.errors import InputError
from mcsim.files import check_file, readable
from mcsim.scenario_file import Scenario
from mcsim.statistics import Estimates
from mcsim.version import __version__
from mcsim.writing import readable_errors, write_whole

CHECKPOINT = ".checkpoint-"
#: The longest line that a point can have, and the largest file (bytes).
_LONGEST_LINE, _LARGEST = 1 << 24, 1 << 34
_CHECK = "check"


@dataclass(frozen=True)
class Checkpoint:
    """Finished points of an unfinished sweep, one line of JSON each.

    The file's name tells what the points belong to: a run of another scenario, seed or
    version has another file.  Each line carries a checksum of itself and of that name: what
    has been damaged, or moved here, is found and left out.  Lines are only ever appended.
    """

    path: Path
    scenario: Scenario | None = None

    @classmethod
    def of(cls, scenario: Scenario, folder: Path) -> Checkpoint:
        """The checkpoint of a scenario whose results go to ``folder``."""
        digest = hashlib.blake2b(digest_size=16)
        digest.update(f"{__version__}\n{json.dumps(scenario.document.tree)}".encode())
        for name in sorted({name for point in scenario.points for name in point.model.files}):
            for path in _files(scenario.folder / name):
                with path.open("rb") as file:
                    while block := file.read(1 << 20):
                        digest.update(block)
        return cls(folder / f"{CHECKPOINT}{digest.hexdigest()}.jsonl", scenario)

    def read(self) -> dict[int, PointResult]:
        """The points that an earlier run finished; floats to the last bit.

        Raises
        ------
        InputError
            In the file's place is something else.
        """
        return self._sound_lines().points

    def recover(self) -> tuple[dict[int, PointResult], int]:
        """The finished points, and how many lines were damaged, which are forgotten.

        A last line that a kill has cut short is no damage.

        Raises
        ------
        InputError
            In the file's place is something else, or it cannot be written.
        """
        found = self._sound_lines()
        if found.damaged or found.cut:
            whole = b"".join(found.lines)
            with readable_errors(self.path.parent):
                write_whole(self.path, lambda path: _write_bytes(path, whole))
        return found.points, found.damaged

    def _sound_lines(self) -> _Sound:
        found = _Sound({}, [])
        for line in self._lines():
            found.damaged += found.cut  # it was not the last one
            found.cut = False
            if not line.strip():
                continue
            try:
                index, result = self._decoded(line)
            except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, LookupError):
                found.cut = not line.endswith(b"\n")
                found.damaged += not found.cut
                continue
            found.points[index] = result
            found.lines.append(line)
        return found

    def _lines(self) -> Iterator[bytes]:
        if self.path.is_symlink():
            raise InputError(f"{self.path}: is a link, not a checkpoint; remove it")
        if not self.path.exists():
            return
        check_file(self.path, _LARGEST, "checkpoint")
        with readable(self.path, "checkpoint"), self.path.open("rb") as file:
            while line := file.readline(_LONGEST_LINE):
                yield line

    def _decoded(self, line: bytes) -> tuple[int, PointResult]:
        try:
            record = json.loads(line)
        except RecursionError as error:
            raise ValueError(error) from None
        if record.pop(_CHECK) != self._check(record):
            raise ValueError
        index, result = _decode(record)
        if self.scenario is not None:
            _refuse_unfit(self.scenario, index, result)
        return index, result

    def _check(self, record: dict[str, Any]) -> str:
        text = f"{self.path.name}\n{json.dumps(record)}"
        return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()

    @contextmanager
    def writer(self) -> Iterator[Callable[[int, PointResult], None]]:
        """A function that appends a finished point."""
        with readable_errors(self.path.parent):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            file = self.path.open("ab")

        def append(index: int, result: PointResult) -> None:
            record = _encode(index, result)
            with readable_errors(self.path.parent):
                _append(file, {**record, _CHECK: self._check(record)})

        try:
            with file:
                yield append
        finally:
            # Interrupted before the first point, too: nothing is kept, nothing is left.
            if self.path.stat().st_size == 0:
                self.remove()
                with suppress(OSError):  # the folder holds other files
                    self.path.parent.rmdir()

    def remove(self) -> None:
        """Forget the points: the results are written."""
        self.path.unlink(missing_ok=True)


@dataclass
class _Sound:
    """Points of sound lines, the lines, the number of damaged ones, whether the last is cut."""

    points: dict[int, PointResult]
    lines: list[bytes]
    damaged: int = 0
    cut: bool = False


def _write_bytes(path: Path, content: bytes) -> None:
    path.write_bytes(content)


def _append(file: IO[bytes], record: dict[str, Any]) -> None:
    # The leading break ends a line that an earlier run may have left unfinished.
    file.write(b"\n" + json.dumps(record).encode() + b"\n")
    file.flush()


def _encode(index: int, result: PointResult) -> dict[str, Any]:
    def exact(values: Any) -> list[Any]:
        return [[float(x).hex() for x in row] for row in np.atleast_2d(values)]

    estimates = result.estimates
    return {
        "index": index,
        "statistics": list(estimates.statistics),
        "value": exact(estimates.value),
        "low": exact(estimates.low),
        "high": exact(estimates.high),
        "degenerate": [bool(x) for x in estimates.degenerate],
        "method": exact(result.method),
        "realizations": result.realizations,
        "notes": result.notes,
        "limits": list(result.limits),
        "variances": {source: exact(v)[0] for source, v in result.variances.items()},
    }


def _decode(record: dict[str, Any]) -> tuple[int, PointResult]:
    def exact(name: str) -> Any:
        return np.array([[float.fromhex(x) for x in row] for row in record[name]])

    estimates = Estimates(
        tuple(record["statistics"]),
        exact("value"),
        exact("low"),
        exact("high"),
        np.array(record["degenerate"], bool),
    )
    return int(record["index"]), PointResult(
        estimates,
        exact("method")[0],
        int(record["realizations"]),
        dict(record["notes"]),
        {s: np.array([float.fromhex(x) for x in v]) for s, v in record["variances"].items()},
        tuple(record["limits"]),
    )


def _refuse_unfit(scenario: Scenario, index: int, result: PointResult) -> None:
    """A point that is none of the scenario's would stop the run when its tables are made."""
    if not 0 <= index < scenario.n_points:
        raise IndexError(index)
    model = scenario.points[index].model
    estimates = result.estimates
    if estimates.statistics != tuple(model.statistics()):
        raise ValueError(index)
    rows = len(model.error_rows)
    table = (rows, len(estimates.statistics))
    shapes = [
        (table, estimates.value),
        (table, estimates.low),
        (table, estimates.high),
        ((rows,), estimates.degenerate),
        ((rows,), result.method),
        *(((rows,), variance) for variance in result.variances.values()),
    ]
    if any(array.shape != shape for shape, array in shapes):
        raise ValueError(index)
    texts = (*result.limits, *(text for note in result.notes.items() for text in note))
    if not all(isinstance(text, str) for text in texts):
        raise TypeError(index)


def _files(path: Path) -> list[Path]:
    """The files of an input: itself, or all in a folder."""
    if not path.is_dir():
        return [path]
    return [file for file in sorted(path.rglob("*")) if file.is_file()]
