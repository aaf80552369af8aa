"""The judge of time stamps: what is lost, what only looks so, and that its advice works."""

import re

import numpy as np
import pytest

from benchmarks.time_stamps import is_right, trial
from mcsim.cli.main import exit_code
from mcsim.errors import InputError
from mcsim.logs import ReadOptions, read_log
from mcsim.logs.clock import mend_clock
from mcsim.logs.timing import judge
from mcsim.vibration.log import read_vibration_log
from tests.reference.time_stamps import bursts, jitter, stalls, wrapped

STEP, ROWS = 0.02, 3500
TIME = np.arange(ROWS) * STEP
RNG = np.random.default_rng(5)
NOISE = 0.01 * RNG.standard_normal((ROWS, 2))


def write(path, stamps, values=NOISE):
    rows = np.column_stack([stamps, values])
    np.savetxt(
        path, rows, "%.10g", ",", header="time [s],gx [rad/s],ax [m/s^2]", comments="",
        encoding="utf-8",
    )  # fmt: skip
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "loss"),
    [
        ("jitter 30 %", 0.0),
        ("jitter 30 %", 0.005),
        ("jitter 45 %", 0.0),
        ("bursts of 5", 0.0),
        ("bursts of 5", 0.0005),
        ("clock of 10 ms at 1 kHz", 0.0),
        ("clock of 15.6 ms at 100 Hz", 0.0),
        ("stale 10 %", 0.005),
        ("set back by 1.4 intervals", 0.0),
        ("begins anew after a minute", 0.0005),
    ],
)
def test_losses_are_told_from_all_that_looks_like_one(name, loss):
    """The cheap part of ``benchmarks/time_stamps.txt``; single intervals would fail in most."""
    lost, found, rate = trial(name, loss, 3000, 1)
    assert is_right(lost, found)
    assert abs(rate) < 1e-3


@pytest.mark.slow
def test_the_place_of_a_loss_is_found():
    """Within a few rows, as well as 30 % jitter tells it."""
    index = np.delete(np.arange(ROWS + 2), [1000, 2500])
    found = judge(mend_clock(jitter(0.3)(index, STEP, np.random.default_rng(2))))
    assert found.missing == 2
    np.testing.assert_allclose(found.gaps[:, 0], [1000, 2499], atol=6)
    # Control: intervals of a lost sample's length there are many.
    assert np.count_nonzero(np.diff(found.clock.stamps) > 1.75 * STEP) > 20


@pytest.mark.parametrize("period", [2.0**16 * 1e-3, 60.0, 2.0**32 * 1e-6])
def test_clocks_that_begin_anew_keep_what_was_lost_there(period):
    stamps = wrapped(period, 0.05)(np.arange(ROWS), STEP, np.random.default_rng(3))
    if period > ROWS * STEP:
        stamps = np.mod(stamps + 0.63 * period - 40.0, period)
    place = int(np.argmin(np.diff(stamps))) + 1
    clock = mend_clock(np.delete(stamps, slice(place, place + 2)))
    assert any("begins anew" in note for note in clock.notes)
    found = judge(clock)
    assert (found.missing, found.gaps[0, 0]) == (2, pytest.approx(place, abs=2))


def test_rows_out_of_order_are_sorted_and_repeated_ones_left_out(tmp_path):
    order = np.arange(ROWS)
    order[100:104] = [102, 100, 103, 101]
    log = read_log(write(tmp_path / "a.csv", TIME[order], NOISE[order]))
    np.testing.assert_allclose(log.channels[1].samples, NOISE[:, 0], rtol=1e-9)
    assert any("out of order" in note for note in log.notes)
    twice = np.sort(np.concatenate([np.arange(ROWS), [7, 70, 700]]))
    log = read_log(write(tmp_path / "b.csv", TIME[twice], NOISE[twice]))
    assert (log.timing.duplicates, len(log.channels[0].samples)) == (3, ROWS)


def test_stale_stamps_keep_their_samples(tmp_path):
    stamps = TIME.copy()
    stamps[10::25] = stamps[9::25][: len(stamps[10::25])]
    log = read_log(write(tmp_path / "a.csv", stamps))
    np.testing.assert_allclose(log.channels[1].samples, NOISE[:, 0], rtol=1e-9)
    assert any("repeat the one before" in note for note in log.notes)
    log = read_vibration_log(write(tmp_path / "b.csv", stamps))
    np.testing.assert_allclose(log.samples[:, 0], NOISE[:, 1], rtol=1e-9)


def test_a_stalled_host_loses_nothing():
    rng = np.random.default_rng(4)
    found = judge(mend_clock(stalls(6, 40)(np.arange(ROWS), STEP, rng)))
    assert found.missing == 0
    found = judge(mend_clock(bursts(100)(np.arange(ROWS), STEP, rng)))
    assert found.missing == 0


def test_the_cut_comes_before_the_judgement(tmp_path):
    """What is wrong outside the cut is no matter."""
    stamps = TIME.copy()
    stamps[10 : ROWS // 2 : 50] += 3.0
    stamps[:1000] += np.cumsum(np.arange(1000) % 20 == 0) * STEP
    stamps[1000:] += 50 * STEP
    path = write(tmp_path / "a.csv", stamps)
    whole = 1.0 + ROWS * STEP
    log = read_log(path, ReadOptions(start=whole / 2 + 1.0, end=whole - 1.0))
    assert (log.timing.missing, log.timing.notes) == (0, ())
    assert len(log.channels[0].samples) == pytest.approx((whole / 2 - 2.0) / STEP, abs=2)


def broken():
    keep = np.random.default_rng(6).random(ROWS) > 0.02
    gaps = TIME + 0.5 * np.clip(np.arange(ROWS) // 500, 0, 4)
    forward = TIME + 3600.0 * (np.arange(ROWS) // 1200)
    return {
        "lost": (TIME[keep], NOISE[keep]),
        "gaps": (gaps, NOISE),
        "set forward": (forward, NOISE),
        "same": (0.0 * TIME, NOISE),
        "coarse": (np.floor(TIME / 7.0) * 7.0, NOISE),
        "backwards": (np.where(np.arange(ROWS) % 7 == 0, -5.0, 0.1).cumsum(), NOISE),
        "µs": (1e6 * TIME, NOISE),
    }


@pytest.mark.parametrize("case", broken())
def test_the_advice_of_every_refusal_works(tmp_path, case):
    path = write(tmp_path / "log.csv", *broken()[case])
    with pytest.raises(InputError) as refused:
        read_log(path)
    message = str(refused.value)
    advised = []
    if cut := re.search(r"--start (\S+) --end (\S+);", message):
        advised.append(ReadOptions(start=float(cut[1]), end=float(cut[2])))
    if rate := re.search(r"--rate (\d+)", message):
        advised.append(ReadOptions(rate=float(rate[1])))
    if "--units time" in message:
        advised.append(ReadOptions(units="time=µs"))
    assert advised
    for options in advised:
        log = read_log(path, options)
        assert len(log.channels[0].samples) > 900
        # A rate that sets the stamps aside says so.
        assert log.timing.stamped or any("set aside" in note for note in log.notes)


@pytest.mark.slow
def test_the_advice_for_a_hole_in_a_vibration_works(tmp_path, capsys):
    path = write(tmp_path / "log.csv", TIME + 9.0 * (np.arange(ROWS) >= 1000))
    arguments = ["vibration", str(path), "--output", str(tmp_path / "out"), "--quiet"]
    assert exit_code(arguments) == 2
    advice = re.search(r"(--start \S+ --end \S+) is", capsys.readouterr().err)
    assert advice is not None
    assert exit_code([*arguments, *advice[1].split()]) == 0
