"""The baselines that speeds are stated against do the same work as the kernel."""

import numpy as np
import pytest

from benchmarks.baselines import naive_numba, plain_numpy
from tests.conftest import problem

COUNT = 20_000


@pytest.mark.slow
@pytest.mark.parametrize("name", ["plain numpy", "naive numba"])
def test_baselines_give_the_kernels_statistics(name):
    p = problem()
    arguments = (p.signals, p.sensor_errors.white, p._start, p.interval, COUNT)
    if name == "plain numpy":
        ends = plain_numpy(*arguments, np.random.default_rng(3))
    else:
        ends = naive_numba(*arguments)
    ours = p.simulate(3, 0, COUNT).errors
    errors = ends - np.array([[p.truth.along[-1]], [p.truth.across[-1]]])
    for theirs, mine in zip(errors, ours, strict=False):
        # Two estimates of COUNT realizations each, five standard errors of their difference.
        assert abs(theirs.std() / mine.std() - 1.0) < 5 / np.sqrt(COUNT)
        assert abs(theirs.mean() - mine.mean()) < 5 * mine.std() * np.sqrt(2 / COUNT)
