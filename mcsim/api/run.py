"""``mcsim.run``: a scenario to its results, which are kept on disk."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from mcsim.checkpoints import Checkpoint
from mcsim.errors import McsimError
from mcsim.figures import PICTURES
from mcsim.results import Results, assemble, check
from mcsim.scenario_file import Scenario
from mcsim.store import FORMATS, save
from mcsim.sweep import Progress, run_sweep
from mcsim.writing import alone_in


def run(
    scenario: Scenario,
    *,
    jobs: int | None = None,
    output: str | Path | None = None,
    progress: Progress | None = None,
    draw: Callable[[Results, Path], object] | None = None,
    dask: str | None = None,
    formats: tuple[str, ...] = FORMATS,
) -> Results:
    """Run a scenario: every point of its sweep, all realizations, all statistics.

    Parameters
    ----------
    scenario : Scenario
        A single run is a sweep of one point.
    jobs : int, optional
        Number of threads; all processors if absent. Results do not depend on it.
    output : path, optional
        Folder in which ``<scenario name>/`` is written: tables, figures, provenance.
        Finished points are kept there while the sweep runs, and a later run of the
        same scenario goes on from them.
    progress : Progress, optional
        Hears how the run goes.
    draw : callable, optional
        Draws the results into their folder; the usual figures if absent.
    dask : str, optional
        Address of a Dask scheduler whose workers run the points (extra ``mcsim[dask]``).
    formats : tuple of str
        Of the tables in ``output``: ``csv``, ``parquet``.

    Returns
    -------
    Results

    Raises
    ------
    InputError
        A point that cannot run, or an output folder that cannot be written or that another
        run is writing into.
    McsimError
        No point could be run.
    """
    check(scenario)
    begun = time.perf_counter()
    if output is None:
        sweep = run_sweep(scenario, jobs, progress, dask=dask)
        return assemble(scenario, sweep, time.perf_counter() - begun)
    folder = Path(output) / scenario.name
    with alone_in(folder):
        checkpoint = Checkpoint.of(scenario, folder)
        done, damaged = checkpoint.recover()
        with checkpoint.writer() as keep:
            sweep = run_sweep(scenario, jobs, progress, done, keep, dask)
        if not sweep.points:
            raise McsimError(
                f"{scenario.name}: no point could be run, nothing was written: "
                f"{next(iter(sweep.failures.values()))}"
            )
        results = assemble(scenario, sweep, time.perf_counter() - begun)
        if damaged:
            results.provenance["remarks"].append(_recomputed(damaged))
        save(results, folder, formats, PICTURES)
        (draw or _draw)(results, folder)
        # Failed points are tried again by the same command; the others are kept till then.
        if not sweep.failures:
            checkpoint.remove()
    return results


def _recomputed(damaged: int) -> str:
    lines = "line" if damaged == 1 else "lines"
    return f"checkpoint: {damaged} damaged {lines} left out; what they held was computed again"


def _draw(results: Results, folder: Path) -> None:
    from mcsim.figures.saving import save_figures

    save_figures(results, folder)
