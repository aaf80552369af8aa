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
    from mcsim.systems.velocity.scenario import VelocityScenario

_SCENARIO_ENDINGS = (".yaml", ".yml")
#: Full scales (g), and scale factors, that a sensor may have.
_LEAST_SCALE, _LARGEST_SCALE = 1e-3, 1e6
_SENSITIVITIES = (0.2, 5.0)
#: Samples of a simulated shaker test.
_MOST_SAMPLES = 100_000_000
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

    if _is_scenario(file):
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
        import textwrap

        from mcsim.calibration.words import calibration_words
        from mcsim.cli.tables import budget_summary

        click.echo(budget_summary(table))
        click.echo("\n".join(textwrap.wrap(calibration_words(fit), 100)))
        click.echo(
            f"largest residual {abs(fit.residuals).max():.2g} g\n{folder / 'calibration.yaml'}"
        )


@click.command()
@_FILE
@click.option("--full-scale", help="Range of the sensor, such as 15 g; a scenario brings its own.")
@click.option(
    "--mxx",
    type=click.FloatRange(*_SENSITIVITIES),
    help="M0's element of a six-position test, for Eq. (34); a scenario brings its own.",
)
@_SEED
@_OUTPUT
@_QUIET
def linearity(
    file: Path,
    full_scale: str | None,
    mxx: float | None,
    seed: int,
    output: Path,
    quiet: bool,
) -> None:
    """Shaker test: straight line and non-linearity of an accelerometer.

    FILE is a CSV with the columns reference and measured (amplitudes in g, or in the
    unit in brackets), or a
    velocity scenario (YAML) with a block shaker, whose test is simulated.
    """
    from mcsim.calibration.words import linearity_words
    from mcsim.figures import write_figure
    from mcsim.figures.linearity import draw_linearity
    from mcsim.store import write_table

    if mxx is not None and _is_scenario(file):
        raise InputError("--mxx: the scenario brings its own, from the matrix of its calibration")
    fit = linearity_of(file, full_scale, seed, None if quiet else _note)
    if _is_scenario(file):
        mxx = _mxx(_velocity(file))
    folder = output / f"{file.stem}-linearity"
    write_table(linearity_table(fit), folder, "linearity")
    write_figure(draw_linearity([fit], [file.stem]), folder, "linearity")
    if not quiet:
        click.echo(f"{linearity_words(fit, mxx)}\n{folder / 'linearity.png'}")


def linearity_of(
    file: Path, full_scale: str | None, seed: int, tell: Callable[[str], None] | None = None
) -> LinearityFit:
    """The fit of a file's test, read or simulated."""
    from mcsim.calibration import linearity as fit_of
    from mcsim.calibration import read_amplitudes
    from mcsim.errors import UnitError
    from mcsim.units import KINDS, parse

    if _is_scenario(file):
        if full_scale is not None:
            raise InputError("--full-scale: the scenario brings its own, shaker.full_scale")
        return _simulated_linearity(file, _velocity(file), seed)
    if full_scale is None:
        raise InputError("--full-scale: is missing; write for example --full-scale '15 g'")
    try:
        scale = parse(full_scale, KINDS["sensor output"])
    except UnitError as error:
        raise InputError(f"--full-scale: {error}") from None
    if not _LEAST_SCALE <= scale <= _LARGEST_SCALE:
        raise InputError(
            f'--full-scale: "{full_scale}" must lie between {1e3 * _LEAST_SCALE:g} mg and '
            f"{_LARGEST_SCALE:g} g"
        )
    return fit_of(*read_amplitudes(file, tell), scale)


def linearity_table(fit: LinearityFit) -> pd.DataFrame:
    """Columns reference, measured (or simulated), fitted and residual: fractions of g and ppm."""
    import pandas as pd

    found = "simulated" if fit.simulated else "measured"

    return pd.DataFrame(
        {
            "reference [g]": fit.reference,
            f"{found} [g]": fit.measured,
            "fitted [g]": fit.measured - fit.residuals,
            "residual [ppm FS]": 1e6 * fit.residuals / fit.full_scale,
        }
    )


def _is_scenario(path: Path) -> bool:
    return path.suffix.lower() in _SCENARIO_ENDINGS


def _mxx(model: VelocityScenario) -> float:
    """The element of M0, the inverse of the correction L."""
    import numpy as np

    from mcsim.systems.velocity.samples import correction_of

    return float(np.linalg.inv(correction_of(model.calibration)[0])[0, 0])


def _note(text: str) -> None:
    click.echo(f"note: {text}", err=True)


def _velocity(path: Path) -> VelocityScenario:
    from mcsim.scenario_file import Scenario
    from mcsim.systems.velocity.scenario import VelocityScenario

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
    from mcsim.systems.velocity.raw_output import raw_noise
    from mcsim.systems.velocity.samples import correction_of

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
    from mcsim.systems.velocity.raw_output import raw_noise

    shaker = model.shaker
    if shaker is None:
        raise InputError(
            f"{path}: shaker: is missing; write `shaker: {{full_scale: 15 g, "
            "nonlinearity: 1000 ppm}`"
        )
    rate = model.sensor.rate
    if shaker.highest >= 0.5 * rate:
        raise InputError(
            f"{path}: shaker.highest: {shaker.highest:g} Hz must lie below half of the sensor's "
            f"rate, {0.5 * rate:g} Hz"
        )
    samples = shaker.duration * rate * shaker.points * shaker.series
    if samples > _MOST_SAMPLES:
        raise InputError(
            f"{path}: shaker: {samples:,.0f} samples in all are more than the {_MOST_SAMPLES:,} "
            "that are simulated; shorten `duration`, or lower `points` or `series`"
        )
    frequencies = np.linspace(shaker.lowest, shaker.highest, shaker.points)
    reference = shaker.amplitude * frequencies / shaker.highest
    scale = _mxx(model)
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
    return fit_of(reference, measured, shaker.full_scale, simulated=True)


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
    rows = [
        (name, e.value, e.uncertainty, e.freedom, e.coverage_factor, repeated.get(name))
        for name, e in fit.estimates().items()
    ]
    table = pd.DataFrame(
        rows,
        columns=[
            "quantity",
            "estimate",
            "uncertainty",
            "degrees of freedom",
            "k (95 %)",
            "from repetitions alone",
        ],
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
        "# Correction ac = L (am - B) of a six-position test. Uncertainties are k u / 1.96, the",
        "# deviation of a normal distribution with the 95 % interval of Student's t; comments tell",
        "# the standard uncertainty u, its degrees of freedom, and k.",
        "calibration:",
    ]
    for name, e in fit.estimates().items():
        if name[0] == "m" or name.startswith("ly"):
            continue  # no equation uses the corrected y
        unit = " g" if name.startswith("b") else ""
        lines.append(
            f"  {name}: {{estimate: {e.value:.9g}{unit}, "
            f"uncertainty: {e.normal_uncertainty:.3g}{unit}}}"
            f"  # u {e.uncertainty:.3g}, {e.freedom:.3g} degrees of freedom, "
            f"k = {e.coverage_factor:.3g}"
        )
    if fit.scatter is not None:
        x, y, z = fit.scatter.deviation
        lines += ["sensor:", f"  noise: {{x: {x:.3g} g, y: {y:.3g} g, z: {z:.3g} g}}"]
    return "\n".join(lines) + "\n"
