"""Scenario files: what is read, and that every kind of bad input gets one clear message."""

import json

import jsonschema
import pytest

from mcsim import InputError, Scenario
from mcsim.papers.shipped import shipped_scenarios
from mcsim.scenario_file.schema import scenario_schema
from mcsim.units import STANDARD_GRAVITY as G
from mcsim.vibration.scenario import read_vibration, vibration_schema
from tests.conftest import BASE, BASE_YAML, density, scenario


def refuse(text: str) -> str:
    with pytest.raises(InputError) as error:
        _ = Scenario.from_yaml(text).points
    return str(error.value)


def test_base_case_is_read_in_si():
    s = Scenario.from_yaml(BASE_YAML)
    assert s.base.trajectory.speed == 20.0
    assert density(s.base.sensors.accelerometer) == 2.2e-3
    assert density(s.base.sensors.gyroscope) == pytest.approx(0.03 * 3.141592653589793 / 180)
    assert s.n_points == 4
    assert [axis.column for axis in s.axes] == [
        "sensors.accelerometer.noise_density [m/s^2/√Hz]",
        "sensors.gyroscope.noise_density [°/s/√Hz]",
    ]


def test_yaml_1_2_numbers_and_words():
    """YAML 1.1 reads 1e-3 as text, `no` as false and 1:30 as 90."""
    s = Scenario.from_yaml(BASE_YAML.replace("realizations: 200", "realizations: 1e3"))
    assert s.base.monte_carlo.realizations == 1000
    s = Scenario.from_yaml(BASE_YAML + "title: no\n")
    assert s.base.title == "no"
    s = Scenario.from_yaml(BASE_YAML + "title: 1:30\n")
    assert s.base.title == "1:30"


BAD = [
    ("speed: 20 m/s", "speed: 20", 'scenario:2: trajectory.speed: "20" has no unit'),
    ("speed: 20 m/s", "speed: 20 Hz", "a speed is needed"),
    ("speed: 20 m/s", "speed: 20 furlongs", 'unknown unit "furlongs"'),
    ("speed: 20 m/s", "speed: -20 m/s", "must be at least 0.001 m/s"),
    ("speed: 20 m/s", "speed: nan m/s", "not a finite number"),
    ("speed: 20 m/s", "speed: .inf", "not a finite number"),
    ("speed: 20 m/s", "speed: [1, 2]", "expected a speed"),
    ("speed: 20 m/s", "sped: 20 m/s", 'did you mean "speed"'),
    ("speed: 20 m/s, ", "", "trajectory.speed: is missing; write for example `speed: 20 m/s`"),
    ("length: 50 m", "length: 0 m", "must be at least 0.001 m"),
    ("shape: half_cosine", "shape: half_cosin", 'did you mean "half_cosine"'),
    ("shape: half_cosine, ", "", "`shape` is missing"),
    ("rate: 100 Hz", "rate: -100 Hz", "must be greater than 0 Hz"),
    ("rate: 100 Hz", "rate: 0 Hz", "must be greater than 0 Hz"),
    ("sampling: fir", "sampling: fur", 'did you mean "fir"'),
    ("realizations: 200", "realizations: 0", "must be at least 1"),
    ("realizations: 200", "realizations: 1.5", "a whole number is needed"),
    ("realizations: 200", "realizations: true", "a whole number is needed here, not true"),
    ("realizations: 200", "precision: 101 %", "must be at most 100 %"),
    ("speed: 20 m/s", "speed: 1e300 m/s", "beyond any use"),
    ("speed: 20 m/s", "speed: 20 m/s, side_slip: 1e3 °", "must be at most 91.6732 °"),
    ("case: planar", "case: planar\nmap: &a {<<: *a}", "scenario"),
    ("case: planar", 'case: planar\ntitle: "\\uD800"', "surrogate"),
    (
        "[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]",
        "{from: 1 m/s²/√Hz, to: 2 m/s²/√Hz, step: 1}",
        'unknown key "step" (known here: from, to, points, scale)',
    ),
    (
        "initial:",
        "figure: {panels: [{errors: [along, heading]}]}\ninitial:",
        "errors of different units cannot share a panel",
    ),
    (
        "initial:",
        "figure: {panels: [{errors: along, x: trajectory.width}]}\ninitial:",
        "is not swept here",
    ),
    ("realizations: 200", "realizations: many", "a whole number is needed"),
    ("realizations: 200", "precision: 1 %, realizations: 200", "not both"),
    ("realizations: 200, ", "", "write `realizations: 1000`, or `precision: 1 %`"),
    ("realizations: 200", "precision: 0.01", "has no unit"),
    ("seed: 1", "seed: -1", "must be at least 0"),
    ("confidence: 3 sigma", "confidence: 3", "has no unit"),
    ("case: planar", "case: plane", 'did you mean "planar"'),
    ("case: planar", "kase: planar", "case: is missing"),
    ("[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]", "[]", "the list of values is empty"),
    ("[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]", "[1e-3 m/s^2/√Hz, 1e-3 m/s²/√Hz]", "occurs twice"),
    ("[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]", "[1e-3]", "has no unit"),
    ("[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]", "[1 m]", "is a length"),
    ("[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]", "[-1 m/s²/√Hz]", "must be at least 0"),
    ("[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]", "7", "write a list of values"),
    (
        "[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]",
        "{from: 1 m/s²/√Hz, to: 2 m/s²/√Hz, points: 1000000000}",
        "must be at most 100000",
    ),
    (
        "[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]",
        "{from: 1 m/s²/√Hz, to: 2 m/s²/√Hz, points: 60000}",
        "120,000 points are more than",
    ),
    (
        "[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]",
        "{from: 0 m/s²/√Hz, to: 2 m/s²/√Hz, points: 3, scale: log}",
        "a log scale needs",
    ),
    (
        "[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]",
        "{from: 1 m/s²/√Hz, to: 1 m/s²/√Hz, points: 3}",
        "are equal",
    ),
    (
        "[1e-3 m/s^2/√Hz, 1e-2 m/s^2/√Hz]",
        "{form: 1 m/s²/√Hz, to: 1 m/s²/√Hz, points: 3}",
        'did you mean "from"',
    ),
    (
        "  sensors.gyroscope.noise_density:",
        "  sensors.gyroscope.noise_densty:",
        'did you mean "sensors.gyroscope.noise_density"',
    ),
    ("  sensors.gyroscope.noise_density:", "  figure.title:", "cannot be swept"),
    ("  rate: 100 Hz", "\trate: 100 Hz", "a tab where YAML wants blanks"),
    ("case: planar", "case: planar\ncase: planar", "duplicate key"),
    ("case: planar", "case: [planar", "scenario:"),
    ("case: planar", "case: planar\n---\ncase: planar", "scenario"),
    ("{speed_error: 0 m/s, direction_error: 0 °}", "5", "a block of `key: value` lines"),
]


@pytest.mark.parametrize(("old", "new", "message"), BAD, ids=[f"{new}"[:40] for _, new, _ in BAD])
def test_bad_input_is_explained(old, new, message):
    assert old in BASE_YAML
    text = refuse(BASE_YAML.replace(old, new, 1))
    assert message in text
    assert "Traceback" not in text


def test_messages_name_file_and_line(scenario_file):
    path = scenario_file(BASE_YAML.replace("rate: 100 Hz", "rate: 100"))
    with pytest.raises(InputError) as error:
        Scenario.from_yaml(path)
    assert str(error.value).startswith(f"{path}:4: sensors.rate:")


@pytest.mark.parametrize("text", ["\n", "# nothing\n\n", "- a\n- list\n", "just text\n\n"])
def test_files_that_are_no_scenario(text):
    assert "scenario" in refuse(text)


def test_unreadable_files(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        Scenario.from_yaml(tmp_path / "absent.yaml")
    with pytest.raises(InputError, match="is a directory"):
        Scenario.from_yaml(tmp_path)
    latin = tmp_path / "latin.yaml"
    latin.write_bytes(BASE_YAML.encode("latin-1", "replace"))
    with pytest.raises(InputError, match="not UTF-8"):
        Scenario.from_yaml(latin)
    large = tmp_path / "large.yaml"
    large.write_bytes(b"#" * (2 << 20))
    with pytest.raises(InputError, match="larger than"):
        Scenario.from_yaml(large)


def test_alias_bombs_are_defused():
    bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n"
    for i in range(1, 9):
        bomb += f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n"
    assert "expands to more than" in refuse(bomb)


def test_a_file_that_contains_itself_is_refused():
    assert refuse("case: planar\ntrajectory: &a\n  b: *a\n")


def test_deep_nesting_is_refused():
    assert refuse("a: " + "[" * 3000 + "]" * 3000 + "\n\n")


def test_tags_are_refused():
    assert refuse("case: !!python/object:os.system planar\n\n")


def test_overrides_replace_values_in_any_way():
    s = Scenario.from_yaml(
        BASE_YAML,
        ["sensors.rate=200 Hz", "sweep.trajectory.speed=[10 m/s, 72 km/h]", "title=hello"],
    )
    assert s.base.sensors.rate == 200.0
    assert s.base.title == "hello"
    assert s.axes[-1].values == (10.0, 20.0)
    assert scenario({"sweep": None}).axes == ()


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("sensors.rate", "write path=value"),
        ("sensors.rat=1 Hz", 'did you mean "rate"'),
        ("senors.rate=1 Hz", 'did you mean "sensors.rate"'),
        ("sensors.rate=1", "--set sensors.rate: sensors.rate:"),
        ("sensors.gyroscope.noise_density=1 °/s/√Hz", "sweeps that value"),
    ],
)
def test_bad_overrides_are_explained(override, message):
    with pytest.raises(InputError) as error:
        Scenario.from_yaml(BASE_YAML, [override])
    assert message in str(error.value)


@pytest.mark.parametrize("how", ["sweep", "--set"])
@pytest.mark.parametrize(
    ("given", "last", "needs_list"),
    [
        ("1 mg", "x", True),
        ("1 mg", "0", True),
        (None, "2", True),
        (["1 mg", "2 mg", "3 mg"], "3", False),
        (["1 mg", "2 mg", "3 mg"], "x", False),
    ],
)
def test_wrong_paths_of_axes_say_what_to_write(how, given, last, needs_list):
    key = "sensors.accelerometer.turn_on_bias"
    path = f"{key}.{last}"
    base = scenario({key: given} if given else {})
    override = {f"sweep.{path}": ["1 mg"]} if how == "sweep" else {path: "1 mg"}
    with pytest.raises(InputError) as error:
        base.with_values(override)
    message = str(error.value)
    assert len(message.splitlines()) == 1
    assert f"there is no `{path}`: write `{key}` for all axes, or `{key}.0` to `.2`" in message
    assert ("after writing a list `turn_on_bias: [x, y, z]`" in message) == needs_list
    assert "*" not in message


def test_single_axes_of_a_list_are_swept():
    key = "sensors.accelerometer.turn_on_bias"
    s = scenario({key: ["1 mg", "2 mg", "3 mg"], f"sweep.{key}.1": ["5 mg", "6 mg"]})
    biases = [p.model.sensors.accelerometer.turn_on_bias for p in s.points]
    assert biases[1] == pytest.approx([1e-3 * G, 6e-3 * G, 3e-3 * G])


def test_items_that_are_not_there_are_named():
    points = {"shape": "waypoints", "points": [["0 m", "0 m"], ["9 m", "0 m"], ["20 m", "1 m"]]}
    points |= {"speed": "5 m/s", "lead": "100 ms"}
    with pytest.raises(InputError, match=r"sweep\.trajectory\.points\.3\.0: there is no item 3"):
        scenario({"trajectory": points, "sweep.trajectory.points.3.0": ["1 m", "2 m"]})
    with pytest.raises(InputError, match=r'did you mean "sensors\.accelerometer\.turn_on_bias"'):
        scenario({"sweep.sensors.accelerometer.turn_on_bais": ["1 mg"]})


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("-1 mg", 'turn_on_bias: "-1 mg" must be at least 0 mg'),
        (["1 mg", "-1 m/s²", "0 g"], 'turn_on_bias.1: "-1 m/s²" must be at least 0 m/s²'),
    ],
)
def test_bounds_of_axes_have_their_unit(given, said):
    with pytest.raises(InputError) as error:
        scenario({"sensors.accelerometer.turn_on_bias": given})
    assert str(error.value).endswith(said)


def test_sensors_come_from_the_catalogue_and_can_be_changed():
    s = scenario({"sensors.accelerometer": "LSM330DL", "sensors.gyroscope": "L3G4200D"})
    assert density(s.base.sensors.accelerometer) == 2.2e-3
    s = scenario({"sensors.accelerometer": {"model": "LIS3DH", "miscalibration": "1 mg"}})
    assert density(s.base.sensors.accelerometer) == 2.2e-3
    assert s.base.sensors.accelerometer.miscalibration == (9.80665e-3,)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("LSM330D", 'did you mean "LSM330DL"'),
        ("LIS33DE", "gives no noise density"),
        ("L3G4200D", "has no accelerometer"),
    ],
)
def test_wrong_sensors_are_explained(name, message):
    with pytest.raises(InputError, match=message):
        scenario({"sensors.accelerometer": name})


def test_sensors_can_be_swept_by_name():
    s = scenario({"sweep": {"sensors.gyroscope": ["LSM330DL", "CMR3000-D01"]}})
    assert [density(p.model.sensors.gyroscope) > 1e-3 for p in s.points] == [False, True]


def test_white_noise_as_random_walk_is_converted_once():
    s = scenario({"sensors.gyroscope": {"angle_random_walk": "0.2 °/√h"}})
    assert density(s.base.sensors.gyroscope) == pytest.approx(
        2**0.5 * 0.2 / 60 * 3.141592653589793 / 180
    )
    with pytest.raises(InputError, match="twice"):
        scenario({"sensors.gyroscope.angle_random_walk": "0.2 °/√h"})


def test_any_scalar_can_be_swept_in_three_dimensions():
    s = scenario(
        {
            "sweep": {
                "sensors.sampling": ["fir", "none"],
                "trajectory.width": {"from": "1 m", "to": "5 m", "points": 3},
                "monte_carlo.seed": {"from": 1, "to": 3, "points": 3},
            }
        }
    )
    assert s.n_points == 18
    assert s.points[-1].model.monte_carlo.seed == 3
    assert s.points[-1].model.trajectory.width == 5.0


def test_scenarios_are_frozen():
    with pytest.raises(ValueError, match="frozen"):
        scenario().base.sensors.rate = 3.0


def test_schema_accepts_what_is_shipped_and_refuses_slips():
    from ruamel.yaml import YAML

    schemas = [scenario_schema(), vibration_schema()]
    for schema in schemas:
        jsonschema.Draft7Validator.check_schema(schema)
    validator, of_vibration = map(jsonschema.Draft7Validator, schemas)
    files = sorted(shipped_scenarios().rglob("*.yaml"))
    assert files
    for path in files:
        tree = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
        own = of_vibration if tree["case"] == "vibration" else validator
        own.validate(json.loads(json.dumps(tree)))
    for slip in (
        {**BASE, "case": "plane"},
        {**BASE, "sensors": {**BASE["sensors"], "rate": 100}},
        {**BASE, "trajectory": {**BASE["trajectory"], "lenght": "1 m"}},
    ):
        assert not validator.is_valid(slip)


@pytest.mark.parametrize("path", sorted(shipped_scenarios().rglob("*.yaml")), ids=lambda p: p.stem)
def test_shipped_scenarios_are_valid(path):
    from mcsim.sweep import check_points

    if path.parent.name == "vibration":
        read_vibration(path)
    else:
        check_points(Scenario.from_yaml(path))


def test_confidences_and_large_seeds_can_be_swept():
    s = scenario({"sweep": {"monte_carlo.confidence": ["90 %", "95 %", "3 sigma"][:2]}})
    assert [round(p.model.monte_carlo.confidence, 3) for p in s.points] == [1.645, 1.96]
    s = scenario({"sweep": {"monte_carlo.seed": [2**64 - 2, 2**64 - 1]}})
    assert [p.model.monte_carlo.seed for p in s.points] == [2**64 - 2, 2**64 - 1]


def test_messages_blame_the_sweep_or_the_option_that_is_wrong():
    with pytest.raises(InputError, match=r"scenario:13: trajectory\.radius: unknown key"):
        Scenario.from_yaml(BASE_YAML + "  trajectory.radius: [1 m, 2 m]\n")
    with pytest.raises(
        InputError, match=r"--set trajectory\.shape: trajectory\.shape: .foo. is not"
    ):
        Scenario.from_yaml(BASE_YAML, ["trajectory.shape=foo"])


def test_errors_of_a_block_name_the_block():
    with pytest.raises(InputError, match=r"trajectory: angle must not be zero"):
        scenario(
            {"trajectory": {"shape": "curve", "radius": "9 m", "angle": "0 °", "speed": "9 m/s"}}
        )


@pytest.mark.parametrize("path", ["sensors.².rate", "trajectory.points.01.0"])
def test_odd_digits_are_no_list_index(path):
    assert "no scalar of that name" in refuse(BASE_YAML + f"  {path}: [1 Hz]\n")


def test_a_sweep_that_is_switched_off_needs_no_other_figure():
    panel = "figure: {panels: [{errors: along, x: sensors.gyroscope.noise_density}]}\n"
    swept = Scenario.from_yaml(BASE_YAML + panel)
    assert swept.n_points == 4
    assert Scenario.from_yaml(BASE_YAML + panel, ["sweep=null"]).n_points == 1


def test_the_most_realizations_belong_to_a_precision():
    sought = BASE_YAML.replace("realizations: 200", "precision: 1 %, max_realizations: 5000")
    s = Scenario.from_yaml(sought)
    assert s.base.monte_carlo.most_realizations == 5000
    # What the command line does with `--realizations`.
    none = {"monte_carlo.precision": None, "monte_carlo.max_realizations": None}
    assert s.with_values({"monte_carlo.realizations": 50, **none}).base.monte_carlo.realizations


def test_a_number_of_thousands_of_digits_is_named_with_its_line():
    text = BASE_YAML.replace("seed: 1", "seed: " + 5000 * "9")
    assert ":9: a number of more than 4000 digits" in refuse(text)
