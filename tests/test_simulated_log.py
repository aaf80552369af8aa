"""Every error term of a sensor element against theory, each with a control that must fail."""

import itertools
import math
from functools import cache

import allantools
import numpy as np
import pytest
from scipy.signal import butter, cont2discrete, lfilter, welch

from mcsim.scenario.document import parse_document
from mcsim.scenario.sensor_file import SensorFile
from mcsim.scenario.validation import validate
from mcsim.sensor_terms.bias_instability import flicker, flicker_processes
from mcsim.sensor_terms.channel import Channel
from mcsim.sensor_terms.gauss_markov import drift
from mcsim.sensor_terms.mechanisms.linear_filter import log_filter
from mcsim.sensor_terms.mechanisms.low_pass import LowPass
from mcsim.sensor_terms.mechanisms.process import in_run_noise, processes_of
from mcsim.sensor_terms.random_walk import walk
from mcsim.sensors.error_model import element_errors
from mcsim.sensors.filters import behind_filters
from mcsim.sensors.simulated_log import SimulatedLog

FLOOR = math.sqrt(2 * math.log(2) / math.pi)
RATE = 100.0


@cache
def block_of(text, kind):
    return getattr(validate(parse_document(f"{kind}: {{{text}}}\n"), SensorFile), kind)


def element(text, count=1000, axes=3, kind="accelerometer", rate=RATE, **options):
    block = block_of(text, kind)
    channels = [Channel(kind, axis) for axis in range(axes)]
    further = [Channel("accelerometer", axis) for axis in range(3)] if kind == "gyroscope" else ()
    errors = element_errors({kind: block}, rate, channels, count / rate, further=further)
    return SimulatedLog(errors, **{"seed": 1, **options})


def noise_of(process, channels, count, rate=RATE, seed=1):
    """One process of that many channels (count, channels)."""
    own = processes_of({"process": process}, 1 / rate, count / rate)
    return in_run_noise((own,) * channels, seed)(count)


def measured(text, count, axes=3, signal=0.0, **options):
    ideal = np.broadcast_to(np.asarray(signal, float).reshape(-1, 1), (count, axes))
    return element(text, count, axes, **options).measure(ideal)


def allan(samples, rate, taus):
    return allantools.oadev(samples, rate=rate, data_type="freq", taus=taus)[1]


def allan_of_ar1(clusters, decay, variance):
    """Allan variance of an AR(1) process over n samples; Zhang, Metrologia 45 (2008) 549."""
    n, driving = clusters, variance * (1 - decay**2)
    top = n - 3 * decay - n * decay**2 + 4 * decay ** (n + 1) - decay ** (2 * n + 1)
    return driving * top / (n**2 * (1 - decay) ** 2 * (1 - decay**2))


def allan_of_gauss_markov(tau, time, variance):
    """The same in continuous time, the source's table of Allan variances."""
    x = tau / time
    if x < 1e-3:
        return 2 * variance * x / 3
    return 2 * variance / x * (1 - (3 - 4 * math.exp(-x) + math.exp(-2 * x)) / (2 * x))


def test_white_noise_has_the_variance_of_its_one_sided_density():
    count = 200_000
    samples = measured("noise_density: [1e-3 m/s²/√Hz, 2e-3 m/s²/√Hz, 0 m/s²/√Hz]", count)
    expected = np.array([1e-3, 2e-3, 0.0]) * math.sqrt(RATE / 2)
    # 5 sigma of a deviation from 200,000 samples: 0.8 %
    np.testing.assert_allclose(samples.std(axis=0), expected, rtol=5 / math.sqrt(2 * count))
    _, density = welch(samples[:, 0], RATE, nperseg=1024)
    assert math.sqrt(density[5:-5].mean()) == pytest.approx(1e-3, rel=0.01)


def test_allans_n_is_smaller_than_the_density_by_root_two():
    count = 100_000
    samples = measured("velocity_random_walk: 1e-3 m/s/√s", count, axes=1)
    assert samples.std() == pytest.approx(1e-3 * math.sqrt(RATE), rel=5 / math.sqrt(2 * count))
    assert allan(samples[:, 0], RATE, [1.0])[0] == pytest.approx(1e-3, rel=0.12)


def flicker_allan(samples, clusters):
    """Allan deviation of flicker noise, B = 1, of a run of that many samples; exact."""
    times, variance = flicker_processes(1.0, samples)
    total = sum(
        allan_of_ar1(clusters, math.exp(-1.0 / t), variance)
        if t < 1e4
        else allan_of_gauss_markov(clusters, t, variance)
        for t in times
    )
    return math.sqrt(total)


def test_flicker_floor_lies_at_0_664_b_for_all_lengths_and_rates():
    """Within 1.5 % from five samples to a tenth of the run, from 50 samples to 10^7."""
    for samples in np.unique(np.logspace(math.log10(50), 7, 60).astype(int)):
        clusters = np.unique(np.logspace(math.log10(5), math.log10(samples / 10), 8).astype(int))
        for m in clusters:
            assert flicker_allan(samples, m) == pytest.approx(FLOOR, rel=0.015), (samples, m)
    # Control: without the shorter half of the processes the floor is gone.
    times, variance = flicker_processes(1.0, 360_000)
    few = sum(allan_of_gauss_markov(100, t, variance) for t in times[len(times) // 2 :])
    assert math.sqrt(few) < 0.5 * FLOOR


def test_flicker_goes_smoothly_with_the_length_of_the_run():
    """Variance of the mean over the run, where a process more or less made a step of 15 %."""

    def of_mean(samples):
        times, variance = flicker_processes(1.0, samples)
        decay = np.exp(-1.0 / times)[:, None]
        lags = np.arange(1, samples)
        sums = samples + 2.0 * np.sum((samples - lags) * decay**lags, axis=1)
        return variance * np.sum(sums) / samples**2

    lengths = np.unique(np.logspace(1.2, 3.3, 500).astype(int))
    counts = np.array([len(flicker_processes(1.0, n)[0]) for n in lengths])
    values = np.array([of_mean(n) for n in lengths])
    # Ten lengths of the run: it levels off at ln(10) / π and a little.
    steps = np.abs(np.diff(values) / values[1:])
    assert np.count_nonzero(np.diff(counts)) >= 3
    assert steps[lengths[1:] > 100].max() < 2e-3
    assert np.ptp(values[lengths > 100]) < 0.01 * values[-1]


def test_simulated_flicker_has_that_floor():
    count, repeats = 2**14, 24
    noise = noise_of(flicker(2.0), repeats, count)
    curves = np.array([allan(row, RATE, [0.16, 1.28, 5.12]) for row in noise.T])
    # Mean square over 24 logs; the longest averages have 32 clusters each: 5 sigma is 20 %.
    found = np.sqrt((curves**2).mean(axis=0))
    np.testing.assert_allclose(found[:2], 2.0 * FLOOR, rtol=0.07)
    np.testing.assert_allclose(found[2], 2.0 * FLOOR, rtol=0.2)


def test_flicker_spectrum_falls_as_one_over_f():
    """One-sided B²/(π f), averaged over many logs."""
    count, repeats = 2**13, 60
    noise = noise_of(flicker(1.0), repeats, count)
    frequency, density = welch(noise, RATE, nperseg=2**11, axis=0)
    band = (frequency > 0.5) & (frequency < 10.0)
    ratio = density[band].mean(axis=1) * frequency[band] * math.pi
    assert ratio.mean() == pytest.approx(1.0, abs=0.05)
    slope = np.polyfit(np.log(frequency[band]), np.log(density[band].mean(axis=1)), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.05)


@pytest.mark.slow
def test_gauss_markov_starts_in_its_stationary_state():
    """Trap: from zero, the deviation at the start would be nothing."""
    repeats, time = 4000, 50.0
    values = noise_of(drift(0.3, time), repeats, 2001)
    first, later = values[0], values[-1]
    for values in (first, later):
        assert values.std() == pytest.approx(0.3, rel=5 / math.sqrt(2 * repeats))
    decay = math.exp(-2000 / RATE / time)
    correlation = np.corrcoef(first, later)[0, 1]
    assert correlation == pytest.approx(decay, abs=5 * (1 - decay**2) / math.sqrt(repeats))


@pytest.mark.parametrize("rate", [10.0, 1000.0])
def test_gauss_markov_is_the_same_process_at_any_rate(rate):
    """Trap: driving noise scaled with the step would make its deviation depend on the rate."""
    axes, duration, time = 400, 2.0, 1.0
    values = noise_of(drift(1.0, time), axes, int(duration * rate), rate)
    assert values.std() == pytest.approx(1.0, rel=0.1)
    lag = int(0.5 * rate)
    correlation = np.corrcoef(values[0], values[lag])[0, 1]
    assert correlation == pytest.approx(math.exp(-0.5), abs=0.16)


def test_infinite_correlation_time_is_a_constant_not_white_noise():
    values = noise_of(drift(0.2, math.inf), 2000, 50)
    assert (values == values[0]).all()
    assert values[0].std() == pytest.approx(0.2, rel=0.08)


def test_vanishing_correlation_time_is_white_noise():
    values = noise_of(drift(1.0, 0.0), 1, 20_000)[:, 0]
    assert np.corrcoef(values[:-1], values[1:])[0, 1] == pytest.approx(0.0, abs=0.035)


def test_gauss_markov_peak_of_the_allan_deviation():
    """The source: peak at 1.89 Tc, 0.437 qc √Tc high, with qc = sigma √(2/Tc)."""
    time, axes = 2.0, 12
    noise = noise_of(drift(1.0, time), axes, 40_000, 20.0)
    taus = [0.4, 1.89 * time, 20.0]
    curves = np.array([allan(row, 20.0, taus) for row in noise.T])
    found = np.sqrt((curves**2).mean(axis=0))
    assert found[1] == pytest.approx(0.437 * math.sqrt(2.0), rel=0.05)
    assert found[0] < found[1] > found[2]


@pytest.mark.slow
@pytest.mark.parametrize("rate", [10.0, 1000.0])
def test_random_walk_grows_with_the_root_of_time_at_any_rate(rate):
    """Trap: steps of K dt instead of K √dt would be 10 times too small at 100 Hz."""
    axes, duration = 3000, 1.0
    values = noise_of(walk(0.5), axes, int(duration * rate) + 1, rate)
    assert not values[0].any()
    assert values[-1].std() == pytest.approx(0.5, rel=5 / math.sqrt(2 * axes))
    early = len(values) // 4
    expected = 0.5 * math.sqrt(early / rate)
    assert values[early].std() == pytest.approx(expected, rel=5 / math.sqrt(2 * axes))


def test_random_walk_of_a_block_is_allans_k():
    """Allan variance K² τ / 3."""
    samples = np.hstack(
        [measured("acceleration_random_walk: 1 m/s²/√s", 20_000, seed=s) for s in range(6)]
    )
    curves = np.array([allan(row, RATE, [3.0]) for row in samples.T])
    assert np.sqrt((curves**2).mean()) == pytest.approx(1.0, rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("key", ["miscalibration", "turn_on_bias"])
def test_offsets_are_drawn_once_per_element(key):
    first, second = (measured(f"{key}: 1 mg", 10, seed=s) for s in (1, 2))
    assert (first == first[0]).all()
    assert not (first == second).any()
    drawn = [measured(f"{key}: 1 m/s²", 1, seed=s)[0] for s in range(1000)]
    assert np.std(drawn) == pytest.approx(1.0, rel=5 / math.sqrt(6000))


@pytest.mark.slow
def test_scale_factors_and_misalignments_have_their_deviations():
    ideal = np.array([[0.0, 0.0, 10.0]])
    text = "scale_factor_error: 1 %, misalignment: 2 mrad"
    drawn = np.array([element(text, seed=s).measure(ideal)[0] for s in range(2000)])
    assert drawn[:, 2].mean() == pytest.approx(10.0, abs=5 * 0.1 / math.sqrt(2000))
    assert drawn[:, 2].std() == pytest.approx(0.1, rel=0.08)
    assert drawn[:, :2].std() == pytest.approx(0.02, rel=0.06)
    assert np.corrcoef(drawn[:, 0], drawn[:, 1])[0, 1] == pytest.approx(0.0, abs=0.12)


def test_g_sensitivity_answers_to_the_specific_force():
    """Each axis to all three of the force, by coefficients of its own."""
    still, force = np.zeros((4, 3)), np.array([[0, 0, 0], [1, 1, 1], [2, 2, 2], [9.8, 0, 0]], float)
    gyroscope = element("g_sensitivity: 1 °/s/g", kind="gyroscope")
    rates = gyroscope.measure(np.hstack([still, force]))
    assert not rates[0].any()
    np.testing.assert_allclose(rates[2], 2 * rates[1])
    assert len(set(rates[3])) == 3


def test_low_pass_loses_3_db_at_its_bandwidth_and_nothing_at_rest():
    count, cut_off, dense = 2000, 10.0, 4
    t = np.arange(count * dense) / (RATE * dense)
    tone = np.sin(2 * np.pi * cut_off * t)[:, None]
    out = element(f"bandwidth: {cut_off} Hz", count, 1, oversampling=dense).measure(tone)[:, 0]
    gain = out[500:].std() * math.sqrt(2)
    # Straight lines between 40 samples of a period: (π / 40)² / 3.
    assert gain == pytest.approx(1 / math.sqrt(2), rel=2.5e-3)
    constant = measured(f"bandwidth: {cut_off} Hz", 50, axes=1, signal=np.full(50, 9.8))
    np.testing.assert_allclose(constant, 9.8)


def test_low_pass_is_scipys_of_straight_lines_between_the_samples():
    """And not its bilinear one, whose time constant is another."""
    signal = np.random.default_rng(9).normal(size=500)
    signal[:2] = 0.0
    tau = 1 / (2 * np.pi * 12.0)
    numerator, denominator, _ = cont2discrete(([1.0], [tau, 1.0]), 1 / RATE, method="foh")
    theirs = lfilter(numerator.ravel(), denominator, signal)
    ours = log_filter(((LowPass(12.0),),), RATE)(signal[:, None])[:, 0]
    np.testing.assert_allclose(ours, theirs, atol=1e-12)
    assert np.abs(ours - lfilter(*butter(1, 12.0, fs=RATE), signal)).max() > 0.01


def test_a_drives_low_pass_is_that_of_a_log():
    """Kernels measure behind the one, logs have the other."""
    frequency, cut_off, dense, count = 7.0, 12.0, 16, 300

    def tone(t):
        return np.cos(2 * np.pi * frequency * t)

    own = ((LowPass(cut_off),),)
    driven = behind_filters(lambda t, _: tone(t)[None], own, 0.0, RATE, count)
    times = np.arange(count * dense) / (RATE * dense)
    log = log_filter(own, RATE * dense)(tone(times)[:, None])[::dense, 0]
    late = np.arange(count) > 50
    behind = driven(times[::dense], 0.0)[0]
    np.testing.assert_allclose(log[late], behind[late], atol=2e-3)
    bilinear = lfilter(*butter(1, cut_off, fs=RATE), tone(times[::dense]))
    assert np.abs(bilinear - behind)[late].max() > 0.01


def test_dense_signals_are_filtered_before_they_are_picked():
    """A 60 Hz tone through a 20 Hz low-pass, sampled at 50 Hz: aliased, and a third as high."""
    rate, dense, count = 50.0, 20, 2000
    t = np.arange(count * dense) / (rate * dense)
    out = element("bandwidth: 20 Hz", count, 1, rate=rate, oversampling=dense).measure(
        np.sin(2 * np.pi * 60.0 * t)[:, None]
    )
    assert len(out) == count
    expected = 1 / math.sqrt(1 + 3.0**2)
    assert math.sqrt(2) * out[200:].std() == pytest.approx(expected, rel=0.02)


def test_spikes_come_at_their_rate_with_either_sign():
    count = 100_000
    samples = measured("spikes: {rate: 2 Hz, amplitude: 3 m/s²}", count)
    hits = samples != 0.0
    expected = 3 * count * 2.0 / RATE
    assert hits.sum() == pytest.approx(expected, abs=5 * math.sqrt(expected))
    assert set(np.unique(np.abs(samples[hits]))) == {3.0}
    assert (samples > 0).sum() == pytest.approx(hits.sum() / 2, abs=5 * math.sqrt(expected))


def test_saturation_comes_before_quantisation():
    signal = np.array([-50.0, -0.26, 0.24, 0.26, 50.0])
    out = measured("range: 2 m/s², resolution: 0.5 m/s²", 5, axes=1, signal=signal)[:, 0]
    assert out.tolist() == [-2.0, -0.5, 0.0, 0.5, 2.0]


def test_quantisation_adds_a_twelfth_of_its_step_squared():
    ramp = np.linspace(0.0, 100.0, 50_001)
    out = measured("resolution: 0.1 m/s²", len(ramp), axes=1, signal=ramp)[:, 0]
    assert (out - ramp).std() == pytest.approx(0.1 / math.sqrt(12), rel=0.01)


ALL_TERMS = (
    "noise_density: 1 mg/√Hz, bias_instability: 1 mg, acceleration_random_walk: 1 mg/√s,"
    "gauss_markov: {deviation: 1 mg, correlation_time: 1 s}, miscalibration: 1 mg,"
    "turn_on_bias: 1 mg, scale_factor_error: 1 %, misalignment: 1 °, bandwidth: 20 Hz,"
    "spikes: {rate: 5 Hz, amplitude: 1 m/s²}, resolution: 0.1 mg, range: 10 g"
)


@pytest.mark.parametrize("oversampling", [1, 4])
def test_results_do_not_depend_on_how_the_signal_is_cut(oversampling):
    ideal = np.random.default_rng(10).normal(size=(4000, 3))
    whole = element(ALL_TERMS, oversampling=oversampling).measure(ideal)
    pieces = element(ALL_TERMS, oversampling=oversampling)
    cuts = [0, 1, 1, 7, 500, 1999, 3998, 4000]
    parts = [pieces.measure(ideal[a:b]) for a, b in itertools.pairwise(cuts)]
    np.testing.assert_array_equal(np.vstack(parts), whole)


def test_a_seed_gives_the_same_log_and_another_gives_another():
    same = [measured(ALL_TERMS, 200, seed=s) for s in (3, 3, 4)]
    np.testing.assert_array_equal(same[0], same[1])
    assert not (same[0] == same[2]).all()


def test_adding_a_term_leaves_the_others_numbers():
    """White noise and white noise with an offset differ by a constant."""
    plain = measured("noise_density: 1 mg/√Hz", 100)
    more = measured("noise_density: 1 mg/√Hz, turn_on_bias: 1 mg", 100)
    difference = more - plain
    np.testing.assert_allclose(difference, np.broadcast_to(difference[0], difference.shape))


def test_an_element_without_errors_changes_nothing():
    ideal = np.random.default_rng(11).normal(size=(50, 3))
    np.testing.assert_array_equal(element("range: 100 g").measure(ideal), ideal)
