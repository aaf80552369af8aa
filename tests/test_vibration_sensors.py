"""Sensors beside each other: tones, filters, height, response, against closed forms."""

import json
import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import cumulative_simpson
from scipy.optimize import curve_fit
from scipy.signal import butter, coherence, csd, sosfiltfilt, sosfreqz, welch

from mcsim import catalogue
from mcsim.api.sensor_comparison import compare_vibrations
from mcsim.api.vibration import analyse_vibration
from mcsim.cli.main import exit_code
from mcsim.errors import InputError
from mcsim.papers.shipped import shipped_scenarios
from mcsim.scenario.document import parse_document
from mcsim.scenario.validation import validate
from mcsim.vibration.alignment import aligned, in_common
from mcsim.vibration.comparison import compare
from mcsim.vibration.excitations.elevator import elevator_motion
from mcsim.vibration.excitations.excitation import Tone
from mcsim.vibration.filter_words import (
    band,
    half_power_of_high_pass,
    half_power_of_low_pass,
    in_words,
)
from mcsim.vibration.log import Log
from mcsim.vibration.platform import Seen, left_out, scenario_of, sensors_named, simulate_seen
from mcsim.vibration.processing import filters
from mcsim.vibration.scenario import Chain, VibrationScenario, read_vibration
from mcsim.vibration.tone import find_tone
from mcsim.vibration.travel import AT_REST_TWICE, HIGH_PASS, REST_BEFORE, motions

SHIPPED = shipped_scenarios() / "vibration"
ENGINE, ELEVATOR, SWEEP, REST = (
    SHIPPED / f"{name}.yaml" for name in ("engine", "elevator", "sweep", "rest")
)
PLATFORM = ("MTN-1100", "MTI-300", "MPU-9250", "LSM9DS1", "BNO055", "LSM303DLHC")
RATE = 500.0
NO_FILTER = Chain(moving_average=0, high_pass="0 Hz", low_pass="0 Hz")


def seen_of(signal, rate=RATE, name="one", ideal=None):
    log = Log(name, ("z",), np.asarray(signal, float)[:, None], rate)
    return Seen(name, log, log.time, ideal)


def scenario(text):
    return validate(parse_document(text, "case.yaml"), VibrationScenario)


@pytest.fixture(scope="module")
def engine():
    return compare_vibrations([ENGINE], sensors="platform")


@pytest.fixture(scope="module")
def elevator():
    return compare_vibrations([ELEVATOR], sensors="platform")


@pytest.fixture(scope="module")
def sweep():
    return compare_vibrations([SWEEP], sensors="platform")


# One tone


def noisy_tones(count, amplitude=0.05, frequency=26.6667, deviation=0.1, samples=5000):
    rng = np.random.default_rng(1)
    time = np.arange(samples) / RATE
    for _ in range(count):
        phase = rng.uniform(0.0, 2.0 * math.pi)
        signal = amplitude * np.sin(2.0 * math.pi * frequency * time + phase)
        yield signal + rng.normal(0.0, deviation, samples)


@pytest.mark.slow
def test_a_tones_spread_is_what_it_says_and_the_bounds_times_the_windows_cost():
    """Cramér–Rao: u(A)² = 2σ²/N and u(ω)² = 24σ²/(A²N³) per sample; Hann costs 1.22 and 1.53."""
    amplitude, frequency, deviation, n = 0.05, 26.6667, 0.1, 5000
    found = [find_tone(signal, RATE, 26.5, 0.8) for signal in noisy_tones(400)]
    bound_a = math.sqrt(2.0 / n) * deviation
    bound_f = math.sqrt(24.0 / n**3) * deviation / amplitude * RATE / (2.0 * math.pi)
    for name, true, bound, cost in (
        ("amplitude", amplitude, bound_a, 1.22),
        ("frequency", frequency, bound_f, 1.53),
    ):
        values = np.array([getattr(tone, name) for tone in found])
        claimed = np.array([getattr(tone, f"u_{name}") for tone in found])
        # A standard deviation of 400 has 3.5 %; three of these.
        assert values.std() == pytest.approx(cost * bound, rel=0.11)
        assert claimed.mean() == pytest.approx(cost * bound, rel=0.04)
        assert abs(values.mean() - true) < 3.5 * values.std() / math.sqrt(400)
        covered = (np.abs(values - true) < 1.96 * claimed).mean()
        assert 0.91 < covered < 0.985
    assert all(tone.above_noise for tone in found)


def test_a_tone_is_scipys_fit_of_a_sine():
    time = np.arange(5000) / RATE

    def sine(t, a, f, phase, constant):
        return a * np.sin(2.0 * math.pi * f * t + phase) + constant

    for signal in noisy_tones(5, amplitude=0.5):
        tone = find_tone(signal, RATE, 26.5, 0.8)
        fit, spread = curve_fit(sine, time, signal, [0.4, tone.frequency, 0.0, 0.0])
        assert abs(abs(fit[0]) - tone.amplitude) < 3.0 * math.sqrt(spread[0, 0])
        assert abs(fit[1] - tone.frequency) < 4.0 * math.sqrt(spread[1, 1])


def test_another_tone_beside_does_no_harm():
    """A tone ten times as large, 5 Hz away: no window would let 1 % of it in."""
    time = np.arange(5000) / RATE
    other = 10.0 * np.sin(2.0 * math.pi * 31.7 * time)
    tone = find_tone(np.sin(2.0 * math.pi * 26.6667 * time + 1.0) + other, RATE, 26.5, 0.8)
    assert tone.amplitude == pytest.approx(1.0, rel=1e-4)
    assert tone.frequency == pytest.approx(26.6667, abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("samples", [1000, 3000])
def test_noise_alone_passes_for_a_tone_no_more_often_than_said(samples):
    rng = np.random.default_rng(2)
    chances = np.array(
        [find_tone(rng.normal(size=samples), RATE, 26.5, 0.8).chance for _ in range(600)]
    )
    for level in (0.1, 0.02):
        assert (chances < level).mean() < level + 3.0 * math.sqrt(level / 600)
    assert (chances < 0.2).mean() > 0.03  # control: it is not simply one
    assert (chances < 1e-3).sum() <= 3


def test_a_tone_without_noise_or_without_samples():
    clean = find_tone(np.sin(2.0 * math.pi * 25.0 * np.arange(1000) / RATE), RATE, 25.0, 0.5)
    assert clean.above_noise
    assert clean.amplitude == pytest.approx(1.0, rel=1e-6)
    assert math.isnan(find_tone(np.zeros(20), RATE, 25.0, 0.5).frequency)
    silent = find_tone(np.zeros(1000), RATE, 25.0, 0.5)
    assert silent.amplitude == 0.0
    assert not silent.above_noise
    assert math.isnan(find_tone(np.ones(1000), RATE, 251.0, 0.1).frequency)


# Filters as they act


@pytest.mark.parametrize("rate", [171.0, 400.0, 1260.0])
def test_two_passes_lose_half_at_the_cut_off_and_three_decibels_elsewhere(rate):
    """Against scipy's filters; one pass loses 3 dB at the cut-off."""
    for kind, cut_off, where in (
        ("highpass", 2.0, half_power_of_high_pass(2.0, rate)),
        ("lowpass", 50.0, half_power_of_low_pass(50.0, rate)),
    ):
        sections = butter(4, cut_off, kind, fs=rate, output="sos")
        once = np.abs(sosfreqz(sections, [cut_off, where], fs=rate)[1])
        np.testing.assert_allclose(once**2, [0.5, math.sqrt(0.5)], rtol=1e-9)
        assert once[0] == pytest.approx(math.sqrt(0.5))
        time = np.arange(int(40 * rate)) / rate
        passed = sosfiltfilt(sections, np.sin(2.0 * math.pi * where * time))
        middle = slice(len(time) // 4, 3 * len(time) // 4)
        assert passed[middle].std() == pytest.approx(0.5, rel=5e-3)
    # Far below half the rate: fc (√2 - 1)^(∓1/8).
    ratio = (math.sqrt(2.0) - 1.0) ** (-1.0 / 8.0)
    assert half_power_of_high_pass(2.0, 1e5) == pytest.approx(2.0 * ratio, rel=1e-6)
    assert half_power_of_low_pass(50.0, 1e5) == pytest.approx(50.0 / ratio, rel=1e-6)
    assert ratio == pytest.approx(1.1165, abs=1e-4)


def test_the_band_of_the_whole_chain_is_where_it_leaves_three_decibels():
    steps = filters(Chain(), 740.0)
    lower, upper = band(steps)
    np.testing.assert_allclose(steps.gain(np.array([lower, upper])), math.sqrt(0.5), rtol=1e-6)
    inside = np.linspace(lower, upper, 200)[1:-1]
    assert (steps.gain(inside) > math.sqrt(0.5)).all()
    assert upper < half_power_of_low_pass(50.0, 740.0)  # the moving average takes its share
    assert band(filters(NO_FILTER, 100.0)) == (0.0, 50.0)
    assert math.isnan(band(filters(Chain(), 60.0))[0])


def test_filters_are_told_as_they_act():
    said = "\n".join(in_words(filters(Chain(), 740.0)))
    assert "high-pass 2 Hz (Butterworth of order 4, forward and backward): −6 dB at 2 Hz" in said
    assert "−3 dB at 2.233 Hz" in said
    assert "−6 dB at 50 Hz, −3 dB at 44.92 Hz" in said
    assert "nothing left at 74 Hz, late by half a sample (0.676 ms)" in said
    assert "late" not in in_words(filters(Chain(moving_average=9), 740.0))[0]
    assert in_words(filters(NO_FILTER, 740.0)) == ("no filter acts; the mean is removed",)


def test_an_even_moving_average_is_late_by_half_a_sample():
    steps = filters(Chain(moving_average=10, high_pass="0 Hz", low_pass="0 Hz"), RATE)
    time = np.arange(2000) / RATE
    turn = 2.0 * math.pi * 5.0 * time
    late = steps.apply(np.sin(turn)[:, None])[200:1800, 0]  # whole periods
    phase = math.atan2(late @ np.cos(turn[200:1800]), late @ np.sin(turn[200:1800]))
    assert -phase / (2.0 * math.pi * 5.0) * RATE == pytest.approx(0.5, abs=0.01)


# Tones of excitations


def test_tones_of_an_engine_add_up_by_phase_and_those_of_an_elevator_last_while_it_cruises():
    text = """\
case: vibration
sensor: MPU-9250
rate: 740 Hz
duration: 20 s
excitation:
  shape: harmonic
  speed: 600 rpm
  orders:
    - {order: 4, amplitude: 1 m/s²}
    - {order: 2, amplitude: 3 m/s²}
    - {order: 2, amplitude: 4 m/s², phase: 90 °}
"""
    tones = scenario(text).excitation.tones
    assert [(t.order, t.frequency) for t in tones] == [(2.0, 20.0), (4.0, 40.0)]
    assert [t.amplitude for t in tones] == pytest.approx([5.0, 1.0])
    lift = read_vibration(ELEVATOR).excitation
    first, last = lift.tones[0].span
    # v/a + a/j after the start, and as long before the end.
    assert first == pytest.approx(3.0 + 1 / 0.8 + 0.8 / 1.2)
    assert last == pytest.approx(3.0 + 7.0)
    assert [t.amplitude for t in lift.tones] == [0.08, 0.03]
    assert read_vibration(SWEEP).excitation.tones == ()


def test_height_of_an_elevator_is_the_integral_of_its_speed():
    lift = read_vibration(ELEVATOR).excitation
    time = np.arange(20_000) / 1000.0
    speed, height = elevator_motion(lift, time)
    np.testing.assert_allclose(height, cumulative_simpson(speed, dx=1e-3, initial=0), atol=1e-6)
    assert height[-1] == pytest.approx(7.0, abs=1e-12)


# Sensors of the platform


def test_a_reference_that_is_not_there_is_refused_before_anything_is_simulated():
    told = []
    with pytest.raises(InputError, match=r"add it to them: --sensors BNO055,MPU-9250$"):
        compare_vibrations([ENGINE], sensors="BNO055", reference="MPU-9250", tell=told.append)
    assert told == []


def test_what_all_leaves_out_is_said():
    assert [note.partition(":")[0] for note in left_out("all")] == ["LIS33DE"]
    assert left_out("platform,LIS3DH") == ()


def test_groups_of_sensors():
    assert sensors_named("platform") == PLATFORM
    assert sensors_named("BNO055, mtn-1100@2000 Hz") == ("mtn-1100@2000 Hz", "BNO055")
    everything = sensors_named("all")
    assert set(PLATFORM) < set(everything)
    assert "LIS33DE" not in everything  # no source gives its noise
    assert all(catalogue.element(name, "accelerometer") for name in everything)


@pytest.mark.parametrize(
    ("sensor", "rate", "noted"),
    [
        ("BNO055", 171.0, 0),
        ("BNO055@100 Hz", 100.0, 0),
        ("LIS3DH", 5000.0, 0),
        ("MTN-1100", 740.0, 1),
    ],
)
def test_a_sensor_samples_at_its_own_rate(sensor, rate, noted):
    case, name, notes = scenario_of(ENGINE, sensor)
    assert case.rate == rate
    assert name == sensor.partition("@")[0]
    assert len(notes) == noted


def test_a_sensors_numbers_are_its_own(tmp_path):
    """They do not change with the company, and have nothing in common with another's noise."""
    path = tmp_path / "still.yaml"
    path.write_text(
        "{case: vibration, sensor: BNO055, rate: 200 Hz, duration: 40 s, excitation: {shape: "
        "harmonic, speed: 800 rpm, orders: [{order: 1, amplitude: 0 m/s²}]}}",
        encoding="utf-8",
    )
    alone = simulate_seen(path, ["MPU-9250"], lambda _: None)[0]
    both = simulate_seen(path, ["LSM9DS1@740 Hz", "MPU-9250"], lambda _: None)
    np.testing.assert_array_equal(both[1].signal, alone.signal)
    one, other = (np.diff(seen.signal) for seen in both)
    # 1/√N is 0.6 %; with one seed for all it would be nearly one.
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.025


@pytest.mark.slow
def test_at_rest_each_sensor_shows_its_noise_at_its_rate():
    """White noise of a density D at f_s: D √(f_s/2); of the reference as Table 5.1 has it."""
    seen = simulate_seen(REST, sensors_named("MTN-1100,MPU-9250,LSM9DS1"), lambda _: None)
    spreads = {one.name: one.signal.std() for one in seen}
    micro_g = 9.80665e-6
    for name, density, rate in (
        ("MTN-1100", 803.77, 200.0),
        ("MPU-9250", 300.0, 740.0),
        ("LSM9DS1", 222.6298, 1012.0),
    ):
        expected = density * micro_g * math.sqrt(rate / 2.0)
        # 1.1 % for 4000 samples; flicker and walk are less.
        assert spreads[name] == pytest.approx(expected, rel=0.035)
    assert spreads["MTN-1100"] == pytest.approx(0.0788, rel=0.035)


@pytest.mark.slow
def test_low_cost_sensors_agree_in_frequency_and_differ_in_amplitude(engine):
    """Claim S7; amplitudes against the gain of a first-order low-pass, 1/√(1 + (f/f_c)²)."""
    orders = engine.found.orders
    assert list(orders["sensor"].unique()) == list(PLATFORM)
    assert sorted(orders["order"].unique()) == [1.0, 2.0, 4.0, 6.0]
    assert (orders["stands_out"] == "yes").all()
    assert set(orders.loc[orders["dominant"] == "yes", "order"]) == {2.0}
    off = orders["frequency_from_truth [Hz]"] / orders["u_found [Hz]"]
    assert off.abs().max() < 4.0
    assert off.abs().median() > 0.2  # control: the uncertainty is not simply large
    widths = engine.found.table.set_index("sensor")["bandwidth [Hz]"]
    width = orders["sensor"].map(widths)
    gain = 1.0 / np.sqrt(1.0 + (orders["expected [Hz]"] / width) ** 2)
    expected = orders["expected [m/s^2]"] * gain
    off = (orders["amplitude [m/s^2]"] - expected) / orders["u_amplitude [m/s^2]"]
    # The dense signal between samples costs 0.1 % at the cut-off.
    assert off.abs().max() < 4.0
    slow = orders[(orders["sensor"] == "BNO055") & (orders["order"] == 4.0)].iloc[0]
    lost = 100.0 * (1.0 / math.hypot(1.0, 53.333 / 62.5) - 1.0)
    assert slow["amplitude_from_reference [%]"] == pytest.approx(
        lost, abs=4.0 * slow["u_amplitude_from_reference [%]"]
    )
    assert abs(lost) > 20.0


@pytest.mark.slow
def test_the_filtered_amplitude_is_that_of_the_gain(engine):
    """The moving average by the Dirichlet kernel and two passes, each at the sensor's rate."""
    orders = engine.found.orders
    rates = engine.found.table.set_index("sensor")["rate [Hz]"]
    for _, row in orders.iterrows():
        rate, f = rates[row["sensor"]], row["expected [Hz]"]
        expected = abs(math.sin(math.pi * 10 * f / rate) / (10 * math.sin(math.pi * f / rate)))
        for kind, cut_off in (("highpass", 2.0), ("lowpass", 50.0)):
            sections = butter(4, cut_off, kind, fs=rate, output="sos")
            expected *= abs(sosfreqz(sections, [f], fs=rate)[1][0]) ** 2
        assert row["gain"] == pytest.approx(expected, rel=1e-6)
        if expected > 1e-3:
            found = row["amplitude_filtered [m/s^2]"] / row["amplitude [m/s^2]"]
            assert found == pytest.approx(expected, rel=0.03)
    # What this means for a slow sensor: a fifth of the firing order is left.
    slow = orders[(orders["sensor"] == "BNO055") & (orders["order"] == 2.0)].iloc[0]
    assert slow["gain"] == pytest.approx(0.209, abs=0.001)


@pytest.mark.slow
def test_figures_of_the_table_are_those_of_the_logs(engine):
    table = engine.found.table
    assert list(table["sensor"]) == list(PLATFORM)
    for (_, row), sensor in zip(table.iterrows(), engine.found.sensors, strict=True):
        signal = sensor.seen.signal - sensor.seen.signal.mean()
        assert row["rms_raw [m/s^2]"] == pytest.approx(signal.std())
        assert row["peak_raw [m/s^2]"] == np.abs(signal).max()
        assert row["rate [Hz]"] == sensor.seen.log.rate
    # RMS of the truth: √(Σ A²/2).
    true = math.sqrt((0.05**2 + 0.6**2 + 0.3**2 + 0.1**2) / 2.0)
    deviation = 100.0 * (table["rms_raw [m/s^2]"] / true - 1.0)
    np.testing.assert_allclose(table["rms_raw_from_truth [%]"], deviation, atol=0.1)
    assert math.isnan(table["rms_raw_from_reference [%]"][0])


@pytest.mark.slow
def test_filtering_raises_the_ratio_of_the_elevator_for_every_sensor(elevator):
    """Claim S8; the faulty sensor of the source is simulated as its data sheet has it."""
    table = elevator.found.table
    assert (table["snr_filtered [dB]"] > table["snr_raw [dB]"] + 5.0).all()


@pytest.mark.slow
def test_the_hum_is_found_at_its_full_amplitude(elevator):
    orders = elevator.found.orders
    widths = elevator.found.table.set_index("sensor")["bandwidth [Hz]"]
    width = orders["sensor"].map(widths)
    gain = 1.0 / np.sqrt(1.0 + (orders["expected [Hz]"] / width) ** 2)
    off = orders["amplitude [m/s^2]"] - orders["expected [m/s^2]"] * gain
    assert (off.abs() < 4.0 * orders["u_amplitude [m/s^2]"]).all()
    # Control: over the whole log it is the mean of what the speed makes of it, as Hann weighs it.
    seen = elevator.found.sensors[1].seen
    whole = find_tone(seen.signal, seen.log.rate, 14.0, 0.4)
    speed, _ = elevator_motion(read_vibration(ELEVATOR).excitation, seen.time)
    mean = np.average(speed, weights=np.hanning(len(speed)))
    assert whole.amplitude == pytest.approx(0.08 * mean, rel=0.02)
    assert mean < 0.8


# Velocity and height


def test_a_steady_offset_leaves_the_height_and_one_that_comes_late_does_not():
    lift = read_vibration(ELEVATOR).excitation
    travel = lift.travel
    time = np.arange(16_000) / 1000.0
    speed, _ = elevator_motion(lift, time)
    true = np.gradient(speed, time)
    steps = filters(Chain(), 1000.0)
    length = travel.end - travel.start
    for offset in (0.0, 9.81):
        found = motions(seen_of(true + offset, 1000.0), steps, travel)
        assert [m.drift for m in found] == [REST_BEFORE, AT_REST_TWICE, f"{HIGH_PASS} 2 Hz"]
        for motion in found[:2]:
            assert motion.height[-1] == pytest.approx(7.0, abs=2e-4)
            assert motion.velocity.max() == pytest.approx(1.0, abs=1e-4)
    late = true + 0.01 * (time >= travel.start)
    before, twice, _ = motions(seen_of(late, 1000.0), steps, travel)
    assert before.height[-1] - 7.0 == pytest.approx(0.01 * length**2 / 2.0, rel=2e-3)
    assert before.velocity[-1] == pytest.approx(0.01 * length, rel=2e-3)
    assert twice.height[-1] == pytest.approx(7.0, abs=5e-4)


@pytest.mark.slow
def test_white_noise_spreads_the_height_as_said():
    """A walk: q T³/3 + q T⁴/(4 R) for a rest of R; a bridge: q T³/12; q = σ²/f_s."""
    travel = read_vibration(ELEVATOR).excitation.travel
    rng = np.random.default_rng(3)
    rate, deviation = 100.0, 0.05
    steps = filters(Chain(), rate)
    time = np.arange(1600) / rate
    length, q = travel.end - travel.start, deviation**2 / rate
    errors, claimed = [], []
    for _ in range(300):
        before, twice, _ = motions(
            seen_of(rng.normal(0.0, deviation, len(time)), rate), steps, travel
        )
        errors.append([before.height[-1], twice.height[-1]])
        claimed.append([before.u_height, twice.u_height])
    expected = np.sqrt(q * np.array([length**3 / 3 + length**4 / (4 * 3.0), length**3 / 12]))
    # 4.1 % for 300; three of these.
    np.testing.assert_allclose(np.std(errors, axis=0), expected, rtol=0.125)
    np.testing.assert_allclose(np.mean(claimed, axis=0), expected, rtol=0.03)
    covered = (np.abs(errors) < 1.96 * np.array(claimed)).mean(axis=0)
    assert ((covered > 0.91) & (covered < 0.985)).all()
    assert expected[0] > 3.0 * expected[1]


def test_the_high_pass_takes_the_run_and_leaves_the_hum():
    """Left of the run: nearly nothing; of the hum A G²/ω in velocity, the chain's gain G twice."""
    case = read_vibration(ELEVATOR)
    time = np.arange(16_000) / 1000.0
    lift = case.excitation
    speed, _ = elevator_motion(lift, time)
    run = np.gradient(speed, time)
    chain = Chain(moving_average=0)
    steps = filters(chain, 1000.0)
    only_run = motions(seen_of(run, 1000.0), steps, lift.travel)[-1]
    assert np.abs(only_run.velocity).max() < 1e-3  # of 1 m/s
    hum = 0.08 * speed * np.sin(2.0 * math.pi * 14.0 * time)
    left = motions(seen_of(run + hum, 1000.0), steps, lift.travel)[-1]
    cruise = (left.time > 6.0) & (left.time < 9.0)
    sections = butter(4, 2.0, "highpass", fs=1000.0, output="sos")
    twice = float(abs(sosfreqz(sections, [14.0], fs=1000.0)[1][0])) ** 2
    gain = float(steps.gain(np.array([14.0]))[0]) * twice
    velocity = left.velocity[cruise] - only_run.velocity[cruise]
    expected = 0.08 * gain / (2.0 * math.pi * 14.0)
    assert velocity.std() * math.sqrt(2) == pytest.approx(expected, rel=0.01)


def test_a_run_that_is_cut_short_has_no_height():
    travel = read_vibration(ELEVATOR).excitation.travel
    steps = filters(Chain(), RATE)
    assert motions(seen_of(np.zeros(5000)), steps, travel) == ()
    assert len(motions(seen_of(np.zeros(7000)), steps, travel)) == 3


@pytest.mark.slow
def test_the_table_of_the_elevator(elevator):
    table = elevator.found.travel
    assert len(table) == 3 * len(PLATFORM)
    constant = table[table["sensor"] != "MTN-1100"]  # which passes no constant acceleration
    twice = constant[constant["drift_removed_by"] == AT_REST_TWICE]
    assert (twice["height_error [m]"].abs() < 0.06).all()
    assert (twice["top_speed_error [m/s]"].abs() < 0.03).all()
    passed = table[table["drift_removed_by"] == f"{HIGH_PASS} 2 Hz"]
    assert (passed["height [m]"].abs() < 1e-3).all()


# Sweeps


@pytest.mark.slow
def test_the_response_is_that_of_the_low_pass(sweep):
    table = sweep.found.response
    table = table[table["sensor"] != "MTN-1100"]  # AC-coupled: it has a lower limit as well
    widths = sweep.found.table.set_index("sensor")["bandwidth [Hz]"]
    ratio = table["frequency [Hz]"] / table["sensor"].map(widths)
    off = (table["gain"] - 1.0 / np.hypot(1.0, ratio)) / table["u_gain"]
    assert off.abs().max() < 4.5  # of two hundred
    assert (off.abs() < 1.96).mean() > 0.9
    phase = table["phase [deg]"] + np.degrees(np.arctan(ratio))
    u_phase = np.degrees(table["u_gain"] / table["gain"])
    assert ((phase / u_phase).abs() < 1.96).mean() > 0.9
    rates = sweep.found.table.set_index("sensor")["rate [Hz]"]
    assert (table["frequency [Hz]"] < table["sensor"].map(rates) / 2.0).all()
    found = sweep.found.table.set_index("sensor")["half_power_found [Hz]"]
    assert found["BNO055"] == pytest.approx(62.5, rel=0.02)
    assert found.drop("BNO055").isna().all()  # beyond the sweep


@pytest.mark.slow
def test_the_response_is_scipys_cross_spectrum(sweep):
    """H1 = S_xy / S_xx of Welch, over bands of a sixth of an octave."""
    sensor = sweep.found.sensors[PLATFORM.index("MPU-9250")]
    rate, x, y = sensor.seen.log.rate, sensor.ideal, sensor.raw
    options = {"fs": rate, "nperseg": 2048}
    frequency, cross = csd(x, y, **options)
    power, alike = welch(x, **options)[1], coherence(x, y, **options)[1]
    table = sweep.found.response
    own = table[table["sensor"] == "MPU-9250"]
    for _, row in own[own["frequency [Hz]"].between(10.0, 150.0)].iterrows():
        near = np.abs(np.log2(frequency[1:] / row["frequency [Hz]"])) < 1.0 / 12.0
        theirs = np.abs(cross[1:][near].sum() / power[1:][near].sum())
        assert row["gain"] == pytest.approx(theirs, abs=4.0 * row["u_gain"] + 0.01)
        assert alike[1:][near].min() > 0.9


# Measured logs


def written(folder, found, names=None):
    """Logs of a comparison as files, by the names of their sensors."""
    files = {}
    for sensor in found.found.sensors:
        seen = sensor.seen
        files[seen.name] = folder / f"{(names or {}).get(seen.name, seen.name)}.csv"
        columns = {"time [s]": seen.time, "ax [m/s²]": 0.0 * seen.time, "az [m/s²]": seen.signal}
        columns["ax [m/s²]"] = np.sin(seen.time)
        pd.DataFrame(columns).to_csv(files[seen.name], index=False, float_format="%.9g")
    return files


@pytest.fixture(scope="module")
def three(tmp_path_factory):
    found = compare_vibrations([ENGINE], sensors="MTN-1100,MPU-9250,BNO055")
    return found, written(tmp_path_factory.mktemp("logs"), found)


@pytest.mark.slow
def test_files_give_what_the_simulated_logs_gave(three):
    simulated, files = three
    for given in ([ENGINE, *files.values()], [ENGINE, files["MPU-9250"], files["BNO055"]]):
        measured = compare_vibrations(
            given, reference=str(files["MTN-1100"]), read={"channels": ("az",)}
        )
        a, b = (
            f.found.orders.set_index(["sensor", "tone"]).sort_index() for f in (simulated, measured)
        )
        for column in a.select_dtypes("number"):
            # The floor beside a tone may hold a bin more or less, as rates are rounded.
            rtol = 0.02 if column.startswith(("u_", "above")) else 1e-4
            np.testing.assert_allclose(b[column], a[column], rtol, 1e-6, err_msg=column)
        assert measured.found.sensors[measured.found.reference].seen.name == "MTN-1100"


@pytest.mark.slow
def test_logs_alone_are_held_against_the_reference(three):
    _, files = three
    found = compare_vibrations(
        list(files.values()),
        reference="MTN-1100",
        seek={"rpm": 800.0, "tones": (80.0, 97.0)},
        read={"channels": ("az", "az2")},
    ).found
    orders = found.orders
    assert list(orders["tone"].unique()) == ["order 1", "order 2", "order 4", "80 Hz", "97 Hz"]
    assert "frequency_from_reference [Hz]" in orders
    assert orders["amplitude_from_truth [%]"].isna().all()
    silent = orders[orders["tone"] == "97 Hz"]
    assert (silent["stands_out"] == "no").all()
    assert silent["found [Hz]"].isna().all()
    loud = orders[orders["tone"] != "97 Hz"]
    assert (loud["stands_out"] == "yes").all()
    beyond = compare_vibrations(
        [files["BNO055"]], seek={"tones": (90.0,)}, read={"channels": ("az",)}
    )
    assert beyond.found.orders["amplitude [m/s^2]"].isna().all()  # above half of 171 Hz


def test_without_any_word_the_strongest_tone_is_compared():
    time = np.arange(5000) / RATE
    signal = np.sin(2.0 * math.pi * 17.3 * time) + 0.1 * np.sin(2.0 * math.pi * 30.0 * time)
    found = compare([seen_of(signal)], Chain(moving_average=0))
    assert found.orders["found [Hz]"][0] == pytest.approx(17.3, abs=1e-4)
    assert found.orders["tone"].tolist() == ["strongest"]


@pytest.mark.parametrize("shift", [0.0, 1.2345, -0.777])
def test_clocks_are_brought_together(shift):
    """A knock and a rattle, seen by two sensors of different rates whose clocks differ."""

    def knock(t):
        return np.exp(-((t - 9.0) ** 2) * 4.0) * np.sin(2 * math.pi * 7.3 * t + np.sin(2.0 * t))

    rng = np.random.default_rng(4)
    first, second = np.arange(9000) / 500.0, np.arange(3000) / 171.0
    base = seen_of(knock(first) + rng.normal(0.0, 0.05, len(first)))
    other = seen_of(knock(second - shift) + rng.normal(0.0, 0.05, len(second)), 171.0, "other")
    moved = aligned([base, other], base, Chain())
    assert moved[0].lag == 0.0
    assert moved[1].lag == pytest.approx(shift, abs=4e-4)
    # Control: samples of 171 Hz alone would be good to 2.9 ms.
    both = in_common(moved)
    assert abs(both[0].time[0] - both[1].time[0]) < 1.0 / 171.0
    assert abs(both[0].time[-1] - both[1].time[-1]) < 1.0 / 171.0
    silent = seen_of(rng.normal(0.0, 1.0, 3000), 171.0, "silent")
    with pytest.raises(InputError, match=r"--align: silent correlates with one by 0\.\d+ at most"):
        aligned([base, silent], base, Chain())


@pytest.mark.slow
def test_a_late_log_of_a_sweep_needs_its_clock_put_right(tmp_path):
    simulated = compare_vibrations([SWEEP], sensors="MPU-9250")
    seen = simulated.found.sensors[0].seen
    late = replace(seen, log=replace(seen.log, samples=seen.log.samples[148:]))  # 0.2 s
    path = tmp_path / "late.csv"
    columns = {"time [s]": seen.time[:-148], "az [m/s²]": late.signal}
    pd.DataFrame(columns).to_csv(path, index=False)
    off, right = (compare_vibrations([SWEEP, path], align=a).found for a in (False, True))
    assert right.table["lag [s]"][0] == pytest.approx(-0.2, abs=2e-3)
    inner = right.response["frequency [Hz]"].between(5.0, 100.0)
    assert (right.response["gain"][inner] > 0.95).all()
    assert off.response["gain"].min() < 0.5


# Commands


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["{engine}", "{elevator}"], "elevator.yaml: a second scenario"),
        (["{engine}", "--sensors", "MPU-9250,mpu-9250"], "MPU-9250 stands there twice"),
        (["{engine}", "--sensors", "MPU-9250,"], "a name is missing"),
        (["{engine}", "--sensors", "MPU-92"], '--sensors MPU-92: sensor: no sensor "MPU-92"'),
        (["{engine}", "--sensors", "BNO055@171"], '--sensors BNO055@171: rate: "171" has no unit'),
        (["{engine}", "--sensors", "BNO055", "--sensor", "BNO055"], "one sensor alone"),
        (["{engine}", "--sensors", "BNO055", "--reference", "MPU"], 'reference "MPU": neither'),
        (
            ["{engine}", "--sensors", "BNO055@100 Hz", "--reference", "mpu-9250"],
            "add it to them: --sensors BNO055@100 Hz,MPU-9250",
        ),
        (["{engine}", "--align"], "nothing to compare"),
        (["{engine}", "--sensors", "BNO055", "--start", "1"], "belong to a log"),
        (["{log}", "{log2}", "--channel", "az", "--cylinders", "6"], "needs the engine's speed"),
        (["{log}", "{log2}", "--channel", "az", "--moving-average", "600"], "longer than the log"),
        (["{log}", "--sensors", "all"], "--sensors belongs to a scenario"),
        (["{log}", "{log2}"], "log: has the channels ax, az; name the one to compare"),
        (["{log}", "{log2}", "--channel", "ay"], 'no column "ay"'),
        (["{log}", "{log2}", "--channel", "az", "--tone", "14"], '"14" has no unit'),
        (["{log}", "{log2}", "--channel", "az", "--tone", "0 Hz"], "must be above zero"),
        (["{log}", "{deep}/log.csv", "--channel", "az"], "log: two sensors of that name"),
    ],
)
def test_comparisons_that_make_no_sense_are_refused(tmp_path, capsys, arguments, message):
    time = np.arange(500) / 100.0
    table = pd.DataFrame({"time [s]": time, "ax [m/s²]": time, "az [m/s²]": np.sin(40 * time)})
    (tmp_path / "deep").mkdir()
    for name in ("log", "log2", "deep/log"):
        table.to_csv(tmp_path / f"{name}.csv", index=False)
    places = {"engine": ENGINE, "elevator": ELEVATOR, "deep": tmp_path / "deep"}
    places |= {name: tmp_path / f"{name}.csv" for name in ("log", "log2")}
    given = [argument.format(**places) for argument in arguments]
    assert exit_code(["vibration", *given, "--output", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_the_command_writes_tables_and_pictures(tmp_path, capsys):
    sensors = "MTN-1100@100 Hz,BNO055"
    arguments = ["vibration", str(ELEVATOR), "--sensors", sensors, "--low-pass", "40 Hz"]
    assert exit_code([*arguments, "--output", str(tmp_path)]) == 0
    told = capsys.readouterr()
    folder = tmp_path / "elevator-sensors"
    names = {file.name for file in folder.iterdir()}
    assert {"table.csv", "orders.csv", "travel.csv", "figure.png", "travel.png"} <= names
    assert {"log-MTN-1100.csv", "log-BNO055.csv", "provenance.json"} <= names
    assert "hum 14 Hz*" in told.out
    assert "drift removed by" in told.out
    assert "forward and backward (−6 dB there)" in told.err
    origin = json.loads((folder / "provenance.json").read_text(encoding="utf-8"))
    assert "−6 dB at 40 Hz" in " ".join(origin["filters"]["BNO055"])
    assert origin["options"]["sensors"] == sensors
    shown = pd.read_csv(folder / "travel.csv")
    assert set(shown["drift_removed_by"]) == {REST_BEFORE, AT_REST_TWICE, "high-pass 2 Hz"}
    # The same folder for another excitation: nothing of this one is left behind.
    other = tmp_path / "elevator.yaml"
    other.write_text(ENGINE.read_text(encoding="utf-8"), encoding="utf-8")
    again = ["vibration", str(other), "--sensors", "BNO055", "--quiet"]
    assert exit_code([*again, "--output", str(tmp_path)]) == 0
    left = {file.name for file in folder.iterdir()}
    assert not {"travel.csv", "travel.png", "log-MTN-1100.csv"} & left


@pytest.mark.slow
def test_panels_of_sensors_share_their_axes(engine, elevator, sweep):
    from mcsim.figures.vibration_response import draw_response
    from mcsim.figures.vibration_sensors import draw_sensors
    from mcsim.figures.vibration_travel import draw_travel

    figure = draw_sensors(engine.found, "engine")
    assert len(figure.axes) == 2 * len(PLATFORM)
    for column in (figure.axes[0::2], figure.axes[1::2]):
        assert len({axes.get_xlim() for axes in column}) == 1
        assert len({axes.get_ylim() for axes in column}) == 1
    words = [axes.get_title(loc="left") for axes in figure.axes]
    assert words[0] == "MTN-1100 (reference): 740 Hz, bandwidth 10,000 Hz"
    assert words[9] == "filters −3 dB at 2.26 and 7.61 Hz"
    assert "(−6 dB there)" in figure.legends[0].get_title().get_text()
    panels = draw_travel(elevator.found, "elevator").axes
    assert len({axes.get_ylim() for axes in panels[:3]}) == 1
    assert panels[6].get_ylim() == panels[7].get_ylim() != panels[8].get_ylim()
    gain, phase = draw_response(sweep.found, "sweep").axes
    assert gain.get_xlim() == phase.get_xlim()


@pytest.mark.slow
def test_the_table_of_one_log_holds_every_order_of_its_scenario():
    """Beside the crankshaft's, the firing order and its double."""
    orders = analyse_vibration(ENGINE).analysis.orders
    z = orders[orders["channel"] == "z"]
    assert z["order"].tolist() == [1.0, 2.0, 4.0, 6.0]
    expected = np.array([0.05, 0.6, 0.3, 0.1]) / np.hypot(1.0, z["expected [Hz]"] / 460.0)
    # Flat-top windows let in twice the noise of a Hann window.
    np.testing.assert_allclose(z["amplitude_raw [m/s^2]"], expected, atol=0.005)
    assert (z["above_noise [dB]"] > 20.0).all()
    hum = analyse_vibration(ELEVATOR).analysis.orders
    hum = hum[hum["channel"] == "z"]
    assert hum["order"].isna().all()
    np.testing.assert_allclose(hum["amplitude_raw [m/s^2]"], [0.08, 0.03], atol=0.005)


def test_an_excitation_from_outside_without_tones_is_compared():
    case = read_vibration(ENGINE)
    bare = type("Bare", (type(case.excitation).__mro__[1],), {"__annotations__": {}})()
    signal = np.sin(2.0 * math.pi * 20.0 * np.arange(2000) / RATE)
    found = compare([seen_of(signal, ideal=signal)], NO_FILTER, excitation=bare, duration=4.0)
    assert found.orders is None
    assert found.travel is None
    assert found.response is None
    assert found.table["rms_raw_from_truth [%]"][0] == 0.0
    tones = [Tone("own", 20.0, 1.0)]
    found = compare([seen_of(signal, ideal=signal)], NO_FILTER, tones=tones, excitation=bare)
    assert found.orders["amplitude_from_truth [%]"][0] == pytest.approx(0.0, abs=1e-3)
