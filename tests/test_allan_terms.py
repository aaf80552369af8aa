"""Terms of Allan analysis: densities, Allan variances, readings, peaks."""

import math
import re

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.special import sici

from mcsim.characterisation import noise_terms as terms
from mcsim.characterisation.allan import averaging_factors, gauss_markov_variance
from mcsim.characterisation.density_integral import TabulatedDensity, allan_from_density
from mcsim.characterisation.peak_rule import Peak, find_peak
from mcsim.characterisation.process import GaussMarkov
from mcsim.characterisation.read_offs import reading_of
from mcsim.characterisation.terms_of_curve import terms_of_curve
from tests.reference.noise import gauss_markov

TAU = np.geomspace(0.01, 1e4, 25)
PROCESS = GaussMarkov(5.0, 0.7)
WITH_DENSITY = {
    "white": (terms.white(2.0), None),
    "flicker": (terms.flicker(0.3), None),
    "flicker with cut-off": (terms.flicker(0.3, 1.0), 1.0),
    "random walk": (terms.random_walk(0.5), None),
    "Gauss-Markov": (terms.gauss_markov(PROCESS), None),
}


@pytest.mark.parametrize("name", WITH_DENSITY)
def test_closed_forms_are_the_integral_of_their_density(name):
    """Eq. (3.12): the oracle is quadrature, the closed forms are the thesis' (and IEEE 952's)."""
    term, kink = WITH_DENSITY[name]
    points = None if kink is None else np.array([kink])
    integral = allan_from_density(term.density, TAU, points=points)
    np.testing.assert_allclose(integral, term.variance(TAU), rtol=2e-8)


def test_the_cut_off_formula_has_four_x_where_the_thesis_prints_three():
    """Eq. (3.16) as printed misses the integral by up to a factor of 2; IEEE 952's is right."""
    x = np.pi * TAU
    bracket = np.log(2.0) + sici(2.0 * x)[1] - sici(4.0 * x)[1]
    share = np.sin(x) ** 3 / (2.0 * x**2)
    printed = 2.0 / np.pi * (bracket - share * (np.sin(x) + 3.0 * x * np.cos(x)))
    integral = allan_from_density(terms.flicker(1.0, 1.0).density, TAU, points=np.array([1.0]))
    assert printed[0] / integral[0] == pytest.approx(2.0, rel=0.01)
    assert terms.flicker_variance(TAU, 1.0)[-1] == pytest.approx(2.0 * math.log(2.0) / math.pi)
    # Far below the cut-off's time: x² / π, from the series, without a step where it begins.
    near = np.linspace(0.015, 0.025, 101) / np.pi
    ratio = terms.flicker_variance(near, 1.0) / (np.pi * near**2)
    assert np.all(np.abs(np.diff(ratio)) < 1e-5)
    assert ratio[0] == pytest.approx(1.0, abs=1e-3)


def test_quantisation_of_samples_has_the_weight_of_clusters_of_samples():
    """White phase: 3 Q² / τ² exactly, for the weight of sampled clusters."""
    term = terms.quantisation(0.4, 0.01)
    tau = 0.01 * np.array([1.0, 3.0, 10.0, 1000.0])
    sampled = allan_from_density(term.density, tau, (0.0, 50.0), interval=0.01)
    np.testing.assert_allclose(sampled, term.variance(tau), rtol=1e-10)
    # Control: clusters of a continuous signal see less of it.
    assert allan_from_density(term.density, tau, (0.0, 50.0))[0] < 0.8 * sampled[0]


def test_a_sinusoid_is_that_of_a_sampled_one():
    """Allan variance of a long sinusoid, against the closed form."""
    from mcsim.characterisation import allan_curve

    rate, n, frequency = 50.0, 200_000, 0.1234
    samples = 0.3 * np.sin(2.0 * np.pi * frequency * np.arange(n) / rate + 0.4)
    curve = allan_curve(samples, rate, np.array([20, 100, 185, 300]))
    expected = terms.sinusoid(0.3, frequency).deviation(curve.tau)
    np.testing.assert_allclose(curve.deviation, expected, rtol=2e-3)


EVERY = [
    terms.quantisation(2.0, 0.01),
    terms.white(2.0),
    terms.flicker(2.0),
    terms.flicker(2.0, 1.0),
    terms.random_walk(2.0),
    terms.ramp(2.0),
    terms.gauss_markov(PROCESS),
    terms.sinusoid(2.0, 0.1),
]


@pytest.mark.parametrize("term", EVERY, ids=lambda term: term.letter)
def test_coefficients_are_read_where_it_says(term):
    at = np.array([term.read_off.tau])
    expected = term.read_off.level * term.coefficient
    assert term.deviation(at)[0] == pytest.approx(expected, rel=2e-4)


@pytest.mark.parametrize(
    ("variance", "place", "level"),
    [
        (lambda x: gauss_markov_variance(x, 1.0), terms.PEAK_TIME, terms.PEAK_LEVEL),
        (lambda x: terms.sinusoid(1.0, 1.0 / np.pi).variance(x), 1.165561, 0.724611),
    ],
)
def test_peaks_lie_where_the_constants_say(variance, place, level):
    """S4: the printed 1.89 and 0.437 are these to three digits."""
    found = minimize_scalar(
        lambda x: -variance(np.array([x]))[0], bounds=(0.5, 3.0), method="bounded",
        options={"xatol": 1e-10},
    )  # fmt: skip
    assert found.x == pytest.approx(place, abs=2e-6)
    assert math.sqrt(-found.fun) == pytest.approx(level, abs=1e-6)


def test_the_peak_rule_gives_back_a_process():
    assert round(terms.PEAK_TIME, 2) == 1.89
    assert round(terms.PEAK_LEVEL, 3) == 0.437
    tau = np.geomspace(0.01, 1e3, 51)
    peak = find_peak(tau, PROCESS.allan_variance(tau))
    # A parabola through points a fifth of a decade apart.
    assert peak.correlation_time == pytest.approx(5.0, rel=0.01)
    assert peak.model.deviation == pytest.approx(0.7, rel=0.005)
    assert peak.drive == pytest.approx(0.7 * math.sqrt(2.0 / 5.0), rel=0.01)
    # Beside white noise: where that is taken off first; a walk has no peak at all.
    both = PROCESS.allan_variance(tau) + 1.0 / tau
    assert find_peak(tau, both, 1.0).correlation_time == pytest.approx(5.0, rel=0.01)
    assert find_peak(tau, tau / 3.0) is None
    assert Peak(1.89, 0.437).correlation_time == pytest.approx(1.0, rel=0.002)


@pytest.mark.parametrize("white", [0.0, 0.2])
def test_the_peak_rule_on_logs(white):
    """20 logs of 600 correlation times: Tc on average within its own scatter."""
    from mcsim.characterisation import allan_curve

    rng = np.random.default_rng(2)
    times = []
    for _ in range(20):
        samples = gauss_markov(5.0, 0.7, 5.0, 15_000, rng)
        samples += white * np.sqrt(5.0) * rng.standard_normal(15_000)
        curve = allan_curve(samples, 5.0, averaging_factors(15_000, 5.0))
        peak = find_peak(curve.tau, curve.variance, white)
        times += [] if peak is None else [peak.correlation_time]
    assert len(times) >= 18
    assert np.mean(times) == pytest.approx(5.0, abs=4.0 * np.std(times) / math.sqrt(len(times)))
    assert np.std(times) < 2.5


def test_readings_of_a_mix():
    """Shares, regions and how much too large a reading is, from the definition."""
    mix = [terms.white(1.0), terms.flicker(0.1), terms.random_walk(0.0003)]
    white, flicker, walk = (reading_of(term, mix, 0.01, 0.1) for term in mix)
    assert white.tau == pytest.approx(1.0, rel=0.02)
    for reading in (white, flicker, walk):
        total = terms.total_variance(mix, np.array([reading.tau]))[0]
        own = reading.term.variance(np.array([reading.tau]))[0]
        assert reading.share == pytest.approx(own / total)
        assert math.sqrt(total / own) - 1.0 == pytest.approx(reading.bias)
    assert white.region[1] < flicker.tau < walk.region[0]
    assert walk.bias <= 0.1
    # A plateau is flattest between its neighbours, where N²/τ = K² τ / 3; its beginning is read.
    assert flicker.tau < math.sqrt(3.0) / 0.0003
    middle = np.array([math.sqrt(3.0) / 0.0003])
    largest = mix[1].variance(middle)[0] / terms.total_variance(mix, middle)[0]
    assert flicker.share == pytest.approx(0.95 * largest, rel=0.01)
    assert flicker.share < largest
    # Without a random walk the plateau has no end.
    assert reading_of(mix[1], mix[:2], 0.01, 0.1).tau < 1e4
    hidden = [terms.white(1.0), terms.flicker(0.1), terms.random_walk(0.05)]
    assert reading_of(hidden[1], hidden, 0.01, 0.1).region is None


def test_tabulated_power_laws_are_integrated_exactly():
    """Two points make a power law; continued, it is that of the whole axis."""
    for slope, term in ((0.0, terms.white(1.5)), (-2.0, terms.random_walk(1.5))):
        f = np.array([1e-3, 1e-1, 1e2])
        table = TabulatedDensity(f, term.density(f))
        assert table.slopes == pytest.approx((slope, slope), abs=1e-12)
        tau = np.array([0.1, 1.0, 30.0])
        whole = allan_from_density(table.continued(), tau, points=f)
        np.testing.assert_allclose(whole, term.variance(tau), rtol=1e-7)
        inside = allan_from_density(table, tau, table.band, f)
        assert np.all(inside < whole)


def test_terms_of_a_curve_come_back():
    tau = np.geomspace(0.1, 1e4, 60)
    mix = [terms.quantisation(0.01, 0.1), terms.white(0.5), terms.flicker(0.05), terms.ramp(1e-6)]
    deviation = np.sqrt(terms.total_variance(mix, tau))
    found = terms_of_curve(tau, deviation, ("Q", "N", "B", "K", "R"))
    assert [t.letter for t in found.terms if t.coefficient > 1e-9] == ["Q", "N", "B", "R"]
    by_letter = {t.letter: t.coefficient for t in found.terms}
    for term in mix:
        assert by_letter[term.letter] == pytest.approx(term.coefficient, rel=1e-6)
    assert found.rms < 1e-9
    process = [terms.white(0.5), terms.gauss_markov(GaussMarkov(20.0, 0.3))]
    curve = np.sqrt(terms.total_variance(process, tau))
    fitted = terms_of_curve(tau, curve, ("N", "B", "K", "GM"))
    assert fitted.rms < 0.01
    # Control: without the process the curve is not made up of the terms.
    assert terms_of_curve(tau, curve, ("N", "B", "K")).rms > 0.1


@pytest.mark.slow
def test_characterise_tells_the_peak_rule_beside_the_fit():
    """A Gauss-Markov bias of 20 s in 2 h: the finding holds both."""
    from pathlib import Path

    from mcsim.characterisation import Settings, characterise
    from mcsim.logs import Channel, Log, Timing

    rng = np.random.default_rng(9)
    n, rate = 36_000, 5.0
    white = 0.0015 * np.sqrt(rate) * rng.standard_normal(n)
    biased = white + gauss_markov(20.0, 0.005, rate, n, rng)
    channel = Channel("accelerometer", "x", biased)
    log = Log(Path("static.csv"), (channel,), Timing(rate, stamped=True))
    found = characterise(log, Settings(intervals="covariance"))
    peaks = [f for f in found.findings if f.kind == "peak"]
    assert [f.channel for f in peaks] == ["accel_x"]
    by_rule, by_fit = (float(x) for x in re.findall(r"(?:Tc|by the fit) ([\d.]+) s", peaks[0].text))
    # One log of 360 correlation times: the place of a flat peak is known to some 20 %.
    assert by_rule == pytest.approx(20.0, rel=0.6)
    assert by_fit == pytest.approx(20.0, rel=0.3)
