"""Results on disk: whole files or none, checkpoints of unfinished sweeps, loading."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from mcsim.engine import PointResult
from mcsim.errors import InputError
from mcsim.results import Results
from mcsim.scenario import Scenario
from mcsim.statistics import Estimates
from mcsim.version import __version__

if TYPE_CHECKING:
    import pandas as pd

TABLE, PROVENANCE, CHECKPOINT = "table", "provenance.json", ".checkpoint-"
#: Tables beside the main one; each as CSV and Parquet.
_EXTRA_TABLES = ("budget", "history", "tracks")
_PICTURES = ("png", "svg")


def save(results: Results, folder: Path) -> list[Path]:
    """Write the tables and the provenance of a run into ``folder``; return the files.

    Each file appears whole or not at all.  Files that an earlier run left and this
    one does not have are removed.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    tables = {
        TABLE: results.table,
        "budget": results.budget,
        "history": results.history,
        "tracks": results.tracks,
    }
    written = []
    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name, table in tables.items():
            if table is None:
                _remove(folder, name, ("csv", "parquet", *_PICTURES))
                continue
            written += [
                write_whole(folder / f"{name}.csv", _csv_writer(table)),
                write_whole(folder / f"{name}.parquet", _parquet_writer(table)),
            ]
    written.append(write_provenance(results.provenance, folder))
    return written


def write_provenance(provenance: Mapping[str, Any], folder: Path) -> Path:
    """Write where results come from into ``folder``, whole or not at all.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    text = json.dumps(provenance, indent=2, ensure_ascii=False) + "\n"
    return write_text(text, folder, PROVENANCE)


def remove_figures(folder: Path) -> None:
    """Remove the pictures of an earlier run, which would not belong to new tables.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    with readable_errors(folder):
        for name in ("figure", "tracks"):
            _remove(folder, name, _PICTURES)


def _remove(folder: Path, name: str, endings: tuple[str, ...]) -> None:
    for ending in endings:
        (folder / f"{name}.{ending}").unlink(missing_ok=True)


def write_table(table: pd.DataFrame, folder: Path, name: str) -> Path:
    """Write one table as CSV into ``folder``, whole or not at all.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        return write_whole(folder / f"{name}.csv", _csv_writer(table))


def write_text(text: str, folder: Path, name: str) -> Path:
    """Write one text file into ``folder``, whole or not at all.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        return write_whole(folder / name, lambda path: _write_text(path, text))


def write_whole(path: Path, write: Callable[[Path], None]) -> Path:
    """Write beside ``path`` and move into place, so that no half-written file is ever seen."""
    descriptor, name = tempfile.mkstemp(
        prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent
    )
    os.close(descriptor)
    beside = Path(name)
    try:
        write(beside)
        beside.chmod(0o666 & ~_umask())
        beside.replace(path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise
    return path


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _csv_writer(table: pd.DataFrame) -> Callable[[Path], None]:
    return lambda path: table.to_csv(path, index=False, lineterminator="\n")


def _parquet_writer(table: pd.DataFrame) -> Callable[[Path], None]:
    return lambda path: table.to_parquet(path, index=False)


@contextmanager
def readable_errors(folder: Path) -> Iterator[None]:
    """Turns errors of the file system into one message about ``folder``."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror or error})") from None


def load(path: str | Path) -> pd.DataFrame:
    """The table of a stored result; ``path`` is its folder or one of its tables.

    Raises
    ------
    InputError
        There is no result at that place.
    """
    import pandas as pd

    file = _table_file(Path(path))
    try:
        if file.suffix == ".csv":
            table = pd.read_csv(file, engine="pyarrow")  # reads floats exactly
            if "note" in table:
                table["note"] = table["note"].astype(object).fillna("").astype(str)
            return table
        return pd.read_parquet(file)
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: not a table of results ({error})") from None


def load_results(path: str | Path) -> Results:
    """A stored result with its scenario, so that it can be drawn again.

    Raises
    ------
    InputError
        There is no result at that place, or its provenance is damaged.
    """
    import pandas as pd

    file = _table_file(Path(path))
    folder = file.parent
    try:
        provenance = json.loads((folder / PROVENANCE).read_text(encoding="utf-8"))
        name = Path(provenance["name"]).name
        scenario = Scenario.from_dict(provenance["scenario"], name, folder)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{folder / PROVENANCE}: not the provenance of a result ({error})"
        ) from None
    extra: dict[str, Any] = {
        name: pd.read_parquet(folder / f"{name}.parquet")
        for name in _EXTRA_TABLES
        if (folder / f"{name}.parquet").exists()
    }
    return Results(scenario, load(file), provenance, **extra)


def _table_file(path: Path) -> Path:
    if path.is_file():
        return path
    for ending in ("parquet", "csv"):
        if (path / f"{TABLE}.{ending}").is_file():
            return path / f"{TABLE}.{ending}"
    what = "holds no table.csv" if path.is_dir() else "no such result"
    raise InputError(f"{path}: {what}; name the folder that `mcsim run` wrote")


@dataclass(frozen=True)
class Checkpoint:
    """Finished points of an unfinished sweep, one line of JSON each.

    The file's name tells what the points belong to: a run of another scenario, seed or
    version has another file.  Lines are only ever appended; one cut short by a kill is
    dropped.
    """

    path: Path

    @classmethod
    def of(cls, scenario: Scenario, folder: Path) -> Checkpoint:
        """The checkpoint of a scenario whose results go to ``folder``."""
        digest = hashlib.blake2b(digest_size=16)
        digest.update(f"{__version__}\n{json.dumps(scenario.document.tree)}".encode())
        for name in sorted({name for point in scenario.points for name in point.model.files}):
            digest.update((scenario.folder / name).read_bytes())
        return cls(folder / f"{CHECKPOINT}{digest.hexdigest()}.jsonl")

    def read(self) -> dict[int, PointResult]:
        """The points that an earlier run finished; floats to the last bit."""
        try:
            lines = self.path.read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError):
            return {}
        points: dict[int, PointResult] = {}
        for line in lines:
            try:
                index, result = _decode(json.loads(line))
            except (ValueError, KeyError, TypeError):
                continue
            points[index] = result
        return points

    @contextmanager
    def writer(self) -> Iterator[Callable[[int, PointResult], None]]:
        """A function that appends a finished point."""
        with readable_errors(self.path.parent):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            file = self.path.open("a", encoding="utf-8")
        try:
            with file:
                yield lambda index, result: _append(file, _encode(index, result))
        finally:
            # Interrupted before the first point, too: nothing is kept, nothing is left.
            if self.path.stat().st_size == 0:
                self.remove()
                with suppress(OSError):  # the folder holds other files
                    self.path.parent.rmdir()

    def remove(self) -> None:
        """Forget the points: the results are written."""
        self.path.unlink(missing_ok=True)


def _append(file: TextIO, record: dict[str, Any]) -> None:
    # The leading break ends a line that an earlier run may have left unfinished.
    file.write("\n" + json.dumps(record) + "\n")
    file.flush()


def _encode(index: int, result: PointResult) -> dict[str, Any]:
    def exact(values: Any) -> list[Any]:
        return [[float(x).hex() for x in row] for row in np.atleast_2d(values)]

    estimates = result.estimates
    return {
        "index": index,
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
        exact("value"), exact("low"), exact("high"), np.array(record["degenerate"], bool)
    )
    return int(record["index"]), PointResult(
        estimates,
        exact("method")[0],
        int(record["realizations"]),
        dict(record["notes"]),
        {s: np.array([float.fromhex(x) for x in v]) for s, v in record["variances"].items()},
        tuple(record["limits"]),
    )
