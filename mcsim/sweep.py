"""All points of a scenario over workers; the same results whatever their number or order."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from mcsim.engine import PointResult, point_key, run_point
from mcsim.errors import InputError, McsimError
from mcsim.processors import default_jobs
from mcsim.scenario_file import Point, Scenario
from mcsim.systems import check_point, problem_of


class Progress(Protocol):
    """Hears how a sweep goes; every method may be called from any thread."""

    def start(self, scenario: Scenario, realizations: int | None, resumed: int) -> None:
        """``realizations`` is the expected total; None if precision decides."""

    def advance(self, realizations: int) -> None:
        """So many more realizations are done."""

    def point_done(self) -> None:
        """One more point is done."""

    def finish(self) -> None:
        """No more calls follow."""


class Silent:
    """Progress that nobody watches."""

    def start(self, scenario: Scenario, realizations: int | None, resumed: int) -> None:
        pass

    def advance(self, realizations: int) -> None:
        pass

    def point_done(self) -> None:
        pass

    def finish(self) -> None:
        pass


#: How long to wait for a Dask scheduler.
_DASK_TIMEOUT = "10s"


@dataclass(frozen=True)
class SweepResult:
    """Results by the index of their point, and the points that failed, with the reason."""

    points: Mapping[int, PointResult]
    failures: Mapping[int, str]


def check_points(scenario: Scenario) -> list[int]:
    """Refuse, before anything runs, points that cannot run; samples per realization of each.

    Raises
    ------
    InputError
        A point's track cannot be built or sampled.
    """
    counts = []
    for point in scenario.points:
        try:
            counts.append(check_point(point.model, scenario.folder))
        except InputError as error:
            where = describe_point(scenario, point)
            at = f" (at {where})" if where else ""
            raise InputError(f"{scenario.document.source}: {error}{at}") from None
    return counts


def describe_point(scenario: Scenario, point: Point) -> str:
    """The coordinates of a point, as text."""
    coordinates = ", ".join(
        f"{axis.path} = {axis.written(value)}"
        for axis, value in zip(scenario.axes, point.values, strict=True)
    )
    return coordinates or scenario.name


def reason(error: Exception) -> str:
    """Why a point failed: our own messages as they are, others with their kind."""
    return str(error) if isinstance(error, McsimError) else f"{type(error).__name__}: {error}"


def run_sweep(
    scenario: Scenario,
    jobs: int | None = None,
    progress: Progress | None = None,
    done: Mapping[int, PointResult] | None = None,
    on_result: Callable[[int, PointResult], None] = lambda *_: None,
    dask: str | None = None,
) -> SweepResult:
    """Run every point that is not in ``done`` yet.

    Kernels release the interpreter lock, so the workers are threads: over points
    where there are several, over realizations where there is one.  ``on_result``
    is called in this thread, as points finish.  With ``dask``, the address of a
    scheduler, the points run on its workers instead: specifications travel out,
    statistics come back, and the results are the same to the bit.

    Raises
    ------
    InputError
        Dask is not installed, or no scheduler answers.
    """
    jobs = jobs or default_jobs()
    progress = progress or Silent()
    results = dict(done or {})
    failures: dict[int, str] = {}
    todo = [point for point in scenario.points if point.index not in results]
    threads_inside = jobs if len(todo) < jobs else 1
    workers = 1 if threads_inside > 1 else jobs
    progress.start(scenario, _expected_realizations(todo), len(results))
    if dask is not None:
        outcomes = _remote_outcomes(todo, scenario.folder.resolve(), dask, progress)
    else:
        outcomes = _outcomes(todo, scenario.folder, workers, threads_inside, progress)
    try:
        for index, outcome in outcomes:
            if isinstance(outcome, str):
                failures[index] = outcome
            else:
                results[index] = outcome
                on_result(index, outcome)
            progress.point_done()
    finally:
        progress.finish()
    return SweepResult(dict(sorted(results.items())), dict(sorted(failures.items())))


def _expected_realizations(points: list[Point]) -> int | None:
    counts = [point.model.monte_carlo.realizations for point in points]
    return None if None in counts else sum(count for count in counts if count is not None)


def _outcomes(
    points: list[Point], folder: Path, workers: int, threads: int, progress: Progress
) -> Iterator[tuple[int, PointResult | str]]:
    def run(point: Point) -> tuple[int, PointResult | str]:
        try:
            return point.index, _run(point, folder, threads, progress.advance)
        except Exception as error:
            return point.index, reason(error)

    if workers == 1 or len(points) == 1:
        yield from map(run, points)
        return
    from joblib import Parallel, delayed

    pool = Parallel(n_jobs=workers, backend="threading", return_as="generator_unordered")
    yield from pool(delayed(run)(point) for point in points)


def _run(point: Point, folder: Path, threads: int, advance: Callable[[int], None]) -> PointResult:
    settings = point.model.monte_carlo
    problem = problem_of(point.model, folder)
    return run_point(problem, settings, point_key(settings, point.identities), threads, advance)


def _remote_outcomes(
    points: list[Point], folder: Path, address: str, progress: Progress
) -> Iterator[tuple[int, PointResult | str]]:
    """The points on the workers of a Dask cluster, as they finish."""
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise InputError("--dask needs the extra: pip install 'mcsim[dask]'") from None
    try:
        client = Client(address, timeout=_DASK_TIMEOUT)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"--dask {address}: no scheduler answers ({error})") from None
    with client:
        futures = client.map(_run_remotely, points, [folder] * len(points), pure=False)
        for future in as_completed(futures):  # type: ignore[no-untyped-call]
            index, outcome = future.result()
            if not isinstance(outcome, str):
                progress.advance(outcome.realizations)
            future.release()
            yield index, outcome


def _run_remotely(point: Point, folder: Path) -> tuple[int, PointResult | str]:
    try:
        return point.index, _run(point, folder, 1, lambda _: None)
    except Exception as error:
        return point.index, reason(error)
