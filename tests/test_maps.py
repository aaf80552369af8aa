"""Maps of two swept parameters, and sweeps that are written on the command line."""

import math

import numpy as np
import pytest
from matplotlib.figure import Figure

import mcsim
from mcsim import InputError, Scenario
from mcsim.cli.main import exit_code
from mcsim.figures.contours import LIMIT, Lines
from mcsim.figures.maps import _edges, draw_map
from mcsim.papers.shipped import shipped_scenarios
from mcsim.scenario_file.sweeping import swept_anew
from tests.conftest import BASE_YAML

SPEED, RATE = 10.0, 100.0
STRAIGHT = f"""\
case: planar
trajectory: {{shape: straight, length: 50 m, speed: {SPEED:g} m/s, lead: 0 s}}
sensors:
  rate: {RATE:g} Hz
  sampling: none
  accelerometer: {{noise_density: 1e-3 m/s²/√Hz}}
  gyroscope: {{noise_density: 0 °/s/√Hz}}
monte_carlo: {{realizations: 50, seed: 1, estimator: linear}}
figure: {{limits: {{position: 0.05 m}}, panels: [{{errors: along}}, {{errors: heading}}]}}
"""
NOISE = "sensors.accelerometer.noise_density"
SWEEPS = ["trajectory.length=20..640 m:6 log", f"{NOISE}=1e-4..1 m/s²/√Hz:5 log"]


@pytest.fixture(scope="module")
def straight():
    return mcsim.run(swept_anew(Scenario.from_yaml(STRAIGHT), SWEEPS, as_map=True))


def deviation(density, length):
    """Error along of white noise that is integrated twice: ND √(t³/6), the rule's sums exact."""
    n = round(length / SPEED * RATE)
    sample = density * math.sqrt(0.5 * RATE) / RATE**2
    return sample * math.sqrt(n * (n + 1.0) * (2.0 * n + 1.0) / 6.0)


def contours(axes):
    return [c for c in axes.collections if c.get_gid() == LIMIT]


def test_the_limit_is_where_the_closed_form_has_it(straight):
    """On logarithmic axes the contour of a power law is straight between any two points."""
    figure = draw_map(straight)
    (bold,) = contours(figure.axes[0])
    points = np.concatenate([path.vertices for path in bold.get_paths()])
    assert points[:, 0].min() == pytest.approx(20.0)
    assert points[:, 0].max() == pytest.approx(640.0)
    for length, density in points:
        assert deviation(density, length) == pytest.approx(0.05, rel=0.02)
    # Control: drawn through the values themselves the line bends far from it.
    table = straight.table
    rows = table[(table["error"] == "along") & (table["statistic"] == "rms")]
    x, y = straight.scenario.axes
    values = rows["value"].to_numpy().reshape(len(x.values), len(y.values)).T
    plain = Lines(Figure().subplots(), x, y, values, log=False).draw(np.array([0.05]), "{}")
    off = [deviation(d, length) for path in plain.get_paths() for length, d in path.vertices]
    assert max(off) > 0.06 or min(off) < 0.04


def test_colours_are_the_table_s_values_in_their_places(straight):
    axes = draw_map(straight).axes[0]
    mesh = axes.collections[0]
    x, y = straight.scenario.axes
    shown = mesh.get_array()
    table = straight.table
    rows = table[(table["error"] == "along") & (table["statistic"] == "rms")]
    for length, density, value in zip(rows[x.column], rows[y.column], rows["value"], strict=True):
        assert shown[y.values.index(density), x.values.index(length)] == value
    corners = mesh.get_coordinates()
    for j, length in enumerate(x.values):
        assert corners[0, j, 0] < length < corners[0, j + 1, 0]


def test_what_is_exactly_zero_has_no_logarithm(straight):
    """The heading has no error at all here: it is drawn, without a limit or lines."""
    figure = draw_map(straight)
    figure.draw_without_rendering()
    heading = figure.axes[1]
    assert not contours(heading)
    assert {text.get_text() for text in heading.texts} == {"0"}
    bar = next(a for a in figure.axes if a.get_ylabel().startswith("along"))
    assert bar.get_ylabel() == "along-road error, RMS [m]"


def test_edges_lie_between_the_points():
    np.testing.assert_allclose(_edges(np.array([1.0, 3.0, 4.0]), False), [0.0, 2.0, 3.5, 4.5])
    np.testing.assert_allclose(_edges(np.array([1.0, 100.0]), True), [0.1, 10.0, 1000.0])


def test_a_third_axis_stands_in_columns_and_missing_values_are_grey():
    speeds = "trajectory.speed=[5 m/s, 10 m/s, 20 m/s]"
    drives = "trajectory.deceleration=0..2 m/s²:3"
    scenario = Scenario.from_yaml(BASE_YAML, ["monte_carlo.estimator=linear"])
    lengths = "trajectory.length=20..80 m:3"
    results = mcsim.run(swept_anew(scenario, [lengths, drives, speeds], as_map=True))
    figure = draw_map(results)
    panels = [axes for axes in figure.axes if axes.get_xlabel()]
    assert len(panels) == 4 * 3  # errors, speeds
    titles = [axes.get_title() for axes in panels[:3]]
    assert titles == ["speed 5 m/s", "speed 10 m/s", "speed 20 m/s"]
    limits = {tuple(axes.collections[0].get_clim()) for axes in panels[:6]}
    assert len(limits) == 1  # along and across, one unit: one scale
    course = panels[9].collections[0].get_array()
    assert np.ma.is_masked(course)  # the slow vehicle stops
    assert any("grey: no value" in text.get_text() for text in figure.texts)


PAIRS = [
    ("sensors.time_jitter=1..1000 µs:2 log", "trajectory.lead=50..200 ms:2"),
    ("monte_carlo.seed=[1, 2]", "sensors.accelerometer.misalignment=0.1..1 °:2"),
]


@pytest.mark.parametrize("pair", PAIRS)
def test_any_two_numbers_make_a_map(pair):
    scenario = Scenario.from_yaml(BASE_YAML, ["monte_carlo.realizations=20"])
    results = mcsim.run(swept_anew(scenario, pair, as_map=True))
    assert [axis.path for axis in results.scenario.axes] == [p.split("=")[0] for p in pair]
    draw_map(results).draw_without_rendering()


def test_a_range_on_the_command_line_is_that_of_a_file():
    written = Scenario.from_yaml(
        STRAIGHT + "sweep:\n"
        "  trajectory.length: {from: 20 m, to: 640 m, points: 6, scale: log}\n"
        "  sensors.rate: {from: 20 Hz, to: 100 Hz, points: 9}\n"
        "  trajectory.speed: [5 m/s, 10 m/s]\n"
    )
    sweeps = [
        "trajectory.length = 20 .. 640 m : 6 log",
        "sensors.rate=20 Hz..100 Hz",
        "trajectory.speed=[5 m/s, 10 m/s]",
    ]
    assert swept_anew(Scenario.from_yaml(STRAIGHT), sweeps).axes == written.axes
    # Instead of those of the file, not beside them, and panels forget the file's axes.
    figure2 = Scenario.from_yaml(shipped_scenarios() / "paper" / "figure2.yaml")
    again = swept_anew(figure2, sweeps[:1])
    assert again.axes == written.axes[:1]
    assert [panel.errors for panel in again.base.panels] == [
        panel.errors for panel in figure2.base.panels
    ]
    assert swept_anew(figure2, []) is figure2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--sweep", "trajectory.length"], "write path=from..to"),
        (["--sweep", "trajectory.length=20 m"], "write path=from..to"),
        (["--sweep", "trajectory.length=20..640"], "has no unit"),
        (["--sweep", "trajectory.lenght=20..640 m"], 'did you mean "trajectory.length"'),
        (["--sweep", "trajectory.length=0..640 m:3 log"], "above zero"),
        (["--sweep", "trajectory.length=9..10 m"] * 2, "--sweep trajectory.length: is given twice"),
        (["--map"], "sweeps nothing; add two"),
        (["--map", "--sweep", "trajectory.length=20..640 m"], "needs two swept numbers"),
        (["--map", "--sweep", "sensors.sampling=[fir, none]"], "this sweep has 0"),
    ],
)
def test_slips_get_one_clear_message(options, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text(STRAIGHT)
    assert exit_code(["run", "case.yaml", *options]) == 2
    out, err = capsys.readouterr()
    assert message in err
    assert out == ""
    assert len(err.strip().splitlines()) == 1
    assert [file.name for file in tmp_path.iterdir()] == ["case.yaml"]


def test_a_map_needs_two_numbers_in_a_file_too():
    with pytest.raises(
        InputError, match=r"scenario:\d+: figure.map: a map needs two swept numbers"
    ):
        Scenario.from_yaml(
            STRAIGHT.replace("figure: {", "figure: {map: true, ")
            + "sweep: {trajectory.length: [20 m, 30 m]}\n"
        )


@pytest.mark.slow
def test_the_picture_is_written_drawn_again_and_removed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text(STRAIGHT)
    lengths, noises = "trajectory.length=20..80 m:2", f"{NOISE}=1..4 µg/√Hz:2"
    sweeps = ["--sweep", lengths, "--sweep", noises]
    assert exit_code(["run", "case.yaml", *sweeps, "--map"]) == 0
    assert "map.png" in capsys.readouterr().out
    folder = tmp_path / "output" / "case"
    drawn = (folder / "map.png").read_bytes()
    assert len(drawn) > 10_000
    (folder / "map.png").unlink()
    assert exit_code(["plot", str(folder)]) == 0
    assert (folder / "map.png").read_bytes() == drawn
    assert exit_code(["run", "case.yaml", *sweeps]) == 0
    assert not (folder / "map.png").exists()
