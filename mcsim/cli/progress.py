"""How a run goes: a bar on a terminal, plain lines elsewhere; ETA counted in realizations."""

from __future__ import annotations

import sys
import threading
import time
from functools import cache
from typing import TYPE_CHECKING, Any

from mcsim.sweep import Progress, Silent

if TYPE_CHECKING:
    from mcsim.scenario_file import Scenario

#: Seconds between two plain lines.
_LINE_EVERY = 5.0


def progress_for(quiet: bool) -> Progress:
    """What suits the place that messages go to (standard error)."""
    if quiet or sys.stderr is None:
        return Silent()
    return Bar() if sys.stderr.isatty() else Lines()


@cache
def announce_compilation() -> None:
    """Say, once, that kernels are being compiled; kernels from the cache say nothing."""
    from numba.core import event

    class Announcer(event.Listener):
        said = False

        def on_start(self, event: Any) -> None:
            del event
            if not self.said:
                self.said = True
                _say("compiling for this machine; this happens once and takes some seconds")

        def on_end(self, event: Any) -> None:
            del event

    event.register("numba:compile", Announcer())  # type: ignore[no-untyped-call]


class Bar:
    """A bar with points, realizations and the time left."""

    def __init__(self) -> None:
        self._bar: Any = None

    def start(self, scenario: Scenario, realizations: int | None, resumed: int) -> None:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            Progress,
            SpinnerColumn,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        self._done, self._points = resumed, scenario.n_points
        self._realizations = 0
        self._bar = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[points]} points"),
            TextColumn("{task.fields[realizations]:,} realizations"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
        )
        # With a wanted precision the number of realizations is open: points are counted.
        self._by_points = realizations is None
        self._task = self._bar.add_task(
            scenario.name,
            total=realizations if realizations is not None else self._points - resumed,
            points=f"{self._done}/{self._points}",
            realizations=0,
        )
        self._bar.start()

    def advance(self, realizations: int) -> None:
        self._realizations += realizations
        self._bar.update(
            self._task,
            advance=0 if self._by_points else realizations,
            realizations=self._realizations,
        )

    def point_done(self) -> None:
        self._done += 1
        self._bar.update(
            self._task, advance=int(self._by_points), points=f"{self._done}/{self._points}"
        )

    def finish(self) -> None:
        self._bar.stop()


class Lines:
    """A line at the start, one every few seconds, one at the end."""

    def __init__(self) -> None:
        self._lock = threading.Lock()

    def start(self, scenario: Scenario, realizations: int | None, resumed: int) -> None:
        self._name, self._points, self._total = scenario.name, scenario.n_points, realizations
        self._points_done, self._resumed, self._done = resumed, resumed, 0
        self._begun = self._last = time.monotonic()
        # The pace is measured from the first progress on: compiling is no measure of it.
        self._first: tuple[float, float] | None = None
        more = f", {resumed} of them done before" if resumed else ""
        wanted = f", {realizations:,} realizations" if realizations is not None else ""
        _say(f"{self._name}: {self._points} point{'s' * (self._points != 1)}{more}{wanted}")

    def advance(self, realizations: int) -> None:
        with self._lock:
            self._done += realizations
            now = time.monotonic()
            if self._first is None:
                self._first = now, self._share()
            if now - self._last >= _LINE_EVERY:
                self._last = now
                _say(self._state())

    def point_done(self) -> None:
        with self._lock:
            self._points_done += 1

    def finish(self) -> None:
        elapsed = time.monotonic() - self._begun
        _say(
            f"{self._name}: {self._points_done}/{self._points} points, "
            f"{self._done:,} realizations in {elapsed:.1f} s"
        )

    def _state(self) -> str:
        now, share = time.monotonic(), self._share()
        left = f" ({share:.0%})" if share > 0.0 else ""
        if self._first is not None and share > self._first[1]:
            pace = (now - self._first[0]) / (share - self._first[1])
            left += f", about {pace * (1.0 - share):.0f} s left"
        return (
            f"{self._name}: {self._points_done}/{self._points} points, "
            f"{self._done:,} realizations{left}"
        )

    def _share(self) -> float:
        """Of the work to do; points are counted where a precision leaves realizations open."""
        if self._total:
            return self._done / self._total
        return (self._points_done - self._resumed) / (self._points - self._resumed)


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
