"""AC coupling and second-order dynamics, against scipy and closed forms."""

import json
import math

import numpy as np
import pytest
from scipy.signal import freqs, lsim, lti, step

from mcsim import InputError, Scenario
from mcsim.scenario.document import parse_document
from mcsim.scenario.sensor_block import AccelerometerErrors
from mcsim.scenario.validation import validate
from mcsim.sensor_terms.channel import ACCELEROMETER, Channel
from mcsim.sensor_terms.mechanisms.high_pass import HighPass
from mcsim.sensor_terms.mechanisms.linear_filter import filtered, log_filter
from mcsim.sensor_terms.mechanisms.low_pass import LowPass
from mcsim.sensor_terms.mechanisms.resonance import Resonance
from mcsim.sensors.error_model import element_errors
from mcsim.sensors.filters import behind_filters
from mcsim.sensors.simulated_log import SimulatedLog
from mcsim.systems import problem_of
from mcsim.vibration.scenario import read_vibration
from mcsim.vibration.simulation import simulate
from tests import conftest, strapdown
from tests.conftest import NO_NOISE
from tests.test_velocity import FOLDER
from tests.test_velocity_sensor import KNOWN

RATE = 1000.0
#: The filters, with their transfer functions.
OMEGA = 2 * math.pi * 40.0
FILTERS = {
    "high-pass": (HighPass(5.0), ([1.0, 0.0], [1.0, 2 * math.pi * 5.0])),
    "low-pass": (LowPass(20.0), ([1.0], [1 / (2 * math.pi * 20.0), 1.0])),
    **{
        f"damping {z}": (Resonance(40.0, z), ([OMEGA**2], [1.0, 2 * z * OMEGA, OMEGA**2]))
        for z in (0.05, 0.7, 1.0, 2.5)
    },
}
EACH = pytest.mark.parametrize("name", FILTERS)


@EACH
def test_filters_are_scipys_of_straight_lines_between_the_samples(name):
    own, system = FILTERS[name]
    signal = np.random.default_rng(9).normal(size=800)
    times = np.arange(len(signal)) / RATE
    _, theirs, _ = lsim(system, signal - signal[0], times)
    theirs = theirs + own.passed(signal[0])
    ours = filtered(signal, (own,), RATE)
    np.testing.assert_allclose(ours, theirs, atol=1e-11)
    # A log is the same however it is cut.
    take = log_filter(((own,),), RATE)
    parts = [take(part) for part in np.array_split(signal[:, None], 7)]
    np.testing.assert_allclose(np.concatenate(parts)[:, 0], ours, atol=1e-12)
    # The control: the filter of another frequency.
    other = [1.1**-k * c for k, c in enumerate(system[0][::-1])][::-1]
    wrong = (other, [1.1 ** (k) * c for k, c in enumerate(system[1])])
    _, far, _ = lsim(wrong, signal - signal[0], times)
    assert np.abs(ours - far - own.passed(signal[0])).max() > 0.01


@EACH
def test_tones_come_with_the_gain_and_the_phase_of_the_transfer_function(name):
    own, system = FILTERS[name]
    for frequency in (3.0, 40.0, 90.0):
        _, response = freqs(*system, worN=[2 * math.pi * frequency])
        t = np.arange(40_000) / 20_000.0
        out = filtered(np.sin(2 * np.pi * frequency * t), (own,), 20_000.0)
        late = t > 1.0
        basis = np.exp(-2j * np.pi * frequency * t[late])
        found = 2j * np.mean(out[late] * basis)
        assert found == pytest.approx(complex(response[0]), abs=2e-3 * abs(response[0]) + 1e-3)


@EACH
def test_means_over_intervals_are_those_of_a_fine_integration(name):
    """With jumps between intervals, as the velocity case has them."""
    own, _ = FILTERS[name]
    rng = np.random.default_rng(4)
    low, high, interval = rng.normal(size=(40, 1)), rng.normal(size=(40, 1)), 0.01

    def of(steps):
        dense = low + np.linspace(0.0, 1.0, steps + 1) * (high - low)
        means = 0.5 * (low + high)[:, 0]
        return own.over_intervals(dense, means, 0.3, steps / interval)

    (few, means), (many, _) = of(8), of(4000)
    np.testing.assert_allclose(few[:, [0, -1]], many[:, [0, -1]], atol=1e-8)
    fine = np.trapezoid(many, dx=1 / 4000, axis=1)
    np.testing.assert_allclose(means, fine, atol=1e-6)
    assert np.abs(few.mean(axis=1) - fine).max() > 1e-3


def test_a_step_behind_an_ac_coupling_decays():
    """exp(-2π f t): after one time constant 1/e is left."""
    corner, rate = 2.0, 50_000.0
    tau = 1 / (2 * math.pi * corner)
    signal = np.append(0.0, np.ones(int(5 * tau * rate)))
    out = filtered(signal, (HighPass(corner),), rate)
    t = np.arange(len(signal)) / rate
    expected = np.exp(-(t - 0.5 / rate) / tau)
    np.testing.assert_allclose(out[1:], expected[1:], atol=1e-4)
    assert abs(out[-1]) < 0.01


def test_a_resonance_has_the_gain_and_the_overshoot_of_its_damping():
    """1/(2 ζ) at the natural frequency, a quarter turn late; exp(-π ζ/√(1 - ζ²)) above a step."""
    for damping in (0.02, 0.1, 0.5):
        own, rate = Resonance(50.0, damping), 50_000.0
        t = np.arange(int(rate * (0.4 / damping / 5 + 0.2))) / rate
        out = filtered(np.sin(2 * np.pi * 50.0 * t), (own,), rate)
        late = t > t[-1] - 0.04 + 0.5 / rate
        found = 2j * np.mean(out[late] * np.exp(-2j * np.pi * 50.0 * t[late]))
        assert abs(found) == pytest.approx(1 / (2 * damping), rel=2e-3)
        assert np.degrees(np.angle(found)) == pytest.approx(-90.0, abs=0.5)
        jump = filtered(np.append(0.0, np.ones(5000)), (own,), rate)
        overshoot = math.exp(-math.pi * damping / math.sqrt(1 - damping**2))
        assert jump.max() == pytest.approx(1 + overshoot, rel=1e-4)
        system = lti([OMEGA**2], [1, 2 * damping * OMEGA, OMEGA**2])
        _, theirs = step(system, T=np.linspace(0.0, 0.05, 5000))
        assert theirs.max() == pytest.approx(jump.max(), rel=1e-4)


def test_a_drive_has_the_filters_of_a_log():
    """Several one after the other; the control leaves one out."""
    own, dense = (Resonance(30.0, 0.3), HighPass(1.0), LowPass(40.0)), 64

    def tone(t, _=0.0):
        return 5.0 + np.cos(2 * np.pi * 20.0 * t)

    count = 600
    driven = behind_filters(lambda t, w: tone(t, w)[None], (own,), 0.0, 100.0, count)
    times = np.arange(count * dense) / (100.0 * dense)
    late = times[::dense] > 3.0
    behind = driven(times[::dense], 0.0)[0]
    for filters, same in ((own, True), (own[:2], False)):
        log = log_filter((filters,), 100.0 * dense)(tone(times)[:, None])[::dense, 0]
        assert (np.abs(log - behind)[late].max() < 5e-3) == same


def log_of(block, signals):
    text = json.dumps(block, ensure_ascii=False)
    own = {ACCELEROMETER: validate(parse_document(text), AccelerometerErrors)}
    channels = [Channel(ACCELEROMETER, axis) for axis in range(signals.shape[1])]
    return SimulatedLog(element_errors(own, RATE, channels, 1.0), 1).measure(signals)


def test_axes_have_filters_of_their_own():
    signals = np.full((3000, 3), 9.8)
    out = log_of({"ac_coupling": ["1 Hz", "0 Hz", "1 Hz"]}, signals)
    np.testing.assert_allclose(out, [[0.0, 9.8, 0.0]] * 3000, atol=1e-12)


# Cases

STRAIGHT = {
    **NO_NOISE,
    "trajectory": {"shape": "straight", "length": "150 m", "speed": "20 m/s", "lead": "1 s",
                   "deceleration": "1.2 m/s²"},
    "sensors.sampling": "none",
    "reconstruction.integration": "trapezoidal",
}  # fmt: skip


def test_a_braking_is_forgotten_behind_an_ac_coupling():
    """What it leaves of a steady a: the velocity stops at a τ, by a τ (1 - exp(-t/τ))."""
    p = conftest.problem({**STRAIGHT, "sensors.accelerometer.ac_coupling": "0.1 Hz"})
    tau, t = 1 / (2 * math.pi * 0.1), 12.0
    place = 1.2 * tau * (t - tau * (1 - math.exp(-t / tau)))
    missed = 0.5 * 1.2 * t**2 - place
    assert p.method_errors()[0] == pytest.approx(missed, rel=0.15)
    wide = conftest.problem(STRAIGHT).method_errors()[0]
    assert abs(wide) < 0.1 < missed


def test_gravity_is_not_seen_behind_an_ac_coupling_in_space():
    """The algorithm takes gravity off what holds none: a free fall; levelling is refused."""
    values = {**STRAIGHT, "sensors.accelerometer.ac_coupling": "0.01 Hz"}
    p = strapdown.problem(values)
    t = p.n_samples * p.interval
    fall = -9.80665 * t**2 / 2
    assert p.method_errors()[p.error_names.index("height")] == pytest.approx(fall, rel=1e-6)
    with pytest.raises(InputError, match="no gravity is left to level by"):
        strapdown.problem({**values, "initial.levelling": {"duration": "1 s"}})
    block = {"noise_density": "100 µg/√Hz", "ac_coupling": "0.1 Hz"}
    with pytest.raises(InputError, match="no gravity is left, from which the initial tilt"):
        Scenario.from_yaml(
            FOLDER / "a1.yaml", {"sensor.accelerometer": block, "sensor.noise": None}
        )


@pytest.mark.parametrize("sampling", ["average", "none"])
def test_a_resonance_in_a_velocity_run_is_scipys(sampling):
    """Of the raw output at 20 kHz, picked or averaged; the control has none."""
    block = {"resonance": {"natural_frequency": "8 Hz", "damping": "30 %"}}
    values = {**KNOWN, "sensor.sampling": sampling}

    def raw(more):
        p = problem_of(Scenario.from_yaml(FOLDER / "a1.yaml", {**values, **more}).base, FOLDER)
        return p.raw[:, 0], float(p.inputs[9])

    fine, rest = raw({"sensor.sampling": "none", "sensor.rate": "20 kHz"})
    omega = 2 * math.pi * 8.0
    system = ([omega**2], [1.0, 0.6 * omega, omega**2])
    _, theirs, _ = lsim(system, fine - rest, np.arange(len(fine)) / 20e3)
    expected = theirs.reshape(-1, 200)
    expected = rest + (expected[:, 0] if sampling == "none" else expected.mean(axis=1))
    ours, _ = raw({"sensor.accelerometer": block})
    np.testing.assert_allclose(ours, expected, atol=1.5e-3 * np.abs(fine - rest).max())
    ideal, _ = raw({})
    assert np.abs(ideal - expected).max() > 0.1 * np.abs(fine - rest).max()


ELEVATOR = """
case: vibration
sensor: {model: MTN-1100, noise_density: 0 µg/√Hz, ac_coupling: CORNER}
rate: 200 Hz
duration: 60 s
excitation:
  shape: elevator
  distance: 120 m
  speed: 10 m/s
  acceleration: 1 m/s²
  jerk: 2 m/s³
  start: 5 s
"""


def test_the_piezo_reference_sees_neither_gravity_nor_a_steady_acceleration(tmp_path):
    """On its one axis; a MEMS sensor in its place reads both."""
    file = tmp_path / "elevator.yaml"

    def read(text):
        file.write_text(text, encoding="utf-8")
        return simulate(read_vibration(file), "log")

    coupled = read(ELEVATOR.replace("CORNER", "0.5 Hz"))
    assert coupled.channels == ("z",)
    t = np.arange(len(coupled.samples)) / 200.0
    seen = coupled.samples[:, 0]
    assert np.abs(seen[t < 5.0]).max() < 1e-9  # no gravity
    assert np.abs(seen).max() > 0.3  # the jerk of the start
    assert "reads no gravity, nor any steady acceleration" in " ".join(coupled.notes)
    other = read(ELEVATOR.replace("MTN-1100", "MPU-9250").replace(", ac_coupling: CORNER", ""))
    dc = other.samples[:, 2]
    steady = (t > 5.0 + 0.5 + 2.0) & (np.abs(dc - 9.80665 - 1.0) < 0.01)
    assert steady.sum() > 50
    assert np.abs(seen[steady]).max() < 0.01
    assert np.abs(dc[t < 5.0] - 9.80665).max() < 0.01
    # The control: without a lower limit the steady acceleration stays.
    without = read(ELEVATOR.replace(", ac_coupling: CORNER", ""))
    assert np.abs(without.samples[steady, 0] - 1.0).max() < 0.01
    assert "write `ac_corner`" in " ".join(without.notes)
    text = ELEVATOR.replace(", ac_coupling: CORNER", "") + "ac_corner: 0.5 Hz\n"
    np.testing.assert_array_equal(read(text).samples, coupled.samples)
