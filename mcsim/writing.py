"""Writing into a folder of results: whole files or none, by one run at a time."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from mcsim.errors import InputError

try:
    import fcntl
except ImportError:  # a system without such locks: nothing is locked there
    fcntl = None  # type: ignore[assignment]

if TYPE_CHECKING:
    import pandas as pd

#: Held by the run that writes into a folder.
LOCK = ".lock"
#: What `tempfile` puts between the name and the ending of a file that is being written.
_RANDOM = "[a-z0-9_]{8}"


def write_table(table: pd.DataFrame, folder: Path, name: str) -> Path:
    """Write one table as CSV into ``folder``, whole or not at all.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        return write_whole(folder / f"{name}.csv", csv_writer(table))


def write_text(text: str, folder: Path, name: str) -> Path:
    """Write one text file into ``folder``, whole or not at all.

    Raises
    ------
    InputError
        The folder cannot be written.
    """

    def write(path: Path) -> None:
        path.write_text(text, encoding="utf-8")

    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        return write_whole(folder / name, write)


def write_whole(path: Path, write: Callable[[Path], None]) -> Path:
    """Write beside ``path`` and move into place, so that no half-written file is ever seen.

    What a killed process has left beside it is removed.
    """
    remove_stale(path)
    descriptor, name = tempfile.mkstemp(
        prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent
    )
    beside = Path(name)
    try:
        _claim(descriptor)
        write(beside)
        beside.chmod(0o666 & ~_umask())
        beside.replace(path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise
    finally:
        os.close(descriptor)
    return path


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


def csv_writer(table: pd.DataFrame) -> Callable[[Path], None]:
    """Writes a table as CSV."""
    return lambda path: table.to_csv(path, index=False, lineterminator="\n")


def parquet_writer(table: pd.DataFrame) -> Callable[[Path], None]:
    """Writes a table as Parquet."""
    return lambda path: table.to_parquet(path, index=False)


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
