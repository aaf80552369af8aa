"""The command line: words to calls, errors to exit codes."""

from mcsim.cli.main import main

__all__ = ["main"]
