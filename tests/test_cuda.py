"""The scalar functions of the kernels run under CUDA (its simulator: no GPU is needed)."""

import os
import subprocess
import sys

import numpy as np
import pytest

from mcsim.kernels import planar
from mcsim.simulation.running import Sensors, run
from tests.conftest import problem
from tests.reference import random_numpy

COUNT, SAMPLES, KEY = 8, 40, 2**63 + 12345


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """What the CUDA simulator made, and the CPU's errors of the same realizations."""
    folder = tmp_path_factory.mktemp("cuda")
    p = problem()
    signals = np.ascontiguousarray(p.signals[: SAMPLES + 1])
    t, start = p.interval, p._start
    vector = np.array(
        [
            np.cos(start.heading),
            np.sin(start.heading),
            start.speed / t,
            0.0,
            start.along / t**2,
            start.across / t**2,
        ]
    )
    np.savez(
        folder / "given.npz",
        key=np.array([KEY], np.uint64),
        signals=signals,
        white=p.sensor_errors.white,
        start=vector,
        count=COUNT,
    )
    subprocess.run(
        [sys.executable, "-m", "tests.reference.planar_cuda", "given.npz", "result.npz"],
        env={
            **os.environ,
            "NUMBA_ENABLE_CUDASIM": "1",
            "MCSIM_TARGET": "cuda",
            "PYTHONPATH": os.pathsep.join(sys.path),
        },
        cwd=folder,
        check=True,
        capture_output=True,
    )
    origin = planar.Motion(0.0, 0.0, 0.0, 0.0, 0.0)
    system = p.system(p.measurement, disturbed=True)._replace(end=origin)
    sensors = Sensors(signals, p.sensor_errors.white, p.measurement.terms)
    errors, _ = run(system, KEY, 0, COUNT, sensors)
    return dict(np.load(folder / "result.npz")), errors, t


def test_words_are_the_same_to_the_bit(both):
    result, _, _ = both
    state = random_numpy.stream_words(KEY, np.arange(COUNT), 0, 0)
    for words in result["words"]:
        expected, state = random_numpy.xoshiro(state)
        np.testing.assert_array_equal(words, expected)


def test_normals_and_end_states_are_the_same_to_rounding(both):
    """Only the fused multiplications differ between the two compilers."""
    result, errors, t = both
    words = result["words"].astype(np.uint64)
    exact = random_numpy.normal_pair(words[::2], words[1::2])
    np.testing.assert_allclose((result["normals"][::2], result["normals"][1::2]), exact, atol=1e-5)
    c, s, vl, vd, pl, pd = result["ends"]
    np.testing.assert_allclose([t * t * pl, t * t * pd], errors[:2], rtol=0, atol=1e-8)
    np.testing.assert_allclose(np.arctan2(s, c), errors[3], rtol=0, atol=1e-8)
    np.testing.assert_allclose(np.arctan2(vd, vl), errors[4], rtol=0, atol=1e-8)
    assert np.std(errors[0]) > 1e-5  # realizations differ by far more than rounding
