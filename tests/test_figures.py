"""Pictures: they are made, with the axes, curves, bars and lines that they should have."""

import numpy as np
import pytest
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.text import Text

import mcsim
from mcsim import Scenario
from mcsim.figures.tracks import PICTURE as TRACKS
from mcsim.figures.tracks import draw_over_time
from mcsim.figures.whole import draw, draw_side_by_side
from tests import strapdown
from tests.conftest import BASE_YAML, scenario

DENSITY = "sensors.gyroscope.noise_density"


@pytest.fixture(scope="module")
def swept():
    return mcsim.run(
        Scenario.from_yaml(
            BASE_YAML,
            [
                "sweep.sensors.accelerometer.noise_density="
                "{from: 2e-5 m/s²/√Hz, to: 0.2 m/s²/√Hz, points: 5, scale: log}",
                "figure={limits: {position: 0.1 m, angle: 1 °}, method: true}",
            ],
        )
    )


def panels(figure: Figure):
    figure.draw_without_rendering()
    return [axes for axes in figure.axes if axes.get_visible()]


def test_sweeps_have_a_panel_per_error_and_a_curve_per_value(swept):
    axes = panels(draw(swept))
    labels = [a.get_ylabel() for a in axes]
    assert labels == [
        "along-road error, RMS [m]",
        "across-road error, RMS [m]",
        "heading error, RMS [°]",
        "course error, RMS [°]",
    ]
    for a in axes:
        curves = [c for c in a.containers if isinstance(c, ErrorbarContainer)]
        assert [c.get_label() for c in curves] == ["0.03 °/s/√Hz", "0.3 °/s/√Hz"]
        assert all(c.has_yerr for c in curves)
        assert a.get_xlabel() == "accelerometer noise density [m/s²/√Hz]"
        assert a.get_xscale() == "log"
        assert a.get_yscale() == "log"
        ticks = [t.get_text() for t in (*a.get_xticklabels(), *a.get_yticklabels())]
        assert "10⁻³" in ticks
        assert not any("$" in t for t in ticks)


def test_curves_hold_the_tables_numbers(swept):
    axes = panels(draw(swept))[0]
    table = swept.table
    wanted = table[(table["error"] == "along") & (table["statistic"] == "rms")]
    wanted = wanted[wanted[table.columns[1]] == 0.3]
    line = axes.containers[1].lines[0]
    np.testing.assert_array_equal(line.get_ydata(), wanted["value"])
    np.testing.assert_array_equal(line.get_xdata(), wanted[table.columns[0]])
    segments = axes.containers[1].lines[2][0].get_segments()
    np.testing.assert_allclose([s[0][1] for s in segments], wanted["ci_low"])
    np.testing.assert_allclose([s[1][1] for s in segments], wanted["ci_high"])


def test_requirement_lines_are_drawn_in_the_tables_units(swept):
    for axes, limit in zip(panels(draw(swept)), (0.1, 0.1, 1.0, 1.0), strict=True):
        heights = [line.get_ydata()[0] for line in axes.lines if len(line.get_ydata()) == 2]
        assert any(h == pytest.approx(limit) for h in heights)
        assert axes.get_ylim()[0] < limit < axes.get_ylim()[1]


def test_legends_cover_no_data(swept):
    figure = draw(swept)
    figure.draw_without_rendering()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    for axes in panels(figure):
        assert not box.overlaps(axes.get_window_extent())


def test_texts_do_not_overlap_axes(swept):
    figure = draw(swept)
    figure.draw_without_rendering()
    boxes = [a.get_tightbbox() for a in panels(figure)]
    for i, a in enumerate(boxes):
        for b in boxes[i + 1 :]:
            assert not a.overlaps(b)


def test_one_dimensional_sweeps_and_names_on_axes():
    s = scenario(
        {
            "sweep": {"sensors.sampling": ["fir", "none", "average"]},
            "monte_carlo.realizations": 20,
            "figure": {"panels": [{"errors": ["along", "across"]}, {"errors": "heading"}]},
        }
    )
    axes = panels(draw(mcsim.run(s)))
    assert [t.get_text() for t in axes[0].get_xticklabels()] == ["fir", "none", "average"]
    assert len(axes[0].containers) == 2


@pytest.mark.slow
def test_a_third_axis_stands_side_by_side():
    s = scenario(
        {
            "sweep": {
                "trajectory.width": ["1 m", "2 m"],
                "trajectory.speed": ["10 m/s", "20 m/s"],
                "sensors.rate": ["50 Hz", "100 Hz"],
            },
            "monte_carlo.realizations": 20,
        }
    )
    axes = panels(draw(mcsim.run(s)))
    assert len(axes) == 8
    assert "50 Hz" in axes[0].get_title()
    assert "100 Hz" in axes[1].get_title()


@pytest.mark.slow
def test_several_sweeps_side_by_side(swept):
    figure = draw_side_by_side([swept, swept], "both")
    assert len(panels(figure)) == 8
    assert figure.get_suptitle() == "both"


def test_single_runs_show_their_estimates():
    axes = panels(draw(mcsim.run(scenario({"monte_carlo.realizations": 50}))))
    assert len(axes) == 2
    assert len(axes[0].containers) == 5


def test_undefined_errors_leave_gaps():
    s = scenario(
        {
            "sweep": {"trajectory.deceleration": ["0 m/s²", "2 m/s²", "6 m/s²"]},
            "monte_carlo.realizations": 20,
        }
    )
    axes = panels(draw(mcsim.run(s)))
    assert np.isnan(axes[3].containers[0].lines[0].get_ydata()).tolist() == [False, False, True]


def test_histories_are_fans_and_tracks_end_in_an_ellipse():
    s = scenario({"monte_carlo.realizations": 100, "outputs": {"history": True, "tracks": 20}})
    figure = draw_over_time(mcsim.run(s))
    axes = panels(figure)
    assert len(axes) == 6
    assert len(axes[0].lines) == 22  # 20 tracks, the truth, a legend entry
    assert len(axes[1].patches) == 1
    assert all(len(a.collections) == 2 for a in axes[2:])


def test_the_ellipse_holds_the_ends_it_should():
    """A 3 sigma ellipse of a plane normal distribution holds 1 - exp(-9/2) = 98.9 % of it."""
    s = scenario({"monte_carlo.realizations": 10, "outputs": {"tracks": 400}})
    axes = panels(draw_over_time(mcsim.run(s)))[1]
    ends = np.column_stack(axes.lines[0].get_data())
    inside = (
        axes.patches[0]
        .get_path()
        .contains_points(axes.patches[0].get_patch_transform().inverted().transform(ends))
    )
    assert 0.97 <= inside.mean() <= 1.0
    assert axes.patches[0].width > 0


def test_runs_without_tracks_draw_none():
    assert not TRACKS.wants(mcsim.run(scenario({"monte_carlo.realizations": 10})))


@pytest.mark.slow
def test_panels_of_different_paths_hold_the_others():
    """In a 3-D sweep each curve joins points of one slice only."""
    s = scenario(
        {
            "sweep": {
                "trajectory.width": ["1 m", "2 m"],
                "trajectory.speed": ["10 m/s", "15 m/s", "20 m/s"],
                "trajectory.length": ["40 m", "50 m"],
            },
            "monte_carlo.realizations": 20,
            "figure": {
                "panels": [
                    {"errors": "along", "x": "trajectory.width", "curves": "trajectory.length"},
                    {"errors": "along", "x": "trajectory.speed", "curves": "trajectory.width"},
                ]
            },
        }
    )
    one, two = panels(draw(mcsim.run(s)))
    assert [len(c.lines[0].get_xdata()) for c in one.containers] == [2, 2]
    assert [len(c.lines[0].get_xdata()) for c in two.containers] == [3, 3]
    assert one.get_title() == "at speed 10 m/s"
    assert two.get_title() == "at track length L 40 m"


def test_titles_are_plain_text_and_fit():
    s = scenario(
        {
            "title": r"cost $5 and $\foo$ " + "of a very long title " * 12,
            "sweep": {"trajectory.width": ["1 m", "2 m"]},
            "monte_carlo.realizations": 20,
            "figure": {"panels": [{"errors": "position"}]},
        }
    )
    figure = draw(mcsim.run(s))
    figure.draw_without_rendering()
    box = figure._suptitle.get_window_extent()
    assert box.x0 >= 0
    assert box.x1 <= figure.bbox.x1
    (legend,) = figure.legends
    assert legend.get_window_extent().x0 >= 0


def test_long_legends_stand_beside_the_panels():
    s = scenario(
        {
            "sweep": {
                "trajectory.width": ["1 m", "2 m"],
                "trajectory.speed": ["10 m/s", "12 m/s", "15 m/s", "20 m/s"],
            },
            "monte_carlo.realizations": 20,
            "figure": {"panels": [{"errors": ["along", "across", "position"]}]},
        }
    )
    figure = draw(mcsim.run(s))
    figure.draw_without_rendering()
    (legend,), (axes,) = figure.legends, panels(figure)
    assert legend.get_window_extent().x0 > axes.get_window_extent().x1
    assert axes.get_window_extent().height > 0.5 * figure.bbox.height


def test_tracks_are_drawn_where_words_are_swept():
    words = {"sweep": {"sensors.sampling": ["fir", "none"]}, "outputs.tracks": 12}
    results = mcsim.run(scenario({**words, "monte_carlo.realizations": 50}))
    figure = draw_over_time(results)
    assert len(panels(figure)) == 2


def test_remarked_points_are_hollow_and_zeros_stay_in_view():
    """Without gyroscope noise roll and pitch have no error at all, on axes over decades."""
    densities = [f"{x} °/s/√Hz" for x in (0, 1e-3, 0.1)]
    tree = {"monte_carlo.realizations": 50, "sweep": {DENSITY: densities}}
    s = strapdown.scenario(tree)
    results = mcsim.run(s)
    figure = draw(results)
    assert any("triangles: exactly zero" in text.get_text() for text in figure.findobj(Text))
    markers = [line.get_marker() for axes in figure.axes for line in axes.lines]
    assert "v" in markers
    hollow = [
        line
        for axes in figure.axes
        for line in axes.lines
        if line.get_markerfacecolor() == "white" and line.get_marker() != "v"
    ]
    # All realizations are equal where nothing disturbs, and the table says so.
    assert hollow
