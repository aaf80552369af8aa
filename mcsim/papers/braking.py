"""The velocity paper's explanation of velocities below zero: the body swings back after braking."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.papers import PaperFigure
from mcsim.papers.shipped import shipped_scenarios, velocity_sensor
from mcsim.systems.velocity.problem import VelocityProblem
from mcsim.systems.velocity.scenario import VelocityScenario
from mcsim.systems.velocity.truth import true_run

Array = NDArray[np.float64]

_SCENARIO = "braking"
#: Natural frequencies (Hz) and heights (m) for which the lowest velocity after braking is drawn.
FREQUENCIES, HEIGHTS = np.geomspace(1.0, 10.0, 37), (0.0, 0.05, 0.1, 0.2)


@dataclass(frozen=True)
class Swing:
    """A run on its wheels, and what an accelerometer on the pitching body makes of it.

    Arrays (n + 1,) over ``time`` (s): velocity of the wheels and the error against it without
    sensor errors, whole and of gravity alone (m/s), uc of the mean by Eq. (31), pitch (rad).
    """

    time: Array
    wheels: Array
    error: Array
    by_gravity: Array
    uncertainty: Array
    pitch: Array


def error_over_time(model: VelocityScenario) -> Array:
    """Velocity less that of the wheels (n + 1,) in m/s without sensor errors, after every step."""
    problem = VelocityProblem.from_model(model)
    every = replace(problem, steps=np.arange(1, len(problem.raw) + 1))
    return np.append(0.0, every.method_errors()[0::3])


def swing_of(model: VelocityScenario) -> Swing:
    """The course of a run whose body pitches."""
    from mcsim.gum import course_of_uncertainty

    course, run = course_of_uncertainty(model), true_run(model, Path())
    still = run.motion(np.zeros(1)).tilt
    return Swing(
        course.time,
        course.truth,
        error_over_time(model),
        error_over_time(_with_body(model, height=0.0)),
        course.summed_mean,
        run.motion(course.time).tilt - still,
    )


def lowest_after_braking(model: VelocityScenario, frequency: float, height: float) -> float:
    """The lowest velocity (m/s) that is measured while the wheels stand after braking.

    The wheels stand from the last but one point of the profile on.
    """
    pitch = {"natural_frequency": frequency}
    error = error_over_time(_with_body(model, height=height, **pitch))
    end = true_run(model, Path()).profile.breaks[-2]
    time = np.arange(len(error)) / model.sensor.rate
    return float(error[time > end].min())


def _with_body(model: VelocityScenario, height: float, **pitch: float) -> VelocityScenario:
    response = model.body.pitch.model_copy(update=pitch)
    body = model.body.model_copy(update={"height": height, "pitch": response})
    return model.model_copy(update={"body": body})


def _figure(folder: Path) -> list[Path]:
    import pandas as pd

    from mcsim.figures.braking import draw_braking
    from mcsim.figures.style import printed
    from mcsim.provenance import provenance_of
    from mcsim.report import Report

    scenario, model = velocity_sensor(_SCENARIO)
    swing = swing_of(model)
    lowest = {
        height: np.array([lowest_after_braking(model, f, height) for f in FREQUENCIES])
        for height in HEIGHTS
    }
    figure = draw_braking(swing, FREQUENCIES, lowest, scenario.base.title or _SCENARIO)
    course = pd.DataFrame(
        {
            "time [s]": swing.time,
            "wheels [m/s]": swing.wheels,
            "error [m/s]": swing.error,
            "of gravity [m/s]": swing.by_gravity,
            "uc of the mean [m/s]": swing.uncertainty,
            "pitch [deg]": np.degrees(swing.pitch),
        }
    )
    by_frequency = pd.DataFrame(
        {
            "natural frequency [Hz]": FREQUENCIES,
            **{f"lowest at {h:g} m [m/s]": values for h, values in lowest.items()},
        }
    )
    Report(
        provenance=provenance_of(
            f"figures {_SCENARIO}", [shipped_scenarios() / "velocity" / f"{_SCENARIO}.yaml"]
        ),
        tables={"table": course, "lowest": by_frequency},
        pictures=printed(figure, "figure"),
    ).write(folder)
    return [folder / "figure.png"]


FIGURE = PaperFigure(_SCENARIO, make=_figure, folder="braking-swing")
