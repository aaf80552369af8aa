"""The uncertainty budget of one velocity step: the 26 rows of Tables 3 and 4, and totals."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mcsim.errors import InputError
from mcsim.gum.propagation import (
    AXES,
    Array,
    Correction,
    Known,
    step_sensitivities,
    tilt_sensitivities,
)
from mcsim.systems.velocity.raw_output import raw_noise
from mcsim.systems.velocity.scenario import VelocityScenario


@dataclass(frozen=True)
class BudgetRow:
    """One input quantity: its contribution ``variance`` to the quantity that ``equation`` gives.

    Dimensionless quantities are fractions of g; angles in rad, g in m/s^2, time in s.
    ``printed`` is the variance of a publication, if the scenario holds one.
    """

    number: int
    quantity: str
    estimate: float
    uncertainty: float
    equation: str
    sensitivity: float
    printed: float | None = None

    @property
    def variance(self) -> float:
        return (self.sensitivity * self.uncertainty) ** 2


@dataclass(frozen=True)
class Budget:
    """All rows, and the combined standard uncertainties of acx, acz, theta and Dv."""

    rows: tuple[BudgetRow, ...]
    estimates: dict[str, float]

    def group(self, output: str) -> tuple[BudgetRow, ...]:
        """The rows that contribute to ``acx``, ``acz``, ``theta`` or ``Dv``."""
        first, last = {"acx": (0, 9), "acz": (9, 18), "theta": (18, 21), "Dv": (21, 26)}[output]
        return self.rows[first:last]

    def uncertainty(self, output: str) -> float:
        """Combined standard uncertainty, Eq. (26), (27), (28) or (29)."""
        return math.sqrt(sum(row.variance for row in self.group(output)))


def correction(model: VelocityScenario, axis: str) -> Correction:
    """Eq. (4) for axis ``x``, Eq. (5) for ``z``."""
    c = model.calibration
    factors = [getattr(c, f"l{axis}{k}") for k in AXES]
    biases = [getattr(c, f"b{k}") for k in AXES]
    return Correction(
        np.array([q.estimate for q in factors]),
        np.array([q.uncertainty for q in factors]),
        np.array([q.estimate for q in biases]),
        np.array([q.uncertainty for q in biases]),
    )


@dataclass(frozen=True)
class StepPoint:
    """Where the budget of a step is evaluated: estimates with standard uncertainties.

    ``raw`` (3,) is the output am, with the uncertainty ``known.noise``; ``rest_x`` and ``rest_z``
    are acx,0 and acz,0 (fractions of g), ``interval`` is Δt (s); ``printed`` are the variances that
    a publication has for the rows.
    """

    known: Known
    raw: Array
    rest_x: tuple[float, float]
    rest_z: tuple[float, float]
    interval: float
    printed: tuple[float, ...] | None = None


def step_budget(model: VelocityScenario) -> Budget:
    """The budget where the scenario's ``budget`` block says.

    Raises
    ------
    InputError
        The scenario has no such block.
    """
    point = model.budget
    if point is None:
        raise InputError(
            "budget: is missing; say where the budget of a step is evaluated: "
            "`budget: {output: {x: …, y: …, z: …}, rest_x: {estimate: …, uncertainty: …}, "
            "rest_z: {…}}`"
        )
    return budget_at(
        StepPoint(
            known=known_of(model),
            raw=np.array([point.output.x, point.output.y, point.output.z]),
            rest_x=(point.rest_x.estimate, point.rest_x.uncertainty),
            rest_z=(point.rest_z.estimate, point.rest_z.uncertainty),
            interval=point.interval or 1.0 / model.sensor.rate,
            printed=point.printed,
        )
    )


def known_of(model: VelocityScenario) -> Known:
    """What a scenario says of its steps."""
    return Known(
        x=correction(model, "x"),
        z=correction(model, "z"),
        noise=raw_noise(model),
        tilt_change=model.tilt.change,
        gravity=model.gravity.local_gravity,
        gravity_error=model.gravity.uncertainty,
        interval_error=model.sensor.time_error,
    )


def budget_at(point: StepPoint) -> Budget:
    """The 26 rows of Tables 3 and 4, Eq. (25) to (29)."""
    known, raw = point.known, point.raw
    quantities: list[tuple[str, float, float, str, float]] = []
    corrected, combined = {}, {}
    for axis, own, equation in (("x", known.x, "(4)"), ("z", known.z, "(5)")):
        by_factor, by_raw, by_bias = own.sensitivities(raw)
        for names, values, deviations, slopes in (
            ([f"l{axis}{k}" for k in AXES], own.factors, own.u_factors, by_factor),
            ([f"am{k}" for k in AXES], raw, known.noise, by_raw),
            ([f"B{k}" for k in AXES], own.bias, own.u_bias, by_bias),
        ):
            quantities += [
                (name, float(value), float(u), equation, float(slope))
                for name, value, u, slope in zip(names, values, deviations, slopes, strict=True)
            ]
        corrected[axis] = float(own.value(raw))
        variances = own.variances(raw, known.noise)
        combined[axis] = math.sqrt(sum(float(v) for v in variances.values()))
    theta, u_theta, rows = _tilt_rows(point)
    quantities += rows
    g, interval = known.gravity, point.interval
    slopes_of_step = step_sensitivities(corrected["x"], corrected["z"], theta, g, interval)
    quantities += [
        (name, value, u, "(24)", float(slope))
        for (name, value, u), slope in zip(
            (
                ("acx", corrected["x"], combined["x"]),
                ("acz", corrected["z"], combined["z"]),
                ("θ", theta, u_theta),
                ("g", g, known.gravity_error),
                ("Δt", interval, known.interval_error),
            ),
            slopes_of_step,
            strict=True,
        )
    ]
    printed = point.printed or (None,) * len(quantities)
    return Budget(
        tuple(
            BudgetRow(i, *quantity, printed=number)
            for i, (quantity, number) in enumerate(zip(quantities, printed, strict=True), start=1)
        ),
        {
            "acx": corrected["x"],
            "acz": corrected["z"],
            "theta": theta,
            "Dv": (corrected["x"] - corrected["z"] * theta) * g * interval,
        },
    )


def _tilt_rows(point: StepPoint) -> tuple[float, float, list[tuple[str, float, float, str, float]]]:
    """The tilt with its uncertainty, Eq. (20) and (28), and its three rows."""
    (rest_x, u_x), (rest_z, u_z), change = point.rest_x, point.rest_z, point.known.tilt_change
    by_x, by_z = tilt_sensitivities(rest_x, rest_z)
    theta = math.atan(rest_x / rest_z)
    u_theta = math.sqrt(change**2 + (by_x * u_x) ** 2 + (by_z * u_z) ** 2)
    return (
        theta,
        u_theta,
        [
            ("δα", 0.0, change, "(19)", 1.0),
            ("acx,0", rest_x, u_x, "(19)", by_x),
            ("acz,0", rest_z, u_z, "(19)", by_z),
        ],
    )
