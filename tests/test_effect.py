"""Keys that are written without effect are told; those that act are not."""

import pytest

from mcsim import Scenario, run
from mcsim.papers.shipped import velocity_sensor
from mcsim.scenario_file.effect import COMMON, of_terms, without_effect
from mcsim.systems import SYSTEMS
from tests import conftest, strapdown

RECORDED = {
    "trajectory": {"shape": "recorded", "file": "none.csv",
                   "columns": {"time": "t in s", "x": "x in m", "y": "y in m"}},
}  # fmt: skip
RECORDED_ATTITUDE = {
    "trajectory": {"shape": "recorded", "file": "none.csv",
                   "columns": {"time": "t in s", "x": "x in m", "y": "y in m",
                               "roll": "r in °", "pitch": "p in °"}},
}  # fmt: skip


class Velocity:
    """A scenario of the velocity case with other values."""

    @staticmethod
    def scenario(values):
        return velocity_sensor("a1", **values)[0]


#: Where a key has no effect: the case, other values, and the key; then what makes it act.
CASES = [
    (conftest, {}, "monte_carlo.max_realizations", 5000,
     {"monte_carlo.realizations": None, "monte_carlo.precision": "1 %"}),
    (conftest, {"monte_carlo.realizations": None, "monte_carlo.estimator": "linear"},
     "monte_carlo.precision", "1 %", {"monte_carlo.estimator": "plain"}),
    *((conftest, {"monte_carlo.estimator": "linear"}, f"monte_carlo.{key}", value,
       {"monte_carlo.estimator": "plain"})
      for key, value in (("confidence", "95 %"), ("resamples", 200), ("offsets", "sobol"))),
    *(case
      for element, unit in (("accelerometer", "m/s²"), ("gyroscope", "°/s"))
      for case in (
          (conftest, {f"sensors.{element}.gauss_markov.deviation": f"0 {unit}"},
           f"sensors.{element}.gauss_markov.correlation_time", "3 s",
           {f"sensors.{element}.gauss_markov.deviation": [f"0 {unit}", f"0 {unit}", f"1 {unit}"]}),
          (conftest, {f"sensors.{element}.spikes.rate": "0 Hz"},
           f"sensors.{element}.spikes.amplitude", f"1 {unit}",
           {f"sensors.{element}.spikes.rate": "1 Hz"}),
          (conftest, {f"sensors.{element}.spikes.amplitude": f"0 {unit}"},
           f"sensors.{element}.spikes.rate", "1 Hz",
           {f"sensors.{element}.spikes.amplitude": f"1 {unit}"}),
          *((conftest, {f"sensors.{element}.{order}_nonlinearity.deviation": "0 %"},
             f"sensors.{element}.{order}_nonlinearity.full_scale", f"20 {unit}",
             {f"sensors.{element}.{order}_nonlinearity.deviation": "1 %"})
            for order in ("quadratic", "cubic")),
      )),
    (strapdown, {"reconstruction.algorithm": "planar"}, "initial.levelling", {"duration": "1 s"},
     {"reconstruction.algorithm": "strapdown"}),
    (conftest, {}, "trajectory.side_slip_profile", "bump", {"trajectory.side_slip": "1 °"}),
    (conftest, {}, "reconstruction.intervals", "nominal", {"sensors.time.lost": "1 %"}),
    (strapdown, {}, "body.roll.natural_frequency", "2 Hz", {"body.roll.gradient": "1 °/(m/s²)"}),
    (strapdown, {}, "body.roll.damping", "40 %", {"body.roll.gradient": "1 °/(m/s²)"}),
    (strapdown, {}, "body.pitch.natural_frequency", "2 Hz", {"body.pitch.gradient": "1 °/(m/s²)"}),
    (strapdown, {"body.pitch.gradient": "1 °/(m/s²)", "body.pitch.natural_frequency": "0 Hz"},
     "body.pitch.damping", "40 %", {"body.pitch.natural_frequency": "2 Hz"}),
    (conftest, RECORDED, "trajectory.angles", "mathematical",
     {"trajectory.columns.heading": "h in °"}),
    (strapdown, RECORDED, "trajectory.pitch_positive", "nose_up", RECORDED_ATTITUDE),
    (conftest, RECORDED_ATTITUDE, "trajectory.columns.roll", "r in °", None),
    (conftest, RECORDED_ATTITUDE, "trajectory.columns.pitch", "p in °", None),
    (Velocity, {}, "body.height", "0.1 m", {"body.pitch.gradient": "1 °/(m/s²)"}),
    (Velocity, {}, "body.pitch.damping", "40 %", {"body.pitch.gradient": "1 °/(m/s²)"}),
    (conftest, {}, "sensors.gyroscope.misalignment", "1 °", None),
    (conftest, {}, "monte_carlo.common_random_numbers", True,
     {"sweep": {"sensors.rate": ["50 Hz", "100 Hz"]}}),
]  # fmt: skip


def told(case, values):
    return without_effect(case.scenario(values))


@pytest.mark.parametrize(("case", "where", "key", "value", "acting"), CASES)
def test_a_key_without_effect_is_told_and_one_with_effect_is_not(case, where, key, value, acting):
    sentences = told(case, {**where, key: value})
    assert len([s for s in sentences if f": {key} has no effect: " in s]) == 1
    if acting is not None:
        changed = {**where, key: value, **acting}
        if "trajectory" in acting:
            changed = {**acting, key: value}
        assert not [s for s in told(case, changed) if key in s]


def test_every_rule_is_tried():
    tried = {key for _, _, key, _, _ in CASES} | {"body.pitch.damping", "body.roll.damping"}
    of_cases = (key for case in SYSTEMS.values() for key in case.idle)
    assert {rule.path for rule in [*COMMON, *of_terms(), *of_cases]} <= tried


def test_a_sweep_in_which_the_key_acts_somewhere_is_silent():
    values = {"body.roll.damping": "40 %",
              "sweep": {"body.roll.gradient": ["0 °/(m/s²)", "1 °/(m/s²)"]}}  # fmt: skip
    assert told(strapdown, values) == []
    values["sweep"] = {"body.roll.damping": ["20 %", "40 %"]}
    assert len(told(strapdown, values)) == 1


def test_what_a_run_resolves_to_is_silent():
    """Resolved scenarios write all that holds by default."""
    base = conftest.scenario({}).base.model_dump(mode="json", exclude_none=True)
    assert without_effect(Scenario.from_dict(base)) == []


def test_the_note_names_file_and_line(tmp_path):
    path = tmp_path / "s.yaml"
    text = conftest.BASE_YAML.replace("seed: 1", "seed: 1, max_realizations: 5000")
    path.write_text(text, encoding="utf-8")
    (sentence,) = without_effect(Scenario.from_yaml(path))
    assert sentence.startswith(f"{path}:9: monte_carlo.max_realizations has no effect")


def test_the_check_of_a_linear_answer_is_the_same_whatever_its_intervals_would_be():
    """At 95 % some of forty statistics would be called contradicted by chance."""

    def notes(values):
        scenario = conftest.scenario({"monte_carlo.estimator": "linear", **values})
        return list(run(scenario).table["note"].fillna(""))

    asked = {"confidence": "95 %", "resamples": 200, "offsets": "sobol"}
    told = notes({f"monte_carlo.{key}": value for key, value in asked.items()})
    assert told == notes({})
    assert not any("contradicts" in note for note in told)


@pytest.mark.parametrize(
    ("values", "path"),
    [
        ({"sensors.temperature": {"difference": "5 K"}}, "sensors.temperature"),
        (
            {"sensors.gyroscope.temperature_scale": "0.01 %/K"},
            "sensors.gyroscope.temperature_scale",
        ),
    ],
)
def test_a_temperature_without_its_terms_is_told_and_the_other_way_round(values, path):
    found = [text for text in without_effect(conftest.scenario(values)) if path in text]
    assert len(found) == 1
    assert "has no effect" in found[0]
    both = {
        "sensors.temperature": {"difference": "5 K"},
        "sensors.gyroscope.temperature_scale": "0.01 %/K",
    }
    assert not [text for text in without_effect(conftest.scenario(both)) if "temperature" in text]
