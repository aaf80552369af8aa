"""How often time stamps are judged right: jitter, bursts, stale stamps, steps, and true losses.

    python -m benchmarks.time_stamps [--trials 4] [--rows 4000]

Samples are truly equally spaced, and lost at random with the probability of the column.  Right
is: without losses, none is found; with losses, their number within one or 10 %.  Below stands
how many of the lost samples were found.
"""

from __future__ import annotations

import argparse

import numpy as np

from mcsim.logs.clock import mend_clock
from mcsim.logs.timing import judge, unusable
from tests.reference.time_stamps import STAMPERS, true_times

LOSSES = (0.0, 0.0005, 0.005, 0.03)


def trial(name: str, loss: float, rows: int, seed: int) -> tuple[int, int, float]:
    """Lost samples, those found (-1: refused), and the error of the rate."""
    rng = np.random.default_rng([seed, int(1e6 * loss), list(STAMPERS).index(name)])
    rate, stamp = STAMPERS[name]
    index, step = true_times(rows, rate, loss, rng)
    clock = mend_clock(stamp(index, step, rng))
    lost = int(index[-1]) + 1 - rows
    if unusable(clock):
        return lost, -1, np.inf
    found = judge(clock)
    return lost, found.missing, found.rate / rate - 1.0


def is_right(lost: int, found: int) -> bool:
    """Within one or a tenth; none where none is lost."""
    return found == 0 if lost == 0 else abs(found - lost) <= max(1.0, 0.1 * lost)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=4)
    parser.add_argument("--rows", type=int, default=4000)
    arguments = parser.parse_args()
    print(f"{arguments.trials} logs of {arguments.rows} rows each")
    heads = ["none lost", *(f"{100 * loss:g} % lost" for loss in LOSSES[1:])]
    print(f"{'':30s}" + "".join(f"{head:>18s}" for head in heads) + f"{'rate (none lost)':>20s}")
    for name in STAMPERS:
        cells, rates = [], []
        for loss in LOSSES:
            trials = [trial(name, loss, arguments.rows, k) for k in range(arguments.trials)]
            right = np.mean([is_right(lost, found) for lost, found, _ in trials])
            lost = sum(t[0] for t in trials)
            share = f"{sum(t[1] for t in trials) / lost:.2f}" if lost else ""
            cells.append(f"{100 * right:8.0f} % {share:>7s}")
            rates.append(max(abs(t[2]) for t in trials))
        line = f"{name:30s}" + "".join(f"{cell:>18s}" for cell in cells)
        print(f"{line}{rates[0]:20.1e}", flush=True)
    print("right (per cent of the logs) and found samples per lost one; largest error of the rate")


if __name__ == "__main__":
    main()
