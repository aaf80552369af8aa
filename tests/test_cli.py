"""The command line as a user meets it: output, files and every exit code."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

import mcsim
from mcsim.cli.main import exit_code
from mcsim.papers import FIGURES
from tests.conftest import BASE_YAML


def run(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "mcsim", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        **options,
    )


@pytest.mark.slow
def test_run_writes_tables_and_pictures(scenario_file, tmp_path, capsys):
    path = scenario_file(BASE_YAML)
    assert exit_code(["run", str(path), "--output", str(tmp_path / "out")]) == 0
    out, err = capsys.readouterr()
    assert "table.csv" in out
    assert "4/4 points" in err  # plain lines: this is no terminal
    assert sorted(p.name for p in (tmp_path / "out" / "case").iterdir()) == [
        "budget.csv",
        "budget.parquet",
        "figure.png",
        "figure.svg",
        "provenance.json",
        "table.csv",
        "table.parquet",
    ]


@pytest.mark.slow
def test_single_runs_print_their_estimates(scenario_file, tmp_path, capsys):
    path = scenario_file(BASE_YAML)
    arguments = ["run", str(path), "--set", "sweep=null", "--realizations", "50", "--seed", "3"]
    assert exit_code([*arguments, "--output", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "along" in out
    assert "50 realizations" in out
    told = json.loads((tmp_path / "case" / "provenance.json").read_text())
    assert told["seed"] == 3


@pytest.mark.slow
def test_quiet_runs_say_nothing(scenario_file, tmp_path, capsys):
    path = scenario_file(BASE_YAML)
    assert exit_code(["run", str(path), "--quiet", "--output", str(tmp_path)]) == 0
    assert capsys.readouterr() == ("", "")


def test_dry_run_writes_nothing(scenario_file, tmp_path, capsys):
    path = scenario_file(BASE_YAML)
    assert exit_code(["run", str(path), "--dry-run", "--output", str(tmp_path / "out")]) == 0
    out = capsys.readouterr().out
    assert "4 point(s), 200 realizations each" in out
    assert "271 samples" in out
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["--jobs", "0"],
        ["--set", "nonsense"],
        ["--seed", "-1"],
        ["--realizations", "0"],
        ["--no-such-option"],
    ],
)
def test_bad_options_exit_with_2_and_write_nothing(scenario_file, tmp_path, arguments, capsys):
    text = BASE_YAML if arguments else BASE_YAML.replace("100 Hz", "100")
    path = scenario_file(text)
    code = exit_code(["run", str(path), *arguments, "--output", str(tmp_path / "out")])
    out, err = capsys.readouterr()
    assert code == 2
    assert "Traceback" not in err
    assert out == ""
    assert not (tmp_path / "out").exists()


def test_one_bad_scenario_stops_all_before_they_run(scenario_file, tmp_path, capsys):
    good = scenario_file(BASE_YAML, "good.yaml")
    bad = scenario_file(BASE_YAML.replace("fir", "fri"), "bad.yaml")
    assert exit_code(["run", str(good), str(bad), "--output", str(tmp_path / "out")]) == 2
    assert "bad.yaml:5" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_two_scenarios_of_one_name_are_refused(scenario_file, tmp_path, capsys):
    path = scenario_file(BASE_YAML)
    assert exit_code(["run", str(path), str(path), "--output", str(tmp_path)]) == 2
    assert "share a folder" in capsys.readouterr().err


@pytest.mark.slow
def test_failing_points_exit_with_3(scenario_file, tmp_path, capsys, monkeypatch):
    import mcsim.sweep as sweep_module

    real = sweep_module.problem_of

    def sometimes(model, folder):
        if model.sensors.accelerometer.noise_density == (1e-2,):
            raise MemoryError("no room")
        return real(model, folder)

    monkeypatch.setattr(sweep_module, "problem_of", sometimes)
    path = scenario_file(BASE_YAML)
    assert exit_code(["run", str(path), "--output", str(tmp_path)]) == 3
    err = capsys.readouterr().err
    assert "2 point(s) failed" in err
    assert "noise_density = 0.01 m/s^2/√Hz" in err
    assert (tmp_path / "case" / "table.csv").exists()


def test_unexpected_errors_exit_with_1(scenario_file, tmp_path, capsys, monkeypatch):
    import mcsim.api.run as api

    def broken(*_, **__):
        raise RuntimeError("the sky fell")

    monkeypatch.setattr(api, "run_sweep", broken)
    path = scenario_file(BASE_YAML)
    assert exit_code(["run", str(path), "--output", str(tmp_path)]) == 1
    err = capsys.readouterr().err
    assert "the sky fell" in err
    assert "Traceback" not in err


@pytest.mark.slow
def test_interrupted_runs_exit_with_130_and_go_on_later(scenario_file, tmp_path):
    """Ctrl-C in the middle of a real process; the second call starts from the checkpoint."""
    path = scenario_file(
        BASE_YAML.replace("realizations: 200", "realizations: 400000").replace(
            "[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]",
            "{from: 1e-3 m/s^2/√Hz, to: 1e-2 m/s^2/√Hz, points: 40}",
        )
    )
    out = tmp_path / "out"
    process = subprocess.Popen(
        [sys.executable, "-m", "mcsim", "run", str(path), "--output", str(out), "--jobs", "2"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 100
    while time.monotonic() < deadline:
        kept = list((out / "case").glob(".checkpoint-*"))
        if kept and kept[0].stat().st_size > 0:
            break
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert "the same command goes on from there" in err
    assert "Traceback" not in err
    assert [p.name[:12] for p in (out / "case").iterdir()] == [".checkpoint-"]


def test_an_interruption_while_code_is_made_has_the_same_exit_code(tmp_path):
    """CPython ends by a signal after an interruption inside `exec`, even if it was handled."""
    (tmp_path / "interrupted.py").write_text(
        "import click, mcsim\n"
        "from mcsim.cli import main\n"
        "made = click.Command('made', callback=lambda: exec('raise KeyboardInterrupt'))\n"
        "mcsim.add(mcsim.Command('made', made))\n"
        "main(['made'])\n"
    )
    command = [sys.executable, "-m", "interrupted"]
    paths = os.pathsep.join([str(tmp_path), str(Path(mcsim.__file__).parent.parent)])
    environment = {**os.environ, "PYTHONPATH": paths}
    result = subprocess.run(command, capture_output=True, check=False, env=environment)
    assert result.returncode == 130, result.stderr


def test_validate_checks_without_running(scenario_file, tmp_path, capsys):
    good = scenario_file(BASE_YAML, "good.yaml")
    bad = scenario_file(BASE_YAML.replace("20 m/s", "20"), "bad.yaml")
    assert exit_code(["validate", str(good)]) == 0
    assert "valid, 4 point(s)" in capsys.readouterr().out
    assert exit_code(["validate", str(good), str(bad), str(tmp_path)]) == 2
    err = capsys.readouterr().err
    assert "bad.yaml:2: trajectory.speed" in err
    assert "is a directory" in err


def test_schema_is_draft_7(capsys):
    assert exit_code(["schema"]) == 0
    assert "draft-07" in json.loads(capsys.readouterr().out)["$schema"]


def test_sensors_are_listed_with_their_sources(capsys):
    assert exit_code(["sensors"]) == 0
    assert "LSM330DL" in capsys.readouterr().out
    assert exit_code(["sensors", "lsm330dl"]) == 0
    out = capsys.readouterr().out
    assert "2.2e-3 m/s²/√Hz" in out
    assert "source: Table 1 of the planar" in out
    assert exit_code(["sensors", "LSM330"]) == 2
    assert "did you mean" in capsys.readouterr().err


@pytest.mark.slow
def test_plot_draws_a_stored_result_again(scenario_file, tmp_path, capsys):
    path = scenario_file(BASE_YAML)
    assert exit_code(["run", str(path), "--quiet", "--output", str(tmp_path)]) == 0
    picture = tmp_path / "case" / "figure.png"
    before = picture.read_bytes()
    picture.unlink()
    assert exit_code(["plot", str(tmp_path / "case")]) == 0
    assert picture.read_bytes() == before
    assert exit_code(["plot", str(tmp_path / "case" / "table.csv")]) == 0
    assert exit_code(["plot", str(tmp_path / "case"), "--output", str(tmp_path / "new")]) == 0
    assert (tmp_path / "new" / "case" / "figure.svg").exists()
    assert exit_code(["plot", str(tmp_path)]) == 2
    assert "holds no table.csv" in capsys.readouterr().err


def test_unknown_figures_are_refused(capsys):
    assert exit_code(["figures", "7"]) == 2
    assert '"7" is not one of 1, 2, 3, 4, 5, 10' in capsys.readouterr().err


@pytest.mark.slow
def test_composed_figures_are_drawn(tmp_path, monkeypatch):
    """Figure 5 has two scenarios; fewer realizations make it quick."""
    real = FIGURES["5"]

    def quick():
        return [s.with_values({"monte_carlo.realizations": 20}) for s in real.scenarios()]

    monkeypatch.setitem(FIGURES._parts, "5", replace(real, scenarios=quick))
    assert exit_code(["figures", "5", "--quiet", "--output", str(tmp_path)]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "figure5",
        "figure5a_speed",
        "figure5b_width",
    ]
    assert (tmp_path / "figure5" / "figure.png").stat().st_size > 10_000
    # Its halves are not drawn once more, each alone.
    assert {p.parent.name for p in tmp_path.rglob("*.png")} == {"figure5"}


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from mcsim.cli.main import exit_code; exit_code(['--help']);"
        "print(sorted({'numba', 'numpy', 'scipy', 'matplotlib', 'pandas', 'pydantic'}"
        " & sys.modules.keys()))"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout.strip().endswith("[]")


@pytest.mark.slow
def test_a_plain_run_does_not_import_what_takes_a_second(scenario_file, tmp_path):
    path = scenario_file(BASE_YAML)
    code = (
        "import sys; from mcsim.cli.main import exit_code;"
        f"exit_code(['run', {str(path)!r}, '--quiet', '--output', {str(tmp_path)!r}]);"
        "print(sorted({'scipy.signal', 'scipy.stats', 'dask', 'rosbags'} & sys.modules.keys()))"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == "[]"


@pytest.mark.slow
def test_messages_reach_a_closed_pipe_quietly(scenario_file):
    path = scenario_file(BASE_YAML)
    result = subprocess.run(
        f"{sys.executable} -m mcsim schema | head -1; {sys.executable} -m mcsim validate {path}",
        shell=True,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    assert "Traceback" not in result.stderr


def test_module_runs_as_a_program():
    result = run("--version")
    assert result.returncode == 0
    assert result.stdout.startswith("mcsim, version")


@pytest.mark.slow
def test_if_no_point_can_run_the_old_result_stays(scenario_file, tmp_path, capsys, monkeypatch):
    import mcsim.sweep as sweep_module

    path = scenario_file(BASE_YAML)
    assert exit_code(["run", str(path), "--quiet", "--output", str(tmp_path)]) == 0
    before = {p.name: p.read_bytes() for p in (tmp_path / "case").iterdir()}

    def never(*_):
        raise MemoryError("no room")

    monkeypatch.setattr(sweep_module, "problem_of", never)
    arguments = ["run", str(path), "--seed", "2", "--output", str(tmp_path)]
    assert exit_code(arguments) == 1
    assert "no point could be run, nothing was written: MemoryError: no room" in (
        capsys.readouterr().err
    )
    assert {p.name: p.read_bytes() for p in (tmp_path / "case").iterdir()} == before


@pytest.mark.slow
def test_a_kill_while_drawing_loses_nothing(scenario_file, tmp_path, monkeypatch):
    import mcsim.figures.saving as figures

    real = figures.save_figures

    def interrupted(*_):
        raise KeyboardInterrupt

    arguments = ["run", str(scenario_file(BASE_YAML)), "--quiet", "--output", str(tmp_path)]
    monkeypatch.setattr(figures, "save_figures", interrupted)
    assert exit_code(arguments) == 130
    assert list((tmp_path / "case").glob(".checkpoint-*"))
    monkeypatch.setattr(figures, "save_figures", real)
    assert exit_code(arguments) == 0
    assert not list((tmp_path / "case").glob(".checkpoint-*"))


@pytest.mark.slow
def test_figures_can_be_left_out_and_drawn_later(scenario_file, tmp_path, capsys):
    path = scenario_file(BASE_YAML + "outputs: {tracks: 3}\n")
    folder = tmp_path / "case"
    pictures = {"figure.png", "figure.svg", "tracks.png", "tracks.svg"}
    assert exit_code(["run", str(path), "--quiet", "--output", str(tmp_path)]) == 0
    with_pictures = {p.name for p in folder.iterdir()}
    assert pictures < with_pictures
    capsys.readouterr()
    # Pictures of an earlier run go: they would not belong to the new tables.
    assert exit_code(["run", str(path), "--no-figures", "--output", str(tmp_path)]) == 0
    assert {p.name for p in folder.iterdir()} == with_pictures - pictures
    assert "figure.png" not in capsys.readouterr().out
    assert exit_code(["plot", str(folder)]) == 0
    assert {p.name for p in folder.iterdir()} == with_pictures


@pytest.mark.slow
def test_too_many_histories_are_refused_before_the_run(scenario_file, tmp_path, capsys):
    path = scenario_file(BASE_YAML + "outputs: {history: true, tracks: 1000}\n")
    more = "sweep.trajectory.speed={from: 1 m/s, to: 9 m/s, points: 200}"
    assert exit_code(["validate", str(path)]) == 0
    arguments = ["run", str(path), "--set", more, "--output", str(tmp_path / "out")]
    assert exit_code(arguments) == 2
    assert "histories and tracks of 800 points need" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_damaged_results_are_explained(scenario_file, tmp_path, capsys):
    path = scenario_file(BASE_YAML)
    assert exit_code(["run", str(path), "--quiet", "--output", str(tmp_path)]) == 0
    (tmp_path / "case" / "table.parquet").unlink()
    table = tmp_path / "case" / "table.csv"
    table.write_text(table.read_text().replace("statistic", "static"))
    assert exit_code(["plot", str(tmp_path / "case")]) == 2
    assert "not the table that provenance.json beside it tells of" in capsys.readouterr().err


@pytest.mark.slow
def test_kernels_run_without_a_folder_for_compiled_code():
    """As on a machine where numba finds no folder that it may write to."""
    code = (
        "import numba.core.caching as caching;"
        "caching.CacheImpl._locator_classes = [];"
        "import mcsim.kernels.bootstrap as b, mcsim.kernels.compilation as c, numpy as np;"
        "n = np.empty((4, 4), np.uint8); b.resampling_counts(np.uint64(1), n);"
        "print(n.sum(), c.unkept)"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith("16 ['resampling_counts'")


@pytest.mark.slow
def test_cached_kernels_notice_changes_of_what_they_inline(tmp_path):
    """A kernel of bootstrap.py is compiled anew after an edit of random.py, and only then."""
    package = tmp_path / "mcsim"
    shutil.copytree(
        Path(mcsim.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__")
    )
    code = (
        "import numpy as np, mcsim.kernels.bootstrap as b; c = np.empty((9, 9), np.uint8);"
        "b.resampling_counts(np.uint64(1), c);"
        "print(c.tobytes().hex(), sum(b.resampling_counts.stats.cache_hits.values()))"
    )

    def counts() -> list[str]:
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        result = subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            check=True,
            cwd=tmp_path,
            env=environment,
        )
        return result.stdout.split()

    first, again = counts(), counts()
    assert (first[1], again[1]) == ("0", "1")
    source = package / "kernels" / "random.py"
    source.write_text(source.read_text().replace("_rotate_left(s3, 11)", "_rotate_left(s3, 12)"))
    changed = counts()
    assert changed[1] == "0"
    assert changed[0] != first[0] == again[0]
