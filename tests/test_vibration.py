"""Vibration: excitations, the chain of filters, spectra and figures, against closed forms."""

import json
import math
import re
from pathlib import Path
from typing import Literal

import jsonschema
import numpy as np
import pandas as pd
import pytest
from scipy.integrate import cumulative_simpson
from scipy.signal import butter, chirp, sosfiltfilt

from mcsim.cli.main import exit_code
from mcsim.errors import InputError
from mcsim.papers.sensor_deviations import remarks, sensor_table
from mcsim.papers.sensor_logs import printed
from mcsim.papers.shipped import shipped_scenarios
from mcsim.scenario.document import parse_document
from mcsim.scenario.fields import Acceleration
from mcsim.scenario.validation import validate
from mcsim.scenario_file import Scenario
from mcsim.vibration.analysis import Engine, analyse
from mcsim.vibration.excitations import (
    EXCITATIONS,
    Excitation,
    ExcitationBlock,
    acceleration,
)
from mcsim.vibration.excitations.elevator import elevator_phases, elevator_speed
from mcsim.vibration.log import Log, read_vibration_log
from mcsim.vibration.processing import filters
from mcsim.vibration.scenario import (
    Chain,
    VibrationScenario,
    read_vibration,
    vibration_schema,
)
from mcsim.vibration.simulation import AXES, errors_of, oversampling, simulate
from mcsim.vibration.spectra import (
    amplitude_spectrum,
    signal_to_noise,
    spectrogram,
    tone_amplitude,
    welch_spectrum,
)

RATE = 1000.0
TIME = np.arange(20_000) / RATE
ENGINE = """\
case: vibration
sensor: {noise_density: 1 µg/√Hz}
rate: 1000 Hz
duration: 20 s
excitation: {shape: harmonic, speed: 800 rpm, orders: [{order: 2, amplitude: 0.5 m/s²}]}
"""
ELEVATOR = "{shape: elevator, distance: 7 m, speed: 1 m/s, acceleration: 0.8 m/s², jerk: 1.2 m/s³}"


def scenario(text):
    return validate(parse_document(text, "case.yaml"), VibrationScenario)


def with_excitation(excitation):
    old = ENGINE.splitlines()[-1]
    return scenario(ENGINE.replace(old, f"excitation: {excitation}")).excitation


def tone(frequency, amplitude=1.0, phase=0.3):
    return amplitude * np.sin(2 * np.pi * frequency * TIME + phase)


def log_of(*signals):
    return Log("log", tuple("xyz"[: len(signals)]), np.stack(signals, axis=1), RATE)


# Excitations


def test_orders_are_multiples_of_the_crankshafts_frequency():
    """800 rpm: 13.33 Hz; two firings per turn of four cylinders, 26.67 Hz, then 53.33 Hz."""
    engine = Engine(800 / 60)
    assert engine.orders == (1.0, 2.0, 4.0)
    assert [round(engine.frequency(o), 2) for o in engine.orders] == [13.33, 26.67, 53.33]
    assert Engine(50.0, 6).orders == (1.0, 3.0, 6.0)
    excitation = with_excitation(
        "{shape: harmonic, speed: 600 rpm, orders: [{order: 2, amplitude: 1 m/s², phase: 90 °}]}"
    )
    found = acceleration(excitation, TIME, 20.0)
    np.testing.assert_allclose(found, np.cos(2 * np.pi * 20.0 * TIME), atol=1e-9)


@pytest.mark.parametrize(("scale", "method"), [("linear", "linear"), ("log", "logarithmic")])
@pytest.mark.parametrize(("first", "last"), [(2.0, 200.0), (150.0, 10.0)])
def test_sweeps_are_scipys_chirps(scale, method, first, last):
    excitation = with_excitation(
        f"{{shape: sweep, first: {first} Hz, last: {last} Hz, amplitude: 2 m/s², scale: {scale}}}"
    )
    found = acceleration(excitation, TIME, 20.0)
    theirs = 2 * chirp(TIME, first, 20.0, last, method, phi=-90)
    np.testing.assert_allclose(found, theirs, atol=1e-6)


EXCITED = {
    "harmonic": ENGINE.splitlines()[-1].removeprefix("excitation: "),
    "sweep": "{shape: sweep, first: 1 Hz, last: 10 Hz, amplitude: 1 m/s²}",
    "elevator": ELEVATOR.replace("}", ", hum: [{frequency: 9 Hz, amplitude: 0.1 m/s²}]}"),
    "rest": "{shape: rest}",
}


def test_every_excitation_has_an_example():
    assert list(EXCITED) == list(EXCITATIONS)


@pytest.mark.parametrize("name", EXCITED)
def test_an_excitation_reads_back_from_what_it_writes(name):
    excitation = with_excitation(EXCITED[name])
    assert type(excitation) is EXCITATIONS[name].block
    assert with_excitation(json.dumps(excitation.model_dump(mode="json"))) == excitation


@pytest.mark.parametrize("name", EXCITED)
def test_an_unknown_key_of_an_excitation_is_told_with_its_own(name):
    with pytest.raises(InputError) as told:
        with_excitation(EXCITED[name].replace("{shape", "{colour: red, shape"))
    known = ", ".join(EXCITATIONS[name].block.model_fields)
    assert str(told.value) == (
        f'case.yaml:5: excitation.colour: unknown key "colour" (known here: {known})'
    )


class Knock(ExcitationBlock):
    """One that a user adds."""

    shape: Literal["knock"]
    amplitude: Acceleration


def test_an_excitation_from_outside_is_simulated():
    EXCITATIONS.add(Excitation("knock", Knock, lambda block, t, _: block.amplitude * (t < 0.1)))
    try:
        text = ENGINE.replace(EXCITED["harmonic"], "{shape: knock, amplitude: 3 m/s²}")
        log = simulate(scenario(text), "knock")
        jsonschema.Draft7Validator(vibration_schema()).validate(parse_document(text).tree)
    finally:
        EXCITATIONS.remove("knock")
    assert log.samples[:90, 2].mean() - log.samples[110:, 2].mean() == pytest.approx(3.0, abs=1e-3)


def test_elevator_reaches_speed_and_floor():
    """The integral of the acceleration is the speed, its integral the distance."""
    excitation = with_excitation(ELEVATOR)
    found = acceleration(excitation, TIME, 20.0)
    speed = cumulative_simpson(found, dx=1 / RATE, initial=0.0)
    np.testing.assert_allclose(speed, elevator_speed(excitation, TIME), atol=1e-5)
    assert speed.max() == pytest.approx(1.0, abs=1e-5)
    assert cumulative_simpson(speed, dx=1 / RATE)[-1] == pytest.approx(7.0, abs=1e-4)
    assert np.abs(found).max() == pytest.approx(0.8)
    assert np.abs(np.diff(found)).max() * RATE == pytest.approx(1.2, rel=1e-6)
    times, _ = elevator_phases(excitation)
    # d/v + v/a + a/j from start to stop.
    assert times[-1] - times[0] == pytest.approx(7.0 + 1 / 0.8 + 0.8 / 1.2)


def test_hum_grows_with_the_elevators_speed():
    with_hum = ELEVATOR[:-1] + ", hum: [{frequency: 14 Hz, amplitude: 0.1 m/s²}]}"
    plain, humming = (
        acceleration(with_excitation(text), TIME, 20.0) for text in (ELEVATOR, with_hum)
    )
    hum = humming - plain
    assert not hum[TIME < 2.0].any()
    cruising = (TIME > 4.5) & (TIME < 8.5)
    assert hum[cruising].std() == pytest.approx(0.1 / math.sqrt(2), rel=0.01)


# Scenarios


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("speed: 800 rpm", "speed: 800", 'case.yaml:5: excitation.speed: "800" has no unit'),
        ("shape: harmonic", "shape: harmonics", 'did you mean "harmonic"'),
        ("order: 2,", "", "excitation.orders.0.order: is missing"),
        ("{noise_density: 1 µg/√Hz}", "MPU9250", 'did you mean "MPU-9250"'),
        ("{noise_density: 1 µg/√Hz}", "L3G4200D", "has no accelerometer"),
        ("duration: 20 s", "duration: 1e6 s", "between 64 and 20,000,000"),
        ("duration: 20 s", "durations: 20 s", 'did you mean "duration"'),
    ],
)
def test_bad_scenarios_are_explained(old, new, message):
    assert old in ENGINE
    with pytest.raises(InputError) as error:
        scenario(ENGINE.replace(old, new))
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("distance: 7 m", "distance: 1 m", "at least 1.92 m are needed"),
        ("jerk: 1.2 m/s³", "jerk: 0.1 m/s³", "the largest is 0.316 m/s²"),
    ],
)
def test_elevators_that_cannot_run_are_refused(old, new, message):
    with pytest.raises(InputError, match=message):
        with_excitation(ELEVATOR.replace(old, new))
    with pytest.raises(InputError, match="`first` and `last` are equal"):
        with_excitation("{shape: sweep, first: 2 Hz, last: 2 Hz, amplitude: 1 m/s²}")


def test_simulated_logs_see_gravity_and_the_low_pass():
    log = simulate(scenario(ENGINE), "log")
    assert log.samples.shape == (20_000, 3)
    assert log.samples[:, 2].mean() == pytest.approx(9.80665, abs=1e-3)
    text = ENGINE.replace("1 µg/√Hz}", "1 µg/√Hz, bandwidth: 26.667 Hz}")
    weaker = simulate(scenario(text + "gravity: false\nalong: x\n"), "log")
    assert weaker.samples[2000:, 0].std() == pytest.approx(0.25, rel=2e-3)
    assert np.abs(weaker.samples[:, 2]).max() < 1e-3


def test_simulation_is_seeded_and_tells_its_progress():
    told = []
    first = simulate(scenario(ENGINE), "log", told.append)
    np.testing.assert_array_equal(first.samples, simulate(scenario(ENGINE), "log").samples)
    other = simulate(scenario(ENGINE + "seed: 2\n"), "log")
    assert (first.samples != other.samples).any()
    assert told == [1.0]


def test_dense_signals_suit_the_low_pass():
    assert oversampling(errors_of(scenario(ENGINE), 3)) == 1
    limited = ENGINE.replace("1 µg/√Hz}", "1 µg/√Hz, bandwidth: 50 Hz}")
    assert oversampling(errors_of(scenario(limited), 3)) == 4


# The chain


def test_chain_leaves_the_middle_of_its_band_alone():
    chain = Chain(moving_average=0)
    for frequency, least, most in ((0.5, 0.0, 0.01), (10.0, 0.98, 1.01), (200.0, 0.0, 0.01)):
        out = filters(chain, RATE).apply(tone(frequency)[:, None])[3000:-3000, 0]
        gain = out.std() / tone(frequency)[3000:-3000].std()
        assert least <= gain <= most
        assert filters(chain, RATE).gain(np.array([frequency]))[0] == pytest.approx(gain, abs=5e-3)


def test_chain_loses_half_at_its_cut_offs():
    """Forward and backward: -3 dB twice."""
    for frequency in (2.0, 50.0):
        out = filters(Chain(moving_average=0), RATE).apply(tone(frequency)[:, None])
        assert out[4000:-4000].std() == pytest.approx(0.5 / math.sqrt(2), rel=5e-3)


def test_moving_average_weakens_by_the_dirichlet_kernel():
    chain = Chain(moving_average=10, high_pass="0 Hz", low_pass="0 Hz")
    frequency = 26.67
    out = filters(chain, 400.0)
    expected = math.sin(math.pi * 10 * frequency / 400) / (10 * math.sin(math.pi * frequency / 400))
    assert out.gain(np.array([frequency]))[0] == pytest.approx(expected)
    assert expected == pytest.approx(0.416, abs=1e-3)
    signal = np.sin(2 * np.pi * frequency * np.arange(8000) / 400)
    assert out.apply(signal[:, None]).std() == pytest.approx(expected / math.sqrt(2), rel=3e-3)
    assert "first zero at 40 Hz" in filters(Chain(), 400.0).notes[0]


def test_chain_is_scipys_butterworth_away_from_the_ends():
    noise = np.random.default_rng(1).normal(size=(6000, 1))
    ours = filters(Chain(moving_average=0, low_pass="0 Hz"), RATE).apply(noise)
    theirs = sosfiltfilt(butter(4, 2.0, "highpass", fs=RATE, output="sos"), noise, axis=0)
    np.testing.assert_allclose(ours[2500:-2500], theirs[2500:-2500], atol=1e-3)


def test_ends_of_a_log_do_not_ring():
    """The peak of a filtered tone is its amplitude; an odd extension would double it."""
    for phase in (0.0, 0.7, math.pi / 2):
        out = filters(Chain(moving_average=0), RATE).apply(tone(26.67, 1.0, phase)[:, None])
        assert np.abs(out).max() < 1.15


def test_integrals_of_a_tone():
    """Velocity A / w, displacement A / w²."""
    found = analyse(log_of(tone(20.0)), Chain(moving_average=0)).table.iloc[1]
    omega = 2 * np.pi * 20.0
    gain = float(filters(Chain(moving_average=0), RATE).gain(np.array([20.0]))[0])
    assert found["velocity rms [mm/s]"] == pytest.approx(
        1e3 * gain / omega / math.sqrt(2), rel=0.01
    )
    assert found["displacement rms [mm]"] == pytest.approx(
        1e3 * gain / omega**2 / math.sqrt(2), rel=0.02
    )


def test_steps_that_a_rate_leaves_no_room_for_are_named():
    notes = filters(Chain(), 60.0).notes
    assert any("no low-pass" in note for note in notes)
    assert any("no high-pass" in note for note in filters(Chain(), 4.0).notes)


# Spectra and figures


def test_figures_of_a_known_signal():
    signal = 3.0 + tone(20.0, 2.0)
    raw = analyse(log_of(signal), Chain()).table.iloc[0]
    assert raw["mean [m/s^2]"] == pytest.approx(3.0, abs=1e-3)
    assert raw["peak [m/s^2]"] == pytest.approx(2.0, rel=1e-3)
    assert raw["peak_to_peak [m/s^2]"] == pytest.approx(4.0, rel=1e-3)
    assert raw["rms [m/s^2]"] == pytest.approx(math.sqrt(2), rel=1e-3)


def test_amplitude_of_a_tone_on_a_bin_is_exact_and_between_bins_by_flat_top():
    on_bin, between = tone(25.0, 0.7)[:, None], tone(26.66666, 0.7)[:, None]
    assert amplitude_spectrum(on_bin, RATE).levels.max() == pytest.approx(0.7, rel=1e-6)
    found, frequency = tone_amplitude(between[:, 0], RATE, 26.5, 0.5)
    assert found == pytest.approx(0.7, rel=2e-3)
    assert frequency == pytest.approx(26.66666, abs=2e-3)
    # Control: a Hann window may lose up to 15 % between two bins.
    half = tone(25.025, 0.7)[:, None]
    assert amplitude_spectrum(half, RATE).levels.max() < 0.62


def test_long_spectra_keep_their_peaks_in_the_table():
    time = np.arange(100_000) / RATE
    signal = np.sin(2 * np.pi * 123.45 * time)[:, None]
    table = analyse(Log("long", ("x",), signal, RATE), Chain()).spectrum
    assert len(table) <= 20_000
    peak = table.loc[table["amplitude_raw [m/s^2]"].idxmax()]
    assert peak["frequency [Hz]"] == pytest.approx(123.45)
    assert peak["amplitude_raw [m/s^2]"] == pytest.approx(1.0, rel=1e-6)


def test_welch_density_of_white_noise_is_one_sided():
    density = 1e-3
    noise = np.random.default_rng(2).normal(0.0, density * math.sqrt(RATE / 2), (200_000, 1))
    spectrum = welch_spectrum(noise, RATE)
    assert np.sqrt(spectrum.levels[5:-5].mean()) == pytest.approx(density, rel=0.01)
    total = spectrum.levels.sum() * spectrum.frequency[1]
    assert total == pytest.approx(noise.var(), rel=0.02)


def test_spectrogram_follows_a_sweep_and_keeps_the_power():
    signal = chirp(TIME, 10.0, 20.0, 100.0)
    shown = spectrogram(signal, RATE)
    found = shown.frequency[shown.density.argmax(axis=0)]
    expected = 10.0 + 90.0 * shown.time / 20.0
    assert np.abs(found - expected).max() < 3.0
    power = shown.density.sum(axis=0) * shown.frequency[1]
    np.testing.assert_allclose(power, 0.5, rtol=0.05)
    assert shown.time[0] > 0.0
    assert shown.time[-1] < 20.0


@pytest.mark.parametrize("ratio", [40.0, 10.0])
def test_signal_to_noise_ratio_of_a_tone_in_white_noise(ratio):
    deviation = math.sqrt(0.5 / 10 ** (ratio / 10))
    noise = np.random.default_rng(3).normal(0.0, deviation, len(TIME))
    assert signal_to_noise(tone(26.67) + noise, RATE) == pytest.approx(ratio, abs=0.4)
    # Its harmonics are no noise, another tone is.
    more = tone(26.67) + noise + tone(53.34, 0.5)
    assert signal_to_noise(more, RATE) == pytest.approx(ratio, abs=0.4)
    assert signal_to_noise(tone(26.67) + noise + tone(70.0, 0.5), RATE) < 6.5


def test_filtering_raises_the_ratio_of_a_tone_in_the_band():
    """White noise to 500 Hz, of which the chain leaves about 48 Hz."""
    noise = np.random.default_rng(4).normal(0.0, 1.0, len(TIME))
    before, after = analyse(log_of(tone(20.0) + noise), Chain(moving_average=0)).table["snr [dB]"]
    assert after - before == pytest.approx(10 * math.log10(500 / 48), abs=1.0)


def test_orders_of_an_engine_are_found_in_noise():
    rng = np.random.default_rng(5)
    signal = tone(80 / 6, 0.05) + tone(160 / 6, 0.6) + tone(320 / 6, 0.3)
    analysis = analyse(log_of(signal + rng.normal(0, 0.06, len(TIME))), Chain(), Engine(80 / 6))
    orders = analysis.orders
    assert orders["found [Hz]"].to_numpy() == pytest.approx([13.33, 26.67, 53.33], abs=0.05)
    assert orders["amplitude_raw [m/s^2]"].to_numpy() == pytest.approx([0.05, 0.6, 0.3], abs=5e-3)
    assert (orders["above_noise [dB]"] > 25).all()
    filtered = orders["amplitude_filtered [m/s^2]"] / orders["amplitude_raw [m/s^2]"]
    np.testing.assert_allclose(filtered, orders["gain"], rtol=0.05)
    silent = analyse(log_of(rng.normal(0, 0.06, len(TIME))), Chain(), Engine(80 / 6)).orders
    assert (silent["above_noise [dB]"] < 15).all()


# The command


@pytest.mark.slow
def test_a_scenario_becomes_tables_and_a_picture(tmp_path, capsys):
    path = shipped_scenarios() / "vibration" / "engine.yaml"
    assert exit_code(["vibration", str(path), "--output", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "26.67" in out
    assert "first zero at 74 Hz" in err
    folder = tmp_path / "engine"
    assert sorted(p.name for p in folder.iterdir()) == [
        *("density.csv", "figure.png", "figure.svg", "log.csv", "orders.csv"),
        *("provenance.json", "spectrum.csv", "table.csv"),
    ]
    orders = pd.read_csv(folder / "orders.csv").query("channel == 'z'")
    # White noise of 300 µg/√Hz makes an amplitude's deviation of 1.3e-3 m/s² in 20 s.
    amplitudes = orders["amplitude_raw [m/s^2]"].to_numpy()
    assert amplitudes == pytest.approx([0.05, 0.6, 0.3, 0.1], rel=0.03, abs=5e-3)
    log = read_vibration_log(folder / "log.csv")
    assert log.rate == pytest.approx(740.0)
    assert log.samples[:, 2].mean() == pytest.approx(9.8, abs=0.1)


@pytest.mark.parametrize(
    ("column", "options", "message"),
    [
        (np.full(300, 9.8), [], "az is constant (9.8 in SI units): nothing vibrates"),
        (1e200 * np.sin(np.arange(300.0)), [], "reaches 1e+200 m/s², beyond any sensor"),
        (np.sin(np.arange(300.0)), ["--rate", "50 Hz"], "--rate says 50 Hz, the time stamps say"),
        (np.sin(np.arange(300.0)), ["--moving-average", "301"], "longer than the log (300"),
        (np.sin(np.arange(300.0)), ["--time", "time in ns"], "is their unit right?"),
    ],
)
def test_logs_that_tell_nothing_are_refused(tmp_path, capsys, column, options, message):
    path = tmp_path / "log.csv"
    table = pd.DataFrame({"time [s]": np.arange(300) / 100.0, "az [m/s^2]": column})
    table.to_csv(path, index=False)
    arguments = ["vibration", str(path), "--output", str(tmp_path / "out")]
    assert exit_code([*arguments, *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert len(error.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()
    # Control: the rate that the stamps have is no contradiction.
    if "--rate" in options:
        assert exit_code([*arguments, "--rate", "100 Hz", "--quiet"]) == 0


@pytest.mark.slow
def test_a_log_is_analysed_like_the_scenario_it_came_from(tmp_path, capsys):
    path = shipped_scenarios() / "vibration" / "elevator.yaml"
    assert exit_code(["vibration", str(path), "--output", str(tmp_path), "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    log = tmp_path / "elevator" / "log.csv"
    arguments = ["vibration", str(log), "--rpm", "800", "--output", str(tmp_path)]
    assert exit_code(arguments) == 0
    first, second = (pd.read_csv(tmp_path / n / "table.csv") for n in ("elevator", "log"))
    rms = "rms [m/s^2]"
    np.testing.assert_allclose(first[rms], second[rms], rtol=1e-5)
    # The scenario's hum has no order, the engine of the log has some.
    hum, orders = (pd.read_csv(tmp_path / n / "orders.csv") for n in ("elevator", "log"))
    assert hum["order"].isna().all()
    assert sorted(orders["order"].unique()) == [1.0, 2.0, 4.0]
    assert not (tmp_path / "log" / "log.csv").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["absent.yaml"], "absent.yaml: no such file"),
        (["absent.csv"], "absent.csv: no such file"),
        (["{engine}", "--rpm", "0"], "--rpm 0: must be above zero"),
        (["{engine}", "--low-pass", "1 Hz"], "`low_pass` must lie above"),
        (["{engine}", "--low-pass", "50"], "--low-pass: low_pass: "),
        (["{engine}", "--rate", "1 Hz"], "belong to a log"),
        (["{engine}", "--sensor", "MPU"], "--sensor: sensor: "),
        (["{figure}"], "is not `case: vibration`"),
        (["{elevator}", "--cylinders", "4"], "give --rpm too"),
    ],
)
def test_bad_commands_are_explained_and_write_nothing(arguments, message, tmp_path, capsys):
    shipped = shipped_scenarios()
    names = {
        "engine": shipped / "vibration" / "engine.yaml",
        "elevator": shipped / "vibration" / "elevator.yaml",
        "figure": shipped / "paper" / "figure1.yaml",
    }
    given = [text.format(**names) for text in arguments]
    assert exit_code(["vibration", *given, "--output", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert message in err
    assert "Traceback" not in err
    assert out == ""
    assert not (tmp_path / "out").exists()


def test_runs_and_checks_know_the_case(capsys):
    path = str(shipped_scenarios() / "vibration" / "sweep.yaml")
    assert exit_code(["validate", path]) == 0
    assert exit_code(["run", path]) == 2
    assert "use `mcsim vibration`" in capsys.readouterr().err
    assert exit_code(["schema", "vibration"]) == 0
    assert '"vibration"' in capsys.readouterr().out


# Tables 5.1 and 5.2


@pytest.mark.slow
def test_table_of_sensors_finds_the_noise_that_was_put_in():
    """By the flat part of the spectrum, quantisation included; not by Eq. (5.1)."""
    table = sensor_table("density", duration=60.0).set_index(["sensor", "axis"])
    for (name, _), row in table.iterrows():
        wanted = row["density_printed [ug/sqrt(Hz)]"]
        # 60 s and up: a spectrum of 16 segments over half the bins is good to 2 %; the steps of
        # LSM303DLHC and BNO055, 12 and 1 mg, add some noise of their own.
        assert row["density_by_spectrum [ug/sqrt(Hz)]"] == pytest.approx(wanted, rel=0.05), name
        half, band = row["rate [Hz]"] / 2, row["bandwidth [Hz]"]
        expected = wanted * math.sqrt(half / band)
        assert row["density_by_bandwidth [ug/sqrt(Hz)]"] == pytest.approx(expected, rel=0.05)
    # MTI-300 at 400 Hz: Eq. (5.1) divides by 375 Hz and finds three quarters.
    row = table.loc[("MTI-300", "x")]
    found = row["density_by_bandwidth [ug/sqrt(Hz)]"] / row["density_printed [ug/sqrt(Hz)]"]
    assert found == pytest.approx(0.73, abs=0.02)


def test_table_from_allans_coefficients():
    table = sensor_table("allan", names=("MPU-9250", "MTN-1100")).set_index(["sensor", "axis"])
    # N of 0.1277 m/s/√h at 740 Hz; 20 s of samples are good to 2 %.
    expected = 0.1277 / 60 * math.sqrt(740)
    assert table.loc[("MPU-9250", "x"), "std_simulated [m/s^2]"] == pytest.approx(
        expected, rel=0.03
    )
    assert len(table) == 4


def test_printed_values_are_the_sources():
    source = printed("BNO055")
    assert source.rate == 171.0
    assert source.bandwidth == 62.5
    assert source.deviation.tolist() == [0.0097, 0.0112, 0.0140]
    assert printed("MTN-1100").axes == ("z",)


def test_contradictions_are_computed():
    text = "\n".join(remarks())
    assert "MTN-1100: 0.0788 m/s² and 803.77 µg/√Hz need a bandwidth of 99.9 Hz" in text
    assert "788 times less" in text
    assert "LSM9DS1: the printed deviations and densities need a bandwidth of 305 to 308 Hz" in text
    assert "MTI-300: samples at 399.8 Hz hold noise up to 199.9 Hz only" in text
    assert "MPU-9250: the printed deviations" not in text  # 460 Hz fits there
    assert "BNO055: samples at" not in text  # 62.5 Hz lies below half of 171 Hz


def test_the_table_command(tmp_path, capsys):
    arguments = ["table", "sensors", "--noise", "data_sheet", "--duration", "5 s"]
    assert exit_code([*arguments, "--output", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "where the printed values cannot all hold" in out
    assert len(pd.read_csv(tmp_path / "sensors.csv")) == 16
    assert exit_code(["table", "sensors", "--duration", "0 s"]) == 2


def test_sensors_without_noise_are_asked_for_it(tmp_path):
    path = tmp_path / "engine.yaml"
    path.write_text(ENGINE, encoding="utf-8")
    with pytest.raises(InputError, match="LIS33DE: its source gives no noise density"):
        read_vibration(path, "LIS33DE")


@pytest.mark.slow
def test_an_ac_coupled_sensor_of_one_axis_reads_no_gravity(tmp_path):
    """The piezo reference lies along the excitation; a MEMS sensor reads gravity on its z axis."""
    for along in AXES:
        path = tmp_path / f"{along}.yaml"
        path.write_text(ENGINE + f"along: {along}\n", encoding="utf-8")
        log = simulate(read_vibration(path, "MTN-1100"), "log")
        assert log.channels == (along,)
        assert abs(log.samples.mean()) < 0.05
        assert log.samples.std() > 0.3
        notes = " ".join(log.notes)
        assert f"has one axis, which lies along {along}" in notes
        assert "AC-coupled and reads no gravity" in notes
        with_gravity = simulate(read_vibration(path, "MPU-9250"), "log")
        assert with_gravity.channels == AXES
        assert with_gravity.samples[:, 2].mean() == pytest.approx(9.80665, abs=0.05)
        assert with_gravity.notes == ()


@pytest.mark.parametrize(
    ("file", "key"),
    [
        ("paper/figure1.yaml", "sensors.accelerometer"),
        ("strapdown/levelling.yaml", "sensors.accelerometer"),
        ("velocity/a1.yaml", "sensor.accelerometer"),
        ("velocity/a1.yaml", "sensor.accelerometer.model"),
    ],
)
def test_nothing_is_reckoned_from_an_ac_coupled_sensor(file, key):
    scenarios = Path(__file__).parent.parent / "scenarios"
    with pytest.raises(InputError, match="MTN-1100 is AC-coupled: it passes no constant"):
        Scenario.from_yaml(scenarios / file, {key: "MTN-1100"})
    Scenario.from_yaml(scenarios / file, {key: "MPU-9250"})


@pytest.mark.parametrize(
    "text",
    [
        "accelerometer: MTN-1100\n",
        "accelerometer: {model: mtn-1100, range: 50 m/s²}\n",
        'name: "MTN-1100"\naccelerometer: {noise_density: 0.008 m/s²/√Hz}\n',  # as converted
    ],
)
def test_a_sensor_that_a_file_names_keeps_its_kind(tmp_path, text):
    """AC-coupled and with one axis, whichever way it is named; another name changes nothing."""
    scenarios = Path(__file__).parent.parent / "scenarios"
    file, vibration = tmp_path / "sensor.yaml", tmp_path / "vibration.yaml"
    vibration.write_text(ENGINE + "along: x\n", encoding="utf-8")

    def use(text):
        file.write_text(text, encoding="utf-8")
        log = simulate(read_vibration(vibration, str(file)), "log")
        for name, key in (("paper/figure1", "sensors"), ("velocity/a1", "sensor")):
            Scenario.from_yaml(scenarios / f"{name}.yaml", {f"{key}.accelerometer": str(file)})
        return log

    assert use(re.sub("(?i)mtn-1100", "MPU-9250", text)).channels == AXES
    with pytest.raises(InputError, match="MTN-1100 is AC-coupled: it passes no constant"):
        use(text)
    assert simulate(read_vibration(vibration, str(file)), "log").channels == ("x",)
