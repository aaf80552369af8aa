"""Pictures of stored results, drawn by other processes while the next scenario runs."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from types import TracebackType
from typing import Any


class Drawing:
    """Draws in ``jobs`` processes; with one job, at once and in this process."""

    def __init__(self, jobs: int) -> None:
        self._pool: Executor | None = None
        if jobs > 1:
            # Fresh processes: those forked beside running threads may hang.
            self._pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"))
            for _ in range(jobs):
                self._pool.submit(_get_ready)
        self._drawn: list[Future[None]] = []

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

    def side_by_side(self, parts: list[Path], title: str, folder: Path) -> None:
        """One figure of several stored results."""
        self._submit(draw_side_by_side, parts, title, folder)

    def _submit(self, task: Callable[..., None], *arguments: Any) -> None:
        if self._pool is None:
            task(*arguments)
        else:
            self._drawn.append(self._pool.submit(task, *arguments))


def _get_ready() -> None:
    """Import what drawing needs while the first scenario still runs."""
    from mcsim import figures, store  # noqa: F401


def draw_one(folder: Path) -> None:
    """Draw a stored result in its folder."""
    from mcsim.figures import save_figures
    from mcsim.store import load_results

    save_figures(load_results(folder), folder)


def draw_side_by_side(parts: list[Path], title: str, folder: Path) -> None:
    """Draw several stored results as one figure into ``folder``."""
    from mcsim import figures
    from mcsim.store import load_results

    folder.mkdir(parents=True, exist_ok=True)
    figure = figures.draw_side_by_side([load_results(part) for part in parts], title)
    figures.write_figure(figure, folder, "figure")
