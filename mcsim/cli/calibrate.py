"""``mcsim calibrate`` and ``mcsim linearity``: from a test of an accelerometer to a scenario."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcsim.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.calibration import LinearityFit, SixPositionFit, SixPositions
    from mcsim.scenario import VelocityScenario

_SCENARIO_ENDINGS = (".yaml", ".yml")
_FILE = click.argument("file", type=click.Path(path_type=Path))
_OUTPUT = click.option(
    "--output",
    type=click.Path(path_type=Path),
    default=Path("output"),
    show_default=True,
    help="Folder for results; a folder named after the file is made inside.",
)
_SEED = click.option(
    "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of a simulation."
)
_QUIET = click.option("--quiet", is_flag=True, help="No summary.")


@click.command()
@_FILE
@click.option(
    "--samples", type=click.IntRange(1, 10_000_000), default=1000, show_default=True,
    help="Simulation: samples per position.",
)  # fmt: skip
@click.option(
    "--repetitions", type=click.IntRange(1, 10_000), default=2, show_default=True,
    help="Simulation: how often the test is made.",
)  # fmt: skip
@click.option(
    "--alignment", default="0.1 °", show_default=True,
    help="Simulation: standard deviation of each position's angles.",
)  # fmt: skip
@_SEED
@_OUTPUT
@_QUIET
def calibrate(
    file: Path,
    samples: int,
    repetitions: int,
    alignment: str,
    seed: int,
    output: Path,
    quiet: bool,
) -> None:
    """Six-position test: matrix and bias of an accelerometer, with uncertainties.

    FILE is a CSV with the columns position (+x, -x … -z: the axis that points up or down), x, y, z
    in g (or the unit in brackets, x [m/s^2]), and perhaps repetition; one row per position, or many
    samples.  A velocity scenario (YAML) instead simulates the test of its sensor.
    """
    from mcsim.calibration import calibrate as fit_of
    from mcsim.calibration import read_six_positions
    from mcsim.store import write_table, write_text

    if file.suffix.lower() in _SCENARIO_ENDINGS:
        test = _simulated_test(_velocity(file), samples, repetitions, _angle(alignment), seed)
    else:
        test = read_six_positions(file, None if quiet else _note)
    fit = fit_of(test)
    folder = output / f"{file.stem}-calibration"
    table, residuals = _tables(fit)
    write_table(table, folder, "calibration")
    write_table(residuals, folder, "residuals")
    write_text(_block(fit), folder, "calibration.yaml")
    if not quiet:
        from mcsim.cli.tables import budget_summary

        click.echo(budget_summary(table))
        click.echo(
            f"{fit.freedom:.1f} degrees of freedom (Student's t), largest residual "
            f"{abs(fit.residuals).max():.2g} g\n{folder / 'calibration.yaml'}"
        )


@click.command()
@_FILE
@click.option("--full-scale", help="Range of the sensor, such as 15 g; a scenario brings its own.")
@_SEED
@_OUTPUT
@_QUIET
def linearity(file: Path, full_scale: str | None, seed: int, output: Path, quiet: bool) -> None:
    """Shaker test: straight line and non-linearity of an accelerometer.

    FILE is a CSV with the columns reference and measured (amplitudes in g, or in the
    unit in brackets), or a
    velocity scenario (YAML) with a block shaker, whose test is simulated.
    """
    from mcsim.figures import write_figure
    from mcsim.figures.linearity import draw_linearity
    from mcsim.store import write_table

    fit = linearity_of(file, full_scale, seed, None if quiet else _note)
    folder = output / f"{file.stem}-linearity"
    write_table(linearity_table(fit), folder, "linearity")
    write_figure(draw_linearity([fit], [file.stem]), folder, "linearity")
    if not quiet:
        click.echo(
            f"slope {fit.slope:.6g}, offset {fit.offset:.3g} g, non-linearity "
            f"{1e6 * fit.nonlinearity:.0f} ppm of {fit.full_scale:g} g\n"
            f"its part of u(lxx), Eq. (34): {fit.scale_uncertainty(0.0):.2g}\n"
            f"{folder / 'linearity.png'}"
        )


def linearity_of(
    file: Path, full_scale: str | None, seed: int, tell: Callable[[str], None] | None = None
) -> LinearityFit:
    """The fit of a file's test, read or simulated."""
    from mcsim.calibration import linearity as fit_of
    from mcsim.calibration import read_amplitudes
    from mcsim.errors import UnitError
    from mcsim.units import KINDS, parse

    if file.suffix.lower() in _SCENARIO_ENDINGS:
        if full_scale is not None:
            raise InputError("--full-scale: the scenario brings its own, shaker.full_scale")
        return _simulated_linearity(file, _velocity(file), seed)
    if full_scale is None:
        raise InputError("--full-scale: is missing; write for example --full-scale '15 g'")
    try:
        scale = parse(full_scale, KINDS["sensor output"])
    except UnitError as error:
        raise InputError(f"--full-scale: {error}") from None
    if scale <= 0.0:
        raise InputError(f'--full-scale: "{full_scale}" must be above zero')
    return fit_of(*read_amplitudes(file, tell), scale)


def linearity_table(fit: LinearityFit) -> pd.DataFrame:
    """Columns reference, measured, fitted and residual, in fractions of g and ppm."""
    import pandas as pd

    return pd.DataFrame(
        {
            "reference [g]": fit.reference,
            "measured [g]": fit.measured,
            "fitted [g]": fit.measured - fit.residuals,
            "residual [ppm FS]": 1e6 * fit.residuals / fit.full_scale,
        }
    )


def _note(text: str) -> None:
    click.echo(f"note: {text}", err=True)


def _velocity(path: Path) -> VelocityScenario:
    from mcsim.scenario import Scenario, VelocityScenario

    base = Scenario.from_yaml(path).base
    if not isinstance(base, VelocityScenario):
        raise InputError(f"{path}: case: `case: velocity` is needed here, not {base.case}")
    return base


def _angle(text: str) -> float:
    from mcsim.errors import UnitError
    from mcsim.units import KINDS, parse

    try:
        value = parse(text, KINDS["angle"])
    except UnitError as error:
        raise InputError(f"--alignment: {error}") from None
    if not 0.0 <= value < 0.2:
        raise InputError(f'--alignment: "{text}" must lie between 0 ° and 11 °')
    return value


def _simulated_test(
    model: VelocityScenario, samples: int, repetitions: int, alignment: float, seed: int
) -> SixPositions:
    import numpy as np

    from mcsim.calibration import simulate_six_positions
    from mcsim.cases.velocity_samples import correction_of
    from mcsim.sensors.raw_output import raw_noise

    return simulate_six_positions(
        *correction_of(model.calibration),
        raw_noise(model),
        samples,
        repetitions,
        alignment,
        np.random.default_rng(seed),
    )


def _simulated_linearity(path: Path, model: VelocityScenario, seed: int) -> LinearityFit:
    import numpy as np

    from mcsim.calibration import linearity as fit_of
    from mcsim.calibration import simulate_shaker
    from mcsim.calibration.shaker import cubic_of
    from mcsim.sensors.raw_output import raw_noise

    shaker = model.shaker
    if shaker is None:
        raise InputError(
            f"{path}: shaker: is missing; write `shaker: {{full_scale: 15 g, "
            "nonlinearity: 1000 ppm}`"
        )
    frequencies = np.linspace(shaker.lowest, shaker.highest, shaker.points)
    reference = shaker.amplitude * frequencies / shaker.highest
    scale = 1.0 / model.calibration.lxx.estimate
    measured = simulate_shaker(
        frequencies,
        reference,
        scale,
        cubic_of(shaker.nonlinearity, shaker.full_scale, scale, reference),
        float(raw_noise(model)[0]),
        model.sensor.rate,
        shaker.duration,
        shaker.series,
        np.random.default_rng(seed),
    )
    return fit_of(reference, measured, shaker.full_scale)


def _tables(fit: SixPositionFit) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The parameters, and the residuals by position."""
    import pandas as pd

    from mcsim.calibration.six_positions import AXES, POSITIONS

    repeated: dict[str, float] = {}
    if fit.repeatability is not None:
        corrections, biases = fit.repeatability
        for i, a in enumerate(AXES):
            repeated[f"b{a}"] = float(biases[i])
            for j, b in enumerate(AXES):
                repeated[f"l{a}{b}"] = float(corrections[i, j])
    table = pd.DataFrame(
        [(name, value, u, repeated.get(name)) for name, (value, u) in fit.estimates().items()],
        columns=["quantity", "estimate", "uncertainty", "from repetitions alone"],
    )
    residuals = pd.DataFrame(
        [
            (r + 1, position, *fit.residuals[r, p])
            for r in range(len(fit.residuals))
            for p, position in enumerate(POSITIONS)
        ],
        columns=["repetition", "position", *(f"{axis} [g]" for axis in AXES)],
    )
    return table, residuals


def _block(fit: SixPositionFit) -> str:
    """The ``calibration`` block of a velocity scenario."""
    lines = [
        "# Correction ac = L (am - B) of a six-position test; uncertainties from its residuals."
    ]
    lines.append("calibration:")
    for name, (value, u) in fit.estimates().items():
        if name.startswith("ly"):
            continue  # no equation uses the corrected y
        unit = " g" if name.startswith("b") else ""
        lines.append(f"  {name}: {{estimate: {value:.6g}{unit}, uncertainty: {u:.3g}{unit}}}")
    if fit.noise is not None:
        x, y, z = fit.noise
        lines += ["sensor:", f"  noise: {{x: {x:.3g} g, y: {y:.3g} g, z: {z:.3g} g}}"]
    return "\n".join(lines) + "\n"
