"""What holds for every sensor term, over the list: one that is added is tested by being listed."""

import json
import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import mcsim
from mcsim import InputError
from mcsim.dialects import own
from mcsim.dialects.description import Assumptions, Description
from mcsim.scenario.document import parse_document
from mcsim.scenario.paths import find_scalar
from mcsim.scenario.sensor_file import SensorFile
from mcsim.scenario.validation import validate
from mcsim.scenario_file.schema import scenario_schema
from mcsim.sensor_terms import RESERVED, TERMS, temperature
from mcsim.sensor_terms.channel import SIGNALS
from mcsim.sensor_terms.mechanisms import event
from mcsim.sensor_terms.mechanisms.digitise import Quantisation, Saturation, digitised
from mcsim.sensor_terms.mechanisms.linear_filter import LinearFilter
from mcsim.sensor_terms.term import check
from mcsim.sensors.simulated_log import SimulatedLog
from mcsim.systems.planar.scenario import PlanarScenario
from mcsim.systems.strapdown.scenario import StrapdownScenario
from mcsim.systems.velocity.scenario import VelocityScenario
from mcsim.units import KINDS
from tests import conftest, strapdown
from tests.conftest import NO_NOISE

EXAMPLES = Path(__file__).parents[1] / "docs" / "examples"
#: Values where the example of a kind of quantity is not a fair one.
VALUES = {
    "spikes.rate": "10 Hz",
    "quadratic_nonlinearity.full_scale": {"acceleration": "20 m/s²", "angular rate": "100 °/s"},
    "cubic_nonlinearity.full_scale": {"acceleration": "20 m/s²", "angular rate": "100 °/s"},
    "resonance.natural_frequency": "40 Hz",
    "resonance.damping": "30 %",
    "ac_coupling": "0.2 Hz",
    "gauss_markov.correlation_time": "0.3 s",
    "acceleration_random_walk": "1e-2 m/s²/√s",
    "rate_random_walk": "0.02 °/s/√s",
    "scale_factor_error": "0.5 %",
    "resolution": {"acceleration": "0.04 m/s²", "angular rate": "0.3 °/s"},
    "range": {"acceleration": "1 m/s²", "angular rate": "3 °/s"},
}
PAIRS = [(e, term) for term in TERMS.values() for e in SIGNALS if term.keys(e)]
OF_ELEMENT = [pytest.param(*pair, id=f"{pair[0]} {pair[1].name}") for pair in PAIRS]
#: A course of the temperature, without which some terms have no effect.
WARM = {"sensors.temperature": {"difference": "8 K", "ramp": "60 K/min"}}
#: Terms by which a sensor errs the same way each time.
CERTAIN = (Saturation, LinearFilter)


def text_of(element, path, key):
    value = VALUES.get(path, KINDS[key.kind_for(element)].example)
    return value[SIGNALS[element]] if isinstance(value, dict) else value


def ways(element, term):
    """The ways to write a term: keys below the element's block, with values."""
    written = {path: text_of(element, path, key) for path, key in term.paths(element)}
    return [{path: text} for path, text in written.items()] if term.alternatives else [written]


def tree_of(written):
    """Dotted paths as blocks within blocks."""
    tree = {}
    for path, value in written.items():
        *outer, name = path.split(".")
        block = tree.setdefault(outer[0], {}) if outer else tree
        block[name] = value
    return tree


def overrides(element, written):
    """A term alone, in a scenario that has no other errors."""
    tree = tree_of(written)
    quiet = {key: value for key, value in NO_NOISE.items() if not is_noise(written, key, element)}
    blocks = {f"sensors.{element}.{key}": value for key, value in tree.items()}
    if is_noise(written, f"sensors.{element}.", element):
        blocks = {f"sensors.{element}": tree}
    if any(key.name in written for key in temperature_keys(element)):
        blocks |= WARM
    return {**quiet, **blocks}


def temperature_keys(element):
    return [key for term in temperature.TERMS for key in term.keys(element)]


def is_noise(written, path, element):
    noise = {key for key, _ in TERMS["noise"].paths(element)}
    return bool(noise & written.keys()) and path.startswith(f"sensors.{element}.")


# Scenarios, files, schema


@pytest.mark.parametrize(("element", "term"), OF_ELEMENT)
def test_terms_of_the_list_are_terms_that_could_be_added(element, term):
    check(term)
    outer = [path.partition(".")[0] for path, _ in term.paths(element)]
    assert not {*outer} & {*RESERVED}
    others = [other for name, other in TERMS.items() if name != term.name]
    assert not {*outer} & {path.partition(".")[0] for o in others for path, _ in o.paths(element)}


@pytest.mark.parametrize(("element", "term"), OF_ELEMENT)
def test_every_key_can_be_swept(element, term):
    models = {PlanarScenario: "sensors", StrapdownScenario: "sensors"}
    if element == "accelerometer":
        models[VelocityScenario] = "sensor"
    for model, block in models.items():
        for path, key in term.paths(element):
            scalar = find_scalar(model, f"{block}.{element}.{path}")
            assert scalar is not None, (model, path)
            assert scalar.kind is KINDS[key.kind_for(element)]
            assert bool(find_scalar(model, f"{block}.{element}.{path}.0")) == key.per_axis


@pytest.mark.parametrize(("element", "term"), OF_ELEMENT)
def test_blocks_are_written_to_files_and_read_again(element, term):
    for written in ways(element, term):
        keys = dict(term.paths(element))
        lists = {
            path: [text, text, text] if keys[path].per_axis else text
            for path, text in written.items()
        }
        for tree in (tree_of(written), tree_of(lists)):
            text = json.dumps({element: tree}, ensure_ascii=False)
            block = getattr(validate(parse_document(text), SensorFile), element)
            sensor = own.read(text, "file", Assumptions()).description
            again = own.write_si(Description(None, None, sensor.elements), Assumptions())
            read = getattr(validate(parse_document(again), SensorFile), element)
            assert block.values_of(term)
            for role, value in block.values_of(term).items():
                assert read.values_of(term)[role] == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(("element", "term"), OF_ELEMENT)
def test_the_schema_has_every_key_with_its_kind_and_its_words(element, term):
    schema = scenario_schema()["definitions"]
    _, block = schema[element.capitalize()]["anyOf"]
    for path, key in term.paths(element):
        properties = block["properties"]
        if term.inner:
            inner = properties[term.inner.key]["anyOf"][0]["$ref"].rpartition("/")[2]
            properties = schema[inner]["properties"]
        field = json.dumps(properties[path.rpartition(".")[2]], ensure_ascii=False)
        assert KINDS[key.kind_for(element)].example in field
        assert key.text
        assert key.text in field


@pytest.mark.parametrize(("element", "term"), OF_ELEMENT)
def test_unknown_keys_suggest_the_ones_that_exist(element, term):
    for key in term.keys(element):
        wrong = key.name[:-1] + "x"
        tree = {term.inner.key: {wrong: "1"}} if term.inner else {wrong: "1"}
        with pytest.raises(InputError, match=f'unknown key "{wrong}"; did you mean "{key.name}"'):
            validate(parse_document(json.dumps({element: tree})), SensorFile)


# The linear model and the budget


def with_effect(values, source):
    """The planar problem, or where the term shows in no planar channel that in space."""
    p = conftest.problem(values)
    return p if np.any(p.linear.variances.get(source, 0.0)) else strapdown.problem(values)


@pytest.mark.slow
@pytest.mark.parametrize("integration", ["rectangular", "trapezoidal"])
@pytest.mark.parametrize(("element", "term"), OF_ELEMENT)
def test_each_term_alone_has_the_linear_models_deviation(element, term, integration):
    source, count = f"{element} {term.name}", 20_000
    for written in ways(element, term):
        values = {**overrides(element, written), "reconstruction.integration": integration}
        p = with_effect(values, source)
        if isinstance(validated(element, written).acts_on(0)[term.name], CERTAIN):
            assert source not in p.linear.variances
            continue
        if isinstance(validated(element, written).acts_on(0)[term.name], Quantisation):
            # Rounding is a noise where there is some: without, it is the same each time.
            noise = {f"sensors.{element}.noise_density": NOISY[element]}
            p = with_effect({**values, **noise}, source)
        linear = p.linear.variances
        deviation = (p.simulate(7, 0, count).errors - p.method_errors()[:, None]).std(axis=1)
        own = [v for name, v in linear.items() if name.startswith(element)]
        expected = np.sqrt(np.sum(own, axis=0))
        assert linear[source].max() > 0.05 * max(v.max() for v in linear.values())
        signed = [i for i, name in enumerate(p.error_names) if name != "position"]
        # Beside the sampling error, terms of second order show where the first order vanishes.
        np.testing.assert_allclose(
            deviation[signed],
            expected[signed],
            rtol=5 / math.sqrt(2 * count) + 0.01,
            atol=0.02 * expected[signed].max(),
        )


NOISY = {"accelerometer": "5e-3 m/s²/√Hz", "gyroscope": "0.04 °/s/√Hz"}


def validated(element, written):
    text = json.dumps({element: tree_of(written)}, ensure_ascii=False)
    return getattr(validate(parse_document(text), SensorFile), element)


def test_the_budget_names_every_term():
    values, sources = {}, set()
    for element, term in PAIRS:
        written = ways(element, term)[0]
        if not is_noise(written, f"sensors.{element}.", element):
            values |= overrides(element, written)
        if not isinstance(validated(element, written).acts_on(0)[term.name], CERTAIN):
            sources.add(f"{element} {term.name}")
    values |= {f"sensors.{e}.noise_density": noise for e, noise in NOISY.items()}
    values |= {"monte_carlo.realizations": 100}
    budget = mcsim.run(strapdown.scenario(values)).budget
    assert sources <= set(budget["source"])
    np.testing.assert_allclose(budget.groupby("error")["share"].sum(), 1.0, rtol=1e-9)


@pytest.mark.parametrize(("element", "term"), OF_ELEMENT)
def test_a_term_of_zero_is_none(element, term):
    """To the last bit, and in all cases."""
    keys = dict(term.paths(element))
    for written in ways(element, term):
        zero = {
            path: text if keys[path].positive else f"0 {text.split(' ', 1)[1]}"
            for path, text in written.items()
        }
        if zero == written or is_noise(written, f"sensors.{element}.", element):
            continue
        for case in (conftest, strapdown):
            base = case.problem(conftest.ALL_ERRORS).simulate(3, 0, 60).errors
            blocks = {f"sensors.{element}.{k}": v for k, v in tree_of(zero).items()}
            silent = {**conftest.ALL_ERRORS, **blocks}
            if "miscalibration" in zero:
                del silent[f"sensors.{element}.miscalibration"]
                base = case.problem(silent).simulate(3, 0, 60).errors
            np.testing.assert_array_equal(case.problem(silent).simulate(3, 0, 60).errors, base)


# Kernels and simulated logs: one sensor model


BRAKING = {
    "trajectory": {"shape": "straight", "length": "12 m", "speed": "20 m/s", "lead": "0.1 s",
                   "deceleration": "1.5 m/s^2"},
    "sensors.sampling": "none",
}  # fmt: skip
REALIZATIONS = 1500


def of_kernel(p, element, count=REALIZATIONS):
    """What a planar kernel has measured (n, r), told from its tracks: they integrate it.

    The errors of forward acceleration from sample 2 on, or of the turn per interval from 1 on.
    """
    history = p.history(11, 0, count)
    if element == "gyroscope":
        return np.diff(history.errors[3], axis=0)
    return np.diff(history.tracks[0], 2, axis=0) / p.interval**2 - p.signals[2:, [0]]


def of_log(p, element, count=REALIZATIONS):
    """A simulated log of as many sensors at once, of the same channel; same rows."""
    k, first = (2, 1) if element == "gyroscope" else (0, 2)
    errors = p.sensor_errors

    def many(values):
        return np.full(count, values[k])

    tiled = replace(
        errors,
        elements=(element,) * count,
        white=many(errors.white),
        constants={name: many(own) for name, own in errors.constants.items()},
        processes=(errors.processes[k],) * count,
        mixing=tuple(
            replace(entry, target=j, source=count + entry.source)
            for entry in errors.mixing
            for j in range(count)
            if entry.target == k
        ),
        ranges=many(errors.ranges),
        resolutions=many(errors.resolutions),
        spike_rates=many(errors.spike_rates),
        spike_amplitudes=many(errors.spike_amplitudes),
        filters=((),) * count,  # the kernel's signals are behind them
        columns=(),  # and hold these
    )
    signals = np.hstack([np.repeat(p.signals[:, [k]], count, axis=1), p.signals])
    return SimulatedLog(tiled, 5).measure(signals)[first:] - p.signals[first:, [k]]


def distance(a, b):
    """Largest difference of moments (in standard errors) of functionals of a (n, r) and b (n, r).

    Where nothing varies, values are compared instead.
    """
    n = len(a)
    ones, turns = np.ones(n) / n, (-1.0) ** np.arange(n) / n
    last, rise = np.eye(n)[-1], np.eye(n)[-1] - np.eye(n)[0]
    weights = np.stack([ones, turns, last, rise, np.eye(n)[n // 2]])
    scale = max(np.abs(a).max(), np.abs(b).max(), 1e-300)
    found = 0.0
    moments = [lambda x: weights @ x, lambda x: (weights @ x) ** 2]
    moments += [lambda x: np.mean(x**4, axis=0)[None], lambda x: np.max(np.abs(x), axis=0)[None]]
    for moment in moments:
        for one, other in zip(moment(a / scale), moment(b / scale), strict=True):
            error = math.sqrt(one.var() / len(one) + other.var() / len(other))
            difference = abs(one.mean() - other.mean())
            # Second differences of tracks are known to rounding.
            found = max(found, difference / max(error, 1e-8))
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("element", "term"), OF_ELEMENT)
def test_kernels_and_simulated_logs_measure_alike(element, term):
    for written in ways(element, term):
        p = conftest.problem({**BRAKING, **overrides(element, written)})
        measured, log = of_kernel(p, element), of_log(p, element)
        assert measured.shape == log.shape
        if isinstance(validated(element, written).acts_on(0)[term.name], LinearFilter):
            np.testing.assert_allclose(measured, log, atol=1e-9)
            continue
        assert distance(measured, log) < 5.0
        # The control: errors that are a quarter too large; a yaw rate of zero shows not all.
        assert distance(measured, 1.25 * log) > 5.0 or not np.any(log)


def test_half_steps_are_rounded_up_in_kernels_and_in_logs():
    """The control: to even, -1.5 would be -2."""
    values = {**BRAKING, **NO_NOISE, "sensors.accelerometer.resolution": "1 m/s²"}
    p = conftest.problem(values)
    braking = p.signals[2:, 0] == -1.5
    assert braking.sum() > 50
    measured, log = of_kernel(p, "accelerometer", 3), of_log(p, "accelerometer", 3)
    np.testing.assert_allclose(measured[braking], 0.5, atol=1e-9)
    np.testing.assert_array_equal(log[braking], 0.5)
    assert np.round(-1.5) == -2.0
    halves = np.arange(-5.0, 6.0)[:, None] / 2
    steps = digitised(halves, np.array([2.0]), np.array([1.0]))[:, 0]
    assert steps.tolist() == [-2, -2, -1, -1, 0, 0, 1, 1, 2, 2, 2]


def test_spikes_counted_after_poisson_would_be_seen():
    """The control: a sample with two spikes, which the kernels never have."""
    values = overrides("accelerometer", {"spikes.rate": "10 Hz", "spikes.amplitude": "1 m/s²"})
    p = conftest.problem({**BRAKING, **values})
    measured = of_kernel(p, "accelerometer")
    rng = np.random.default_rng(3)
    signs = np.where(rng.random(measured.shape) < 0.5, -1.0, 1.0)
    counted = signs * rng.poisson(10 * p.interval, measured.shape)
    assert distance(measured, counted) > 5.0
    assert np.all(event.probability(np.array([10.0, 1e9]), p.interval) == [0.1, 1.0])


# Terms from outside

OUTSIDE = """
import json, sys
from pathlib import Path
import numpy as np
import mcsim
from mcsim import InputError
from mcsim.cli.own import run_own
from mcsim.scenario_file.schema import scenario_schema
from tests.conftest import problem, scenario

SensorKey, SensorTerm, Offset = mcsim.SensorKey, mcsim.SensorTerm, mcsim.mechanisms.Offset
AS_KNOWN = {"sensors.gyroscope.turn_on_bias": ["1 °/s", "2 °/s", "3 °/s"],
            "sensors.accelerometer.misalignment": "10 mrad"}
OWN = {"sensors.gyroscope.run_to_run_bias": ["1 °/s", "2 °/s", "3 °/s"],
       "sensors.accelerometer.cross_axis_sensitivity": "1 %"}
known = problem(AS_KNOWN).simulate(1, 0, 50).errors  # the blocks are in use
scenario_schema()

run_own(Path(sys.argv[1]))
definitions = scenario_schema()["definitions"]
refused = []
for wrong in (
    SensorTerm("a", Offset, (SensorKey("turn_on_bias", "{signal}"),)),
    SensorTerm("noise", Offset, (SensorKey("b", "{signal}"),)),
    SensorTerm("c", Offset, (SensorKey("c", "furlongs"),)),
):
    try:
        mcsim.add(wrong)
    except InputError as error:
        refused.append(str(error))
try:
    problem({"sensors.gyroscope.run_to_run_bis": "1 °/s"})
except InputError as error:
    refused.append(str(error))
json.dump({
    "same": bool(np.array_equal(problem(OWN).simulate(1, 0, 50).errors, known)),
    "gyroscope": "drawn at each run." in json.dumps(definitions["Gyroscope"]),
    "accelerometer": "each other axis adds." in json.dumps(definitions["AccelerometerErrors"]),
    "refused": refused,
}, sys.stdout)
"""


def outside(*arguments):
    """In a process of its own: a term that is added stays."""
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_terms_may_be_added_from_outside_while_blocks_are_in_use():
    """They do what the known terms do whose mechanisms they share, to the last bit."""
    done = outside("-c", OUTSIDE, str(EXAMPLES / "run_to_run_bias.py"))
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["same"]
    assert told["gyroscope"]
    assert told["accelerometer"]
    words = ("key `turn_on_bias` already", "sensor term of that name", '"furlongs"', "to_run_bias")
    assert all(word in text for word, text in zip(words, told["refused"], strict=True))


@pytest.mark.slow
def test_a_term_of_a_users_own_runs_from_a_scenario_to_table_and_picture(tmp_path):
    own, file = EXAMPLES / "run_to_run_bias.py", EXAMPLES / "run_to_run_bias.yaml"
    command = ("-m", "mcsim", "run", str(file), "--output", str(tmp_path))
    done = outside(*command, "--with", str(own))
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "run_to_run_bias"
    table = pd.read_csv(folder / "table.csv")
    assert len(table.drop_duplicates(table.columns[:2].tolist())) == 6
    sources = set(pd.read_csv(folder / "budget.csv")["source"])
    assert {"gyroscope run-to-run bias", "accelerometer cross-axis sensitivity"} <= sources
    assert (folder / "figure.png").stat().st_size > 10_000
    without = outside(*command)
    assert without.returncode == 2
    assert "cross_axis_sensitivity: the scenario has no scalar of that name" in without.stderr
