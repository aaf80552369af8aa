"""The program: words to calls, errors to messages and exit codes."""

from __future__ import annotations

import gc
import io
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcsim.cli.commands import COMMANDS
from mcsim.cli.own import run_files
from mcsim.cli.signals import stopped_like_ctrl_c
from mcsim.errors import InputError, InterruptedRun, McsimError, PartialError
from mcsim.version import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence

EXIT_DONE, EXIT_FAILED, EXIT_BAD_INPUT, EXIT_PARTIAL, EXIT_INTERRUPTED = 0, 1, 2, 3, 130


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit with its code."""
    code = exit_code(arguments)
    if code == EXIT_INTERRUPTED:
        # An interruption inside ``exec``, as when a data class is made, is remembered although it
        # was handled, and the interpreter would end by SIGINT; the next ``exec`` forgets it.
        exec("")
    # The interpreter would look through all of numba's objects before it goes.
    gc.freeze()
    sys.exit(code)


def exit_code(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; every error becomes one message and an exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A terminal or pipe that lacks a sign gets a substitute, not an error.
            stream.reconfigure(errors="replace")
    try:
        with stopped_like_ctrl_c():
            code = commands.main(arguments, prog_name="mcsim", standalone_mode=False)
        return code if isinstance(code, int) else EXIT_DONE
    except click.ClickException as error:
        error.show()
        return EXIT_BAD_INPUT
    except InputError as error:
        return _fail(str(error), EXIT_BAD_INPUT)
    except PartialError as error:
        return _fail(str(error), EXIT_PARTIAL)
    except InterruptedRun as error:
        return _fail(str(error), EXIT_INTERRUPTED)
    except McsimError as error:
        return _fail(str(error), EXIT_FAILED)
    except (KeyboardInterrupt, click.Abort):
        return _fail("interrupted", EXIT_INTERRUPTED)
    except BrokenPipeError:
        # The reader of a pipe has left; nobody is there to be told.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_FAILED
    except Exception as error:
        if os.environ.get("MCSIM_DEBUG"):
            raise
        return _fail(
            f"internal error: {type(error).__name__}: {error} (MCSIM_DEBUG=1 shows where)",
            EXIT_FAILED,
        )


def _fail(message: str, code: int) -> int:
    if sys.stderr is None:
        return code
    lines = message.splitlines() or [""]
    print(f"mcsim: {lines[0]}", *lines[1:], sep="\n       ", file=sys.stderr)
    return code


class _Commands(click.Group):
    """The commands of the list, each imported when it is looked at."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        del ctx
        return sorted(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        del ctx
        return COMMANDS[cmd_name].command if cmd_name in COMMANDS else None


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mcsim")
@click.option(
    "--with",
    "own",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE.py",
    is_eager=True,  # its commands are among those that --help lists
    callback=run_files,
    help="Run this Python file first: it adds parts of your own.",
)
def commands(own: tuple[Path, ...]) -> None:
    """How well can a vehicle know where it is, from inertial sensors alone?

    A scenario (YAML) describes a track, sensors and a sweep; mcsim reconstructs
    thousands of disturbed drives and reports the errors with their intervals.
    """
    del own  # run as soon as it is read
