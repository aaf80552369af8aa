"""Python files of a user's, which add parts of their own before scenarios are read."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import click

from mcsim.errors import InputError, McsimError

#: Own files are text of at most this size (bytes).
_LARGEST = 1 << 20


def run_files(
    context: click.Context, option: click.Parameter, files: tuple[Path, ...]
) -> tuple[Path, ...]:
    """Run the files of an option ``--with``.

    Raises
    ------
    InputError
        See ``run_own``.
    """
    del context, option
    for file in files:
        run_own(file)
    return files


def own_files() -> tuple[Path, ...]:
    """The files that were named before the command."""
    files: tuple[Path, ...] = click.get_current_context().find_root().params.get("own", ())
    return files


def run_own(file: Path) -> None:
    """Import a Python file by its path.

    Raises
    ------
    InputError
        No such file, or what it raises, with its line.
    """
    from mcsim.files import check_file

    check_file(file, _LARGEST, "Python file")
    name = f"mcsim_own_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    if file.suffix != ".py" or spec is None or spec.loader is None:
        raise InputError(f"--with {file}: not a Python file; its name must end in .py")
    module = importlib.util.module_from_spec(spec)
    # Numba and pickling find the file's classes by its name.
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except McsimError:
        raise
    except Exception as error:
        raise InputError(f"{file}:{_line(error, file)}: {type(error).__name__}: {error}") from None


def _line(error: Exception, file: Path) -> int:
    """The last line of the file that the error came through."""
    line = getattr(error, "lineno", None) or 1
    trace = error.__traceback__
    while trace is not None:
        if Path(trace.tb_frame.f_code.co_filename) == file:
            line = trace.tb_lineno
        trace = trace.tb_next
    return int(line)
