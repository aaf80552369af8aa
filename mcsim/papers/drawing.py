"""Pictures of stored results, drawn by other processes while the next scenario runs.

One process imports what drawing needs while the first scenario is still simulated; those
that draw are forked from it.  Where there is no such thing, each process imports for itself.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from types import TracebackType
from typing import Any

#: What drawing imports.
_NEEDED = ("mcsim.figures.saving", "mcsim.figures.whole", "mcsim.store", "pyarrow.csv")


class Drawing:
    """Draws in ``jobs`` processes; with one job, at once and in this process."""

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self._pool: Executor | None = None
        self._drawn: list[Future[None]] = []
        if jobs == 1:
            return
        # Never forked from this process: beside running threads that may hang.
        if not _prepared_fork_server():
            pool = self._start("spawn")
            for _ in range(jobs):
                pool.submit(_get_ready)

    def __enter__(self) -> Drawing:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=error is None, cancel_futures=error is not None)
        if error is None:
            for drawn in self._drawn:
                drawn.result()

    def one(self, folder: Path) -> None:
        """The figures of one stored result."""
        self._submit(draw_one, folder)

    def side_by_side(
        self, parts: list[Path], title: str, folder: Path, provenance: Mapping[str, Any]
    ) -> None:
        """One figure of several stored results."""
        self._submit(draw_side_by_side, parts, title, folder, provenance)

    def _submit(self, task: Callable[..., None], *arguments: Any) -> None:
        if self._jobs == 1:
            task(*arguments)
            return
        # Not before the first picture: it waits until the imports are done.
        pool = self._pool or self._start("forkserver")
        self._drawn.append(pool.submit(task, *arguments))

    def _start(self, method: str) -> Executor:
        self._pool = ProcessPoolExecutor(self._jobs, mp_context=get_context(method))
        return self._pool


def _prepared_fork_server() -> bool:
    """Begin the process that drawing processes are forked from; False where there can be none."""
    if sys.platform != "linux":
        return False  # elsewhere a process that has imported numpy may not be forked
    from multiprocessing import forkserver

    forkserver.set_forkserver_preload(list(_NEEDED))
    try:
        with _interrupts_ignored():
            forkserver.ensure_running()
    except OSError:
        return False  # as where the path of the temporary folder is too long for a socket
    return True


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Processes begun here leave Ctrl-C to this one."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may set signals
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _get_ready() -> None:
    """Import what drawing needs while the first scenario still runs."""
    for module in _NEEDED:
        import_module(module)


def draw_one(folder: Path) -> None:
    """Draw a stored result in its folder."""
    from mcsim.figures.saving import save_figures
    from mcsim.store import load_results

    save_figures(load_results(folder), folder)


def draw_side_by_side(
    parts: list[Path], title: str, folder: Path, provenance: Mapping[str, Any]
) -> None:
    """Draw several stored results as one figure into ``folder``."""
    from mcsim.figures import whole
    from mcsim.figures.style import printed
    from mcsim.report import Report
    from mcsim.store import load_results

    figure = whole.draw_side_by_side([load_results(part) for part in parts], title)
    Report(provenance, pictures=printed(figure, "figure")).write(folder)
