"""A sweep on a real Dask cluster of two worker processes gives the same table, bit for bit."""

import subprocess
import sys

import pytest

from mcsim import InputError
from mcsim.sweep import run_sweep
from tests.conftest import scenario

SCRIPT = """
import sys
import pandas as pd
import mcsim
from distributed import LocalCluster

if __name__ == "__main__":
    scenario = mcsim.Scenario.from_yaml(sys.argv[1])
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        there = mcsim.run(scenario, dask=cluster.scheduler_address)
    here = mcsim.run(scenario, jobs=1)
    pd.testing.assert_frame_equal(there.table, here.table, check_exact=True)
    pd.testing.assert_frame_equal(there.budget, here.budget, check_exact=True)
    print("the same", len(here.table))
"""


@pytest.mark.slow
def test_a_cluster_gives_the_same_table(tmp_path, scenario_file):
    from tests.conftest import BASE_YAML

    script = tmp_path / "cluster.py"
    script.write_text(SCRIPT)
    result = subprocess.run(
        [sys.executable, str(script), str(scenario_file(BASE_YAML))],
        capture_output=True,
        text=True,
        check=False,
        timeout=180,
    )
    assert "the same 120" in result.stdout, result.stderr


def test_a_missing_scheduler_is_explained(monkeypatch):
    import mcsim.sweep as sweep

    monkeypatch.setattr(sweep, "_DASK_TIMEOUT", "0.5s")
    with pytest.raises(InputError, match="no scheduler answers"):
        run_sweep(scenario({"monte_carlo.realizations": 10}), dask="tcp://127.0.0.1:9")
