"""Writing into a folder of results: whole files or none, by one run at a time."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from mcsim.errors import InputError

try:
    import fcntl
except ImportError:  # a system without such locks: nothing is locked there
    fcntl = None  # type: ignore[assignment]

if TYPE_CHECKING:
    import pandas as pd

#: Writes one file at the path that it is given.
Writer = Callable[[Path], None]
#: Held by the run that writes into a folder.
LOCK = ".lock"
#: What `tempfile` puts between the name and the ending of a file that is being written.
_RANDOM = "[a-z0-9_]{8}"


def write_whole(path: Path, write: Writer) -> Path:
    """Write beside ``path`` and move into place, so that no half-written file is ever seen.

    What a killed process has left beside it is removed.
    """
    return write_together({path: write})[0]


def write_together(files: Mapping[Path, Writer]) -> list[Path]:
    """Write several files as ``write_whole`` does; none is replaced unless all could be written."""
    with ExitStack() as stack:
        written = {
            path: stack.enter_context(written_beside(path, write)) for path, write in files.items()
        }
        for path, beside in written.items():
            beside.replace(path)
    return list(files)


@contextmanager
def written_beside(path: Path, write: Writer) -> Iterator[Path]:
    """A file as ``path`` shall be, to be moved there inside; what is not moved is removed."""
    remove_stale(path)
    descriptor, name = tempfile.mkstemp(
        prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent
    )
    beside = Path(name)
    try:
        _claim(descriptor)
        write(beside)
        beside.chmod(0o666 & ~_umask())
        yield beside
    finally:
        beside.unlink(missing_ok=True)
        os.close(descriptor)


def remove_stale(path: Path) -> None:
    """Remove what killed processes left of ``path``: hidden files that nobody writes any more."""
    ours = re.compile(rf"\.{re.escape(path.stem)}-{_RANDOM}{re.escape(path.suffix)}")
    if fcntl is None or not path.parent.is_dir():
        return  # whether somebody still writes cannot be told
    for beside in path.parent.iterdir():
        if ours.fullmatch(beside.name) and beside.is_file() and not beside.is_symlink():
            with suppress(OSError):
                _remove_unclaimed(beside)


def _remove_unclaimed(beside: Path) -> None:
    descriptor = os.open(beside, os.O_RDWR)
    try:
        if _claim(descriptor):
            beside.unlink()
    finally:
        os.close(descriptor)


def _claim(descriptor: int) -> bool:
    """Lock an open file for this process as long as it is open; False if another holds it."""
    if fcntl is None:
        return True
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True  # a file system without locks
    return True


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def csv_writer(table: pd.DataFrame, numbers: str | None = None) -> Writer:
    """Writes a table as CSV, its floats exactly or in the format ``numbers``."""
    return lambda path: table.to_csv(path, index=False, lineterminator="\n", float_format=numbers)


def parquet_writer(table: pd.DataFrame) -> Writer:
    """Writes a table as Parquet."""
    return lambda path: table.to_parquet(path, index=False)


def text_writer(text: str) -> Writer:
    """Writes a text as UTF-8."""

    def write(path: Path) -> None:
        path.write_text(text, encoding="utf-8")

    return write


@contextmanager
def readable_errors(folder: Path) -> Iterator[None]:
    """Turns errors of the file system into one message about ``folder``."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror or error})") from None


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Keep other runs out of ``folder``; it is made, and removed again if it stays empty.

    Raises
    ------
    InputError
        Another run writes there, or the folder cannot be written.
    """
    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        descriptor = _locked(folder)
    try:
        yield
    finally:
        # Removed while it is still held: who waits for it finds a new file (see ``_locked``).
        (folder / LOCK).unlink(missing_ok=True)
        os.close(descriptor)
        with suppress(OSError):  # the folder holds files
            folder.rmdir()


def _locked(folder: Path) -> int:
    """The descriptor of the folder's lock, held by this process; a lock of a dead one is none."""
    path = folder / LOCK
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        if not _claim(descriptor):
            os.close(descriptor)
            raise InputError(
                f"{folder}: another run writes into this folder; "
                "wait until it is done, or choose another folder with --output"
            )
        with suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(descriptor), path.stat()):
                return descriptor
        # Its holder has removed it meanwhile.
        os.close(descriptor)
