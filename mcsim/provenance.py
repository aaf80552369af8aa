"""Where results come from: what was computed, from which inputs, with what, and when."""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from mcsim.files import readable
from mcsim.version import __version__

#: The file that tells it, beside the results.
PROVENANCE = "provenance.json"
#: Its key of the digests of the tables that it belongs to, by file name.
MARKS = "files"
_BLOCK = 1 << 20


def mark_of(content: bytes) -> str:
    """The digest by which a provenance knows its tables again."""
    return hashlib.blake2b(content, digest_size=16).hexdigest()


def reproducible() -> bool:
    """Whether results say nothing of when and where they were made.

    So it is where ``SOURCE_DATE_EPOCH`` is set, the convention of reproducible builds: the same
    numbers then make the same files.
    """
    return "SOURCE_DATE_EPOCH" in os.environ


def time_and_machine() -> dict[str, Any]:
    """Versions, platform and time; nothing where results must be reproducible."""
    if reproducible():
        return {}
    packages = ("numpy", "numba", "scipy", "pandas")
    return {
        "versions": {
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in packages},
        },
        "platform": {
            "system": platform.system(),
            "machine": platform.machine(),
        },
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def provenance_of(
    command: str,
    inputs: Iterable[Path] = (),
    options: Mapping[str, Any] | None = None,
    seed: int | None = None,
) -> dict[str, Any]:
    """Where the results of a command come from.

    Parameters
    ----------
    command : str
        As the command line has it, without options: ``"table sensors"``.
    inputs : iterable of paths
        The files that were read: told by name and digest, without their folders.
    options : mapping, optional
        What else the numbers depend on; those that are None are left out.
    seed : int, optional
        Of the random numbers, if there were any.

    Raises
    ------
    InputError
        An input that cannot be read.
    """
    chosen = {key: value for key, value in (options or {}).items() if value is not None}
    return {
        "mcsim": __version__,
        "command": command,
        **({"inputs": found} if (found := {p.name: _digest(p) for p in inputs}) else {}),
        **({"options": chosen} if chosen else {}),
        **({"seed": seed} if seed is not None else {}),
        **time_and_machine(),
    }


def _digest(path: Path) -> str:
    """Of a file's content; of a folder, the names and sizes of what lies in it."""
    digest = hashlib.blake2b(digest_size=16)
    with readable(path):
        if path.is_dir():
            for file in sorted(path.rglob("*")):
                if file.is_file():
                    size = file.stat().st_size
                    digest.update(f"{file.relative_to(path).as_posix()}\n{size}\n".encode())
        else:
            with path.open("rb") as content:
                while block := content.read(_BLOCK):
                    digest.update(block)
    return digest.hexdigest()
