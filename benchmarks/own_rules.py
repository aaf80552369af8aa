"""Time of the rules in docs/examples, as a multiple of the shipped rule's that is nearest.

    python -m benchmarks.own_rules [ROUNDS]

One thread, interleaved, medians; one number with white noise and offsets alone, one with controls.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from benchmarks.__main__ import ALL_ERRORS, BASE, ROLLING, interleaved
from mcsim import Scenario
from mcsim.cli.own import run_own
from mcsim.systems import problem_of

EXAMPLES = BASE.parent.parent.parent / "docs" / "examples"
#: By a rule of one's own: a scenario, and the shipped rule.
RULES = {"midpoint": (BASE, "trapezoidal"), "levelling_filter": (ROLLING, "rectangular")}
REALIZATIONS = 12_800


def timed(file: Path, rule: str, controls: bool) -> Callable[[], int]:
    """Simulates, and says how many samples."""
    values = {"sweep": None, **ALL_ERRORS, "reconstruction.integration": rule}
    p = problem_of(Scenario.from_yaml(file, values).base, file.parent)

    def run() -> int:
        p.simulate(1, 0, REALIZATIONS, controls=controls)
        return REALIZATIONS * p.n_samples

    return run


def ratios(rounds: int) -> dict[str, float]:
    """Time per sample beside the shipped rule's."""
    found = {}
    for name, (file, shipped) in RULES.items():
        run_own(EXAMPLES / f"{name}.py")
        for controls in (False, True):
            ns = interleaved({r: timed(file, r, controls) for r in (name, shipped)}, rounds)
            words = f"{name} to {shipped}{', controls' if controls else ''}"
            found[words] = round(ns[name] / ns[shipped], 2)
    return found


if __name__ == "__main__":
    for words, ratio in ratios(int(sys.argv[1]) if sys.argv[1:] else 15).items():
        print(f"{words:45}{ratio}")
