"""The closed table of units."""

import math
import re

import pytest

from mcsim.errors import UnitError
from mcsim.units import (
    KINDS,
    canonical_unit,
    density_from_random_walk,
    in_unit,
    parse,
    parse_confidence,
    sample_deviation,
)

DEG = math.pi / 180


@pytest.mark.parametrize(
    ("text", "kind", "si"),
    [
        ("20 m/s", "speed", 20.0),
        ("72 km/h", "speed", 20.0),
        ("100 Hz", "frequency", 100.0),
        ("1.344 kHz", "frequency", 1344.0),
        ("100 ms", "time", 0.1),
        ("0.1 deg", "angle", 0.1 * DEG),
        ("0.1°", "angle", 0.1 * DEG),
        ("1e-3 m/s^2", "acceleration", 1e-3),
        ("1 g", "acceleration", 9.80665),
        ("3 mg", "acceleration", 3 * 9.80665e-3),
        # 220 ug/sqrt(Hz) is 220e-6 * 9.80665 m/s^2/sqrt(Hz): not micrograms, not per hertz
        ("220 µg/√Hz", "acceleration noise density", 220e-6 * 9.80665),
        ("220 μg/√Hz", "acceleration noise density", 220e-6 * 9.80665),
        ("220 ug/sqrt(Hz)", "acceleration noise density", 220e-6 * 9.80665),
        ("2.2e-3 m/s**2/√Hz", "acceleration noise density", 2.2e-3),
        ("0.03 °/s/√Hz", "angular rate noise density", 0.03 * DEG),
        ("0.03 deg/s/sqrt(Hz)", "angular rate noise density", 0.03 * DEG),
        ("0.03 dps/rtHz", "angular rate noise density", 0.03 * DEG),
        # 0.2 degrees per root hour: not degrees per hour
        ("0.2 °/√h", "angle random walk", 0.2 * DEG / 60),
        ("0.2 deg/sqrt(h)", "angle random walk", 0.2 * DEG / 60),
        ("0.1 m/s/√h", "velocity random walk", 0.1 / 60),
        ("360 °/h", "angular rate", 0.1 * DEG),
        # metre per second and hour: bias instability in the thesis's Table 5.5
        ("3.6 m/s/h", "acceleration", 1e-3),
        ("216 m/s/h^1.5", "acceleration random walk", 1e-3),
        ("216 m/s/h^(3/2)", "acceleration random walk", 1e-3),
        ("60 mg/√h", "acceleration random walk", 9.80665e-3),
        ("1e-3 m/s^2/sqrt(s)", "acceleration random walk", 1e-3),
        ("216000 deg/h^1.5", "rate random walk", DEG),
        ("60 °/s/√h", "rate random walk", DEG),
        ("3 m s^-2", "acceleration", 3.0),
        ("3 m/s2", "acceleration", 3.0),
        ("3 rad s^-1", "angular rate", 3.0),
        ("5 ns", "time", 5e-9),
        ("-5 m", "length", -5.0),
        ("1 %", "ratio", 0.01),
        # 5 m/s/h^1.5: per hour and per root hour
        ("5 m/s/h^1.5", "acceleration random walk", 5 / 3600 / 60),
        ("5 m/s/h^(3/2)", "acceleration random walk", 5 / 3600 / 60),
        ("2e-3 m/s^3/sqrt(Hz)", "acceleration random walk", 2e-3),
        ("10 deg/hr^1.5", "rate random walk", 10 * DEG / 3600 / 60),
        ("10 deg/h/sqrt(h)", "rate random walk", 10 * DEG / 3600 / 60),
        ("15 mGal", "acceleration", 1.5e-4),
        ("0.1 dps/g", "g-sensitivity", 0.1 * DEG / 9.80665),
        # Data sheets: brackets, roots as powers, roots in letters, products, rms, one sigma.
        ("0.06 (m/s)/√h", "velocity random walk", 0.06 / 60),
        ("0.06 m/(s √h)", "velocity random walk", 0.06 / 60),
        ("2 m/s^1.5", "velocity random walk", 2.0),
        ("2 m/s^(3/2)", "velocity random walk", 2.0),
        ("2 m·s⁻²·Hz⁻¹ᐟ²", "acceleration noise density", 2.0),
        ("2 m s^-2 Hz^-0.5", "acceleration noise density", 2.0),
        ("0.01 (°/s)/√Hz", "angular rate noise density", 0.01 * DEG),
        ("36 °/hr/√Hz", "angular rate noise density", 0.01 * DEG),
        ("10 mdps/√Hz", "angular rate noise density", 0.01 * DEG),
        ("0.01 deg/sec/rt Hz", "angular rate noise density", 0.01 * DEG),
        ("0.01 °/s/√Hz rms", "angular rate noise density", 0.01 * DEG),
        ("75 µg/Hz^(1/2)", "acceleration noise density", 75e-6 * 9.80665),
        ("75 µg/Hz^1/2", "acceleration noise density", 75e-6 * 9.80665),
        ("75 ug/rt-Hz", "acceleration noise density", 75e-6 * 9.80665),
        ("75 µg/√(Hz)", "acceleration noise density", 75e-6 * 9.80665),
        ("0.2 deg/rt-hr", "angle random walk", 0.2 * DEG / 60),
        ("0.2 deg per square root hour", "angle random walk", 0.2 * DEG / 60),
        ("2 rad/s^0.5", "angle random walk", 2.0),
        ("2 m/s^2.5", "acceleration random walk", 2.0),
        ("0.5 mg rms", "acceleration", 0.5e-3 * 9.80665),
        ("0.5 mg (1σ)", "acceleration", 0.5e-3 * 9.80665),
        ("−5 m", "length", -5.0),
        ("800 rpm", "rotational speed", 800 / 60),
    ],
)
def test_quantities_as_people_write_them(text, kind, si):
    assert parse(text, KINDS[kind]) == pytest.approx(si, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("20", "speed", 'has no unit; write for example "20 m/s"'),
        ("20 m", "speed", "is a length; a speed is needed"),
        ("20 m/s·√h", "velocity random walk", "unknown unit"),  # (m/s)·√h or m/(s·√h)
        ("20 ms^-2", "acceleration", "unknown unit"),  # per square millisecond?
        ("20 mg p-p", "acceleration", "unknown unit"),
        ("20 mg (3σ)", "acceleration", "unknown unit"),
        ("±2 g", "acceleration", "without the sign ±"),
        ("0.061 mg/LSB", "acceleration", 'as a resolution write "0.061 mg"'),
        ("16384 LSB/g", "acceleration", 'as a resolution write "6.10352e-05 g"'),
        ("3 LSB", "acceleration", "a step of the converter is no unit"),
        ("2 Deg/s", "angular rate", 'did you mean "°/s"'),
        ("2 µg/Hz", "acceleration noise density", 'did you mean "µg/√Hz"'),
        ("0.2 °/√h", "angular rate noise density", 'write it under "angle_random_walk"'),
        ("nan m", "length", "not a finite number"),
        ("inf m", "length", "not a finite number"),
        ("-.inf m", "length", "not a finite number"),
        ("1e999 m", "length", "too large"),
        ("1,5 m", "length", "decimal point"),
        ("fast", "speed", "does not begin with a number"),
        ("", "speed", "does not begin with a number"),
    ],
)
def test_wrong_quantities_are_explained(text, kind, message):
    with pytest.raises(UnitError) as error:
        parse(text, KINDS[kind])
    assert message in str(error.value)


def test_every_unit_of_the_table_is_its_own_canonical_spelling():
    for kind in KINDS.values():
        for unit in kind.factors:
            assert canonical_unit(unit) == unit


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_advice_is_never_wrong_by_a_factor(kind):
    """A unit in other letters, or with a prefix that the table lacks, and what is advised."""
    for unit in kind.factors:
        for wrong in (unit.upper(), unit.title(), f"m{unit}", f"M{unit}", f"k{unit}", f"{unit}x"):
            if canonical_unit(wrong) in kind.factors:
                continue
            with pytest.raises(UnitError) as error:
                parse(f"1 {wrong}", kind)
            advice = re.search(r'did you mean "(.*?)"', str(error.value))
            assert advice is None or advice[1].lower() == unit.lower()


def test_units_survive_the_way_out_and_back():
    for kind in KINDS.values():
        for unit, factor in kind.factors.items():
            if math.isfinite(factor):
                assert in_unit(parse(f"3.7 {unit}", kind), unit, kind) == 3.7


def test_confidence_in_sigma_and_percent_agree():
    assert parse_confidence("3 sigma") == 3.0
    # 99.73 % is the rounded probability of 3 sigma (0.99730020...)
    assert parse_confidence("99.73002039367398 %") == pytest.approx(3.0, abs=1e-9)
    assert parse_confidence("95 %") == pytest.approx(1.959963984540054, rel=1e-12)


@pytest.mark.parametrize("text", ["95", "100 %", "0 %", "9 sigma", "-1 sigma", "5 m"])
def test_impossible_confidences_are_refused(text):
    with pytest.raises(UnitError):
        parse_confidence(text)


def test_allan_white_noise_against_allantools():
    """Noise of a given N, made and analysed by a library that we did not write."""
    import allantools
    import numpy as np

    n, rate = 0.01, 100.0
    deviation = sample_deviation(density_from_random_walk(n), rate)
    noise = deviation * np.random.default_rng(5).standard_normal(400_000)
    _, adev, _, _ = allantools.oadev(noise, rate=rate, data_type="freq", taus=[1.0])
    # The Allan deviation at 1 s is N; 4000 s of data give it to about 1.5 %.
    assert adev[0] == pytest.approx(n, rel=0.06)
    # Control: the noise read as a one-sided density is wrong by the square root of 2.
    assert sample_deviation(n, rate) != pytest.approx(deviation, rel=0.06)
