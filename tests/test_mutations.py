"""Strange inputs end in a result with finite or noted numbers, or in one sentence.

Shipped scenarios are changed at random, with fixed seeds: numbers to extremes, units to others,
keys dropped, repeated and moved, types swapped.  Whatever comes out of it must be a valid
scenario or an ``InputError`` that names what is wrong.
"""

import copy
import json
import random
import time
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from mcsim import InputError
from mcsim.results import check
from mcsim.scenario_file import Scenario
from mcsim.units import KINDS, parse, parse_confidence

SHIPPED = sorted(Path("scenarios").glob("[psv]*/*.yaml"))
EXTREME = (
    *("0", "-1", "1e300", "-1e300", "1e-300", "1e400", "nan", ".inf", "9" * 5000, "", " ", "~"),
    *("1e8 m", "1e-30 m/s", "1e-3 m/s", "1e5 Hz", "0.1 Hz", "1e6 °", "1e6 rad", "1e5 s", "100 %"),
    *("[" * 6000, "\u202e", "\x00", "½ m", "1e-19 m/s²", "1e-25 m/s²", "none", "recorded"),
    *(0, 1, -1, 2**64, 10**400, True, None, [], {}, [1], 1e308, -1e-320),
)
#: CPU time that one input may take (s), on a slow machine.
LONGEST = 20.0


def trees():
    reader = YAML(typ="safe", pure=True)
    plain = [json.loads(json.dumps(reader.load(path.read_text()))) for path in SHIPPED]
    return [tree for tree in plain if tree["case"] != "vibration"]


def slots(node):
    """Every place in a tree: its container and key."""
    found = []
    items = node.items() if isinstance(node, dict) else enumerate(node)
    for key, value in list(items):
        found.append((node, key))
        if isinstance(value, dict | list):
            found += slots(value)
    return found


def other_number(value, generator):
    """A quantity with another number or another unit."""
    if not isinstance(value, str) or " " not in value:
        return generator.choice(EXTREME)
    number, unit = value.split(" ", 1)
    if generator.random() < 0.3:
        kind = generator.choice(list(KINDS.values()))
        return f"{number} {generator.choice(list(kind.factors))}"
    if generator.random() < 0.5:
        return f"{generator.choice(['0', '-1', '1e300', '1e-300', 'nan', '1e-19', '1e7'])} {unit}"
    try:
        return f"{float(number) * 10.0 ** generator.uniform(-6.0, 6.0):.6g} {unit}"
    except ValueError:
        return unit


def mutated(tree, generator):
    tree = copy.deepcopy(tree)
    for _ in range(generator.choice([1, 1, 2, 3])):
        places = slots(tree)
        if not places:
            break
        container, key = generator.choice(places)
        change = generator.randrange(6)
        if change <= 1:
            container[key] = other_number(container[key], generator)
        elif change == 2:
            container[key] = generator.choice(EXTREME)
        elif change == 3:
            del container[key]
        elif change == 4:
            container[key] = [container[key]]
        elif isinstance(container, dict):
            elsewhere = generator.choice(places)[1]
            container[str(elsewhere)] = container.pop(key)
    return tree


def refusal(attempt, *arguments, **keywords):
    """What is said against some input, which must be readable; None if it is accepted."""
    begun = time.process_time()
    message = None
    try:
        attempt(*arguments, **keywords)
    except InputError as error:
        message = str(error)
    assert time.process_time() - begun < LONGEST
    assert message is None or message.strip()
    assert " object at 0x" not in (message or "")
    return message


def checked(tree, **keywords):
    check(Scenario.from_dict(tree, folder=Path("scenarios/paper"), **keywords))


@pytest.mark.slow
def test_mutated_scenarios_are_refused_or_valid():
    generator = random.Random(1)
    shipped = trees()
    for tree in shipped:
        tree["monte_carlo"] = {"realizations": 20}
        for key in ("sweep", "figure"):  # so that one point is checked, not hundreds
            tree.pop(key, None)
    said = [refusal(checked, mutated(generator.choice(shipped), generator)) for _ in range(400)]
    assert 20 < said.count(None) < 380


def test_mutated_texts_and_overrides_are_refused_or_valid():
    generator = random.Random(2)
    texts = [path.read_text() for path in SHIPPED if "vibration" not in str(path)]
    for _ in range(40):
        text = bytearray(generator.choice(texts).encode())
        for _ in range(generator.choice([1, 2, 8])):
            place = generator.randrange(len(text))
            if generator.random() < 0.5:
                text[place] ^= 1 << generator.randrange(8)
            else:
                del text[place : place + generator.choice([1, 5, 40])]
        refusal(Scenario.from_yaml, text.decode("utf-8", "replace") + "\n")
    base = Scenario.from_yaml(next(p for p in SHIPPED if p.stem == "figure1"))
    paths = ["sensors.rate", "trajectory", "sweep.trajectory.speed", "sweep", "a.b", "..", "case"]
    for _ in range(40):
        override = f"{generator.choice(paths)}={generator.choice(EXTREME)}"
        refusal(base.with_values, [override])


def test_mutated_quantities_are_finite_or_refused():
    generator = random.Random(3)
    units = sorted({unit for kind in KINDS.values() for unit in kind.factors})
    signs = [*units, *"°µ√²³/^*().-+eE0123456789 \t½⁻", "sqrt(", "deg", "1e300", "1e-300", "nan"]
    for _ in range(2000):
        kind = generator.choice(list(KINDS.values()))
        text = generator.choice(["1", "-1", "1e300", "1e-300", "1e-20", "9" * 400, ""]) + "".join(
            generator.choices(signs, k=generator.choice([1, 2, 3, 5]))
        )
        try:
            value = parse_confidence(text) if kind.name == "confidence" else parse(text, kind)
        except InputError:
            continue
        assert value == 0.0 or 1e-30 <= abs(value) <= kind.largest


@pytest.mark.parametrize(
    ("case", "overrides"),
    [
        ("strapdown", {"trajectory.speed": "0.02 m/s"}),  # hours of a leaning body
        ("strapdown", {"trajectory.speed": "0.001 m/s"}),
        ("planar", {"trajectory.speed": "0.001 m/s"}),
        ("planar", {"monte_carlo.resamples": 100_000, "monte_carlo.realizations": 20_000_000}),
        ("planar", {"outputs.history": True, "trajectory.speed": "0.01 m/s"}),
        ("planar", {"outputs.tracks": 1000, "trajectory.speed": "0.1 m/s"}),
        ("curve", {"trajectory.angle": "1e6 rad", "trajectory.radius": "1e-3 m"}),
    ],
)
def test_work_is_judged_before_it_begins(case, overrides):
    """Long drives are checked, or refused, at once."""
    track = {"shape": "half_cosine", "length": "50 m", "width": "5 m", "speed": "20 m/s"}
    if case == "curve":
        track = {"shape": "curve", "radius": "10 m", "angle": "90 °", "speed": "20 m/s"}
    tree = {
        "case": "strapdown" if case == "strapdown" else "planar",
        "trajectory": track,
        "sensors": {"rate": "100 Hz", "accelerometer": "LSM330DL", "gyroscope": "LSM330DL"},
        "monte_carlo": {"realizations": 10},
    }
    if case == "strapdown":
        tree["body"] = {"roll": {"gradient": "0.3 °/(m/s²)"}}
    begun = time.process_time()
    said = refusal(checked, tree, overrides=overrides)
    assert time.process_time() - begun < 5.0
    assert said is None or any(word in said for word in ("shorten", "fewer", "lower", "at most"))


def test_memory_beyond_a_points_share_is_refused_with_the_key():
    with pytest.raises(InputError, match=r"outputs.history: takes .* GiB .*shorten the drive"):
        check(
            Scenario.from_yaml(
                next(p for p in SHIPPED if p.stem == "figure1"),
                {"sweep": {"trajectory.speed": ["0.05 m/s"]}, "outputs": {"history": True}},
            )
        )
