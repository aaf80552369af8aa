"""The one door for files that users name: checked, unpacked, bounded, one message if it fails.

A file is looked at before it is opened: a pipe, a device, a folder or a socket is refused at
once, and so is a file that is too large.  What is compressed is known by its first bytes
and unpacked while it is read, under a bound, so that a small file cannot ask for all memory.
Whatever goes wrong inside ends in one ``InputError`` that names the file::

    with open_bytes(path) as file:   # text or tables: plain, .gz, .xz, .bz2, .zst
        ...
    text = read_text(path, LARGEST, "scenario")
    with readable(path, "bag"):      # around the call of another library's reader
        ...
"""

from __future__ import annotations

import bz2
import codecs
import gzip
import io
import lzma
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import IO, Any

from mcsim.errors import InputError, McsimError

#: The largest table of numbers, unpacked (bytes): days of six channels at 100 Hz.
LARGEST_TABLE = 2 << 30
#: A packed file that unpacks to more than this (bytes) and to this many times its size is no
#: log: those shrink to a third or a tenth, seldom to a thirtieth.
_UNPACKED_UNSEEN, _LARGEST_RATIO, _LIKELY_RATIO = 64 << 20, 100, 30
#: Packed files up to this size (bytes) are looked through before they are read.
_SMALL = 4 << 20
#: Memory that unpacking may take for itself (bytes); xz -9 takes 65 MB.
_LARGEST_DICTIONARY = 256 << 20
#: Bytes that tell what a file is.
_HEAD = 512

_KINDS = (
    (stat.S_ISDIR, "is a directory"),
    (stat.S_ISFIFO, "is a pipe; write what comes out of it into a file"),
    (stat.S_ISCHR, "is a device"),
    (stat.S_ISBLK, "is a device"),
    (stat.S_ISSOCK, "is a socket"),
)
#: First bytes of compressed files, by the ending that they usually have.
_PACKED = {
    ".gz": b"\x1f\x8b",
    ".xz": b"\xfd7zXZ\x00",
    ".bz2": b"BZh",
    ".zst": b"\x28\xb5\x2f\xfd",
}
#: Bytes at the beginning by which the encoding is known.
_LOOKED_AT = 1 << 16
_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_UNPACK_IT = "unpack it and name the file inside"
_SAVE_AS_CSV = "save its table as CSV"
#: Files that are no text, by place and kind of their first bytes, and the way out.
_FOREIGN = (
    (0, b"PK\x03\x04", f"a zip archive or a spreadsheet; {_UNPACK_IT}, or {_SAVE_AS_CSV}"),
    (257, b"ustar", f"a tar archive; {_UNPACK_IT}"),
    (0, b"7z\xbc\xaf\x27\x1c", f"a 7z archive; {_UNPACK_IT}"),
    (0, b"Rar!", f"a rar archive; {_UNPACK_IT}"),
    (0, b"\xd0\xcf\x11\xe0", f"a spreadsheet (xls); {_SAVE_AS_CSV}"),
    (0, b"PAR1", f"a Parquet file; {_SAVE_AS_CSV}"),
    (0, b"\x89HDF", f"an HDF5 file; {_SAVE_AS_CSV}"),
    (0, b"MATLAB 5.0 MAT-file", f"a MAT file; {_SAVE_AS_CSV}"),
    (0, b"\x93NUMPY", f"a NumPy file; {_SAVE_AS_CSV}"),
    (0, b"%PDF", "a PDF"),
    (0, b"SQLite format 3", "an SQLite database (a ROS 2 bag ends in .db3)"),
)
_ARCHIVES = (".zip", ".tar", ".tgz", ".7z", ".rar")


def check_file(path: Path, largest: int = LARGEST_TABLE, what: str = "file") -> int:
    """Size (bytes) of a regular file, which is not opened.

    Raises
    ------
    InputError
        There is no such file, it is none (a folder, a pipe, a device), or it is too large.
    """
    with readable(path):
        status = path.stat()
    for is_kind, said in _KINDS:
        if is_kind(status.st_mode):
            raise InputError(f"{path}: {said}; name a {what}")
    if status.st_size > largest:
        raise InputError(f"{path}: larger than {_size(largest)}; not a {what}")
    return status.st_size


@contextmanager
def open_bytes(path: Path, largest: int = LARGEST_TABLE, what: str = "file") -> Iterator[IO[bytes]]:
    """The bytes of a file, unpacked (.gz, .xz, .bz2, .zst by content); at most ``largest``.

    Whatever is raised inside the block becomes the file's ``InputError``: so it should hold
    reading alone.

    Raises
    ------
    InputError
        As ``check_file``; an archive or a format that is no text; a packed file that is damaged
        or unpacks to more than any log holds.
    """
    size = check_file(path, largest, what)
    with readable(path, what), path.open("rb", _LOOKED_AT) as packed:
        head = packed.read(_HEAD)
        packed.seek(0)
        _refuse_foreign(path, head)
        ending = next((e for e, sign in _PACKED.items() if head.startswith(sign)), None)
        if ending is None:
            _refuse_false_ending(path, head)
            yield packed
            return
        with _unpacker(path, ending, packed) as unpacked:
            bounded = io.BufferedReader(_Bounded(unpacked, path, size, largest), _LOOKED_AT)
            _refuse_foreign(path, bounded.peek(_HEAD)[:_HEAD])
            yield bounded


@contextmanager
def open_lines(
    path: Path, largest: int = LARGEST_TABLE, what: str = "file"
) -> Iterator[tuple[IO[str], str]]:
    """The text of a file, plain or packed, and the encoding in which it is read.

    A byte-order mark says UTF-8, UTF-16 or UTF-32; without one, text whose beginning is no
    UTF-8 is Windows-1252, of which Latin-1 is a part.  Line ends become ``\\n``.

    Raises
    ------
    InputError
        As ``open_bytes``.
    """
    with open_bytes(path, largest, what) as file:
        buffered: Any = file
        head = buffered.peek(_LOOKED_AT)[:_LOOKED_AT]
        encoding, mark = _encoding(head, whole=len(head) < _LOOKED_AT)
        file.read(mark)
        yield io.TextIOWrapper(buffered, encoding, errors="replace"), encoding


def read_text(path: Path, largest: int, what: str) -> str:
    """The text of a UTF-8 file of at most ``largest`` bytes; a byte-order mark is left out.

    Raises
    ------
    InputError
        As ``open_bytes``, or the file is no UTF-8 text.
    """
    check_file(path, largest, what)
    with readable(path):
        return path.read_bytes()[: largest + 1].decode("utf-8-sig")


def likely_size(path: Path) -> int:
    """The most bytes that a file of text probably holds, unpacked; small ones are looked through.

    Raises
    ------
    InputError
        As ``open_bytes``.
    """
    size = check_file(path)
    with readable(path), path.open("rb") as file:
        packed = file.read(_HEAD).startswith(tuple(_PACKED.values()))
    if packed and size < _SMALL:
        with open_bytes(path) as unpacked:
            return sum(len(block) for block in iter(lambda: unpacked.read(1 << 20), b""))
    return size * _LIKELY_RATIO if packed else size


@contextmanager
def readable(path: Path, what: str = "file") -> Iterator[None]:
    """Turns whatever is raised while a file is read into one sentence about it.

    For the call of a reader alone: errors of the program would look like the file's.

    Raises
    ------
    InputError
        In place of every exception that is none of mcsim's own.
    """
    try:
        yield
    except McsimError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: not UTF-8 text (byte {error.start}); save the file as UTF-8"
        ) from None
    except MemoryError:
        raise InputError(f"{path}: cannot be read (more than the memory holds)") from None
    except Exception as error:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        first = reason.strip().splitlines()[0] if reason.strip() else type(error).__name__
        as_what = f" as a {what}" if what != "file" else ""
        raise InputError(f"{path}: cannot be read{as_what} ({first})") from None


class _Bounded(io.RawIOBase):
    """Unpacked bytes, counted: beyond the bound the file is refused, not read on."""

    def __init__(self, unpacked: IO[bytes], path: Path, packed: int, largest: int) -> None:
        self._unpacked, self._path = unpacked, path
        self._likely = max(_UNPACKED_UNSEEN, _LARGEST_RATIO * packed)
        self._largest = largest
        self._count = 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        content = self._unpacked.read(len(buffer))
        buffer[: len(content)] = content
        self._count += len(content)
        if self._count > self._largest:
            raise InputError(f"{self._path}: unpacks to more than {_size(self._largest)}")
        if self._count > self._likely:
            raise InputError(
                f"{self._path}: unpacks to more than {_LARGEST_RATIO} times its size, as no log "
                "does; if it is right, unpack it yourself and name the unpacked file"
            )
        return len(content)


def _unpacker(path: Path, ending: str, packed: IO[bytes]) -> IO[bytes]:
    if ending == ".zst":
        return _zstd(path)(packed)
    if ending == ".xz":
        # A header may ask for gigabytes; LZMAFile itself knows no limit.
        lzma.LZMADecompressor(memlimit=_LARGEST_DICTIONARY).decompress(packed.read(1 << 16), 1)
        packed.seek(0)
        return lzma.LZMAFile(packed)
    opened: Any = gzip.GzipFile(fileobj=packed) if ending == ".gz" else bz2.BZ2File(packed)
    return opened


def _zstd(path: Path) -> Callable[[IO[bytes]], IO[bytes]]:
    """Opens Zstandard, by whatever of Python 3.14 or two packages is there."""
    for module in ("compression.zstd", "backports.zstd", "zstandard"):
        try:
            opener = import_module(module).open
        except ImportError:
            continue
        return lambda packed: opener(packed, "rb")
    raise InputError(
        f"{path}: is packed by zstd, which Python knows from 3.14 on; unpack it by zstd -d, or "
        "install the package zstandard"
    )


def _encoding(head: bytes, whole: bool) -> tuple[str, int]:
    """Encoding of a text by its first bytes, and the length of its byte-order mark."""
    for mark, encoding in _MARKS:
        if head.startswith(mark):
            # Strictly: what begins like UTF-16 and is none is no text.
            codecs.getincrementaldecoder(encoding)().decode(head[len(mark) :], whole)
            return encoding, len(mark)
    nulls = [head[i::2].count(0) for i in (0, 1)]
    for i, encoding in enumerate(("utf-16-be", "utf-16-le")):
        if nulls[i] > len(head) // 4 and nulls[1 - i] < len(head) // 100 + 1:
            return encoding, 0
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "cp1252", 0
    return "utf-8", 0


def _refuse_foreign(path: Path, head: bytes) -> None:
    for place, sign, said in _FOREIGN:
        if head.startswith(sign, place):
            raise InputError(f"{path}: cannot be read: it is {said}")


def _refuse_false_ending(path: Path, head: bytes) -> None:
    ending = path.suffix.lower()
    if head and ending in (*_PACKED, *_ARCHIVES):
        raise InputError(
            f"{path}: cannot be read: its ending is {ending}, its content is not; if it is plain "
            f"text, name it {path.with_suffix('').name}"
        )


def _size(count: int) -> str:
    for power, unit in ((30, "GiB"), (20, "MiB"), (10, "KiB")):
        if count >= 1 << power:
            return f"{count / (1 << power):g} {unit}"
    return f"{count} bytes"
