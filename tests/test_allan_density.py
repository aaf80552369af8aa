"""Densities and Allan curves from files, there and back; the command; the table of recovery."""

import math

import numpy as np
import pandas as pd
import pytest

import mcsim
from mcsim.api.allan.tables import read_curve, read_density
from mcsim.characterisation import noise_terms as terms
from mcsim.cli.main import exit_code
from mcsim.errors import InputError
from mcsim.papers import allan_recovery


@pytest.fixture
def write(tmp_path):
    def write(text, name="table.csv"):
        file = tmp_path / name
        file.write_text(text)
        return file

    return write


def spectrum(title, value):
    return f"frequency [Hz],{title}\n0.001,{value}\n1,{value}\n500,{value}\n"


@pytest.mark.parametrize(
    ("title", "value", "element", "two_sided"),
    [
        ("one-sided density [(m/s^2)^2/Hz]", 2e-6, "accelerometer", 1e-6),
        ("two-sided psd [(m/s²)²/Hz]", 2e-6, "accelerometer", 2e-6),
        ("one-sided psd [m²/s⁴/Hz]", 2e-6, "accelerometer", 1e-6),
        ("one-sided asd [µg/√Hz]", 100.0, "accelerometer", 0.5 * (1e-4 * 9.80665) ** 2),
        ("single-sided density [(deg/s)^2/Hz]", 2.0, "gyroscope", (math.pi / 180.0) ** 2),
        ("one-sided density [g^2/Hz]", 2e-6, "accelerometer", 1e-6 * 9.80665**2),
        ("one-sided density [°/s/√Hz]", 1.0, "gyroscope", 0.5 * (math.pi / 180.0) ** 2),
    ],
)
def test_units_and_conventions_of_densities(write, title, value, element, two_sided):
    found = read_density(write(spectrum(title, value)))
    assert found.element == element
    np.testing.assert_allclose(found.density, two_sided, rtol=1e-12)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (spectrum("density [(m/s^2)^2/Hz]", 1.0), "give --sides one"),
        (spectrum("one-sided density [m/s^2]", 1.0), "no unit of a density"),
        (spectrum("one-sided density", 1.0), "no unit of a density"),
        (spectrum("one-sided density [(m/s²)²/Hz]", -1.0), "table.csv:2: a density is above zero"),
        (
            "f [Hz],one-sided psd [g²/Hz]\n1,1\n0.5,1\n2,1\n",
            "table.csv:3: frequencies must ascend (here 0.5)",
        ),
        ("f,one-sided psd [g²/Hz]\n1,1\n2,1\n3,1\n", "write f [Hz]"),
        ("a [Hz],one-sided psd [g²/Hz]\n1,1\n2,1\n3,1\n", "no column is a frequency"),
        ("f [Hz],b [g]\n1,1\n2,1\n3,1\n", "no title names a density"),
        ("f [Hz],one-sided psd [g²/Hz]\n1,1\n2,1\n", "at least 3"),
        (
            "channel,frequency_hz,psd_one_sided\naccel_x,1,1\ngyro_x,1,1\n",
            "choose one with --channel",
        ),
    ],
)
def test_what_a_density_table_lacks_is_said(write, text, said, capsys):
    file = write(text)
    assert exit_code(["allan", "from-density", str(file)]) == 2
    out, err = capsys.readouterr()
    assert said in err
    assert not out


def test_sides_that_contradict_are_refused(write):
    file = write(spectrum("one-sided density [g²/Hz]", 1.0))
    with pytest.raises(InputError, match="says one-sided, --sides says two"):
        read_density(file, "two")
    plain = write(spectrum("density [g²/Hz]", 2.0), "plain.csv")
    one, two = (read_density(plain, sides).density[0] for sides in ("one", "two"))
    assert two == 2.0 * one


def test_from_a_density_and_back(write, tmp_path, capsys):
    """A sensor's terms, their density as a file, its Allan curve as a file, the terms again."""
    there = mcsim.allan.to_density("MPU-9250", axis="x")
    table = there.table.query("term == 'total'")
    text = pd.DataFrame(
        {
            "frequency [Hz]": table["frequency_hz"],
            "one-sided psd [(m/s^2)^2/Hz]": table["psd_one_sided"],
        }
    ).to_csv(index=False)
    curve = mcsim.allan.from_density(write(text, "psd.csv"))
    sensor = there.axes[0].terms
    exact = np.sqrt(terms.total_variance(sensor, curve.tau))
    assert curve.known.sum() > 30
    np.testing.assert_allclose(curve.continued[curve.known], exact[curve.known], rtol=0.005)
    assert np.all(curve.inside <= curve.continued)
    known = pd.DataFrame(
        {"tau [s]": curve.tau[curve.known], "adev [m/s^2]": curve.continued[curve.known]}
    ).to_csv(index=False)
    back = mcsim.allan.to_density(write(known, "adev.csv"))
    for term, again in zip(sensor[:2], back.axes[0].terms, strict=False):
        assert again.letter == term.letter
        assert again.coefficient == pytest.approx(term.coefficient, rel=0.01)
    assert "Greenhall 1998" in back.text
    folder = tmp_path / "out"
    arguments = ["allan", "to-density", str(tmp_path / "adev.csv"), "--terms", "N,B,K,GM"]
    assert exit_code([*arguments, "--output", str(folder)]) == 0
    assert {"density.csv", "allan.csv", "density.png"} <= {f.name for f in folder.iterdir()}
    assert "fitted" in capsys.readouterr().out.lower()


def test_closed_forms_of_a_sensor_are_its_integral():
    table = mcsim.allan.to_density("LSM9DS1").allan
    assert (table["adev_integral"] / table["adev"] - 1.0).abs().max() < 1e-8


def test_steep_ends_have_no_integral(write, tmp_path):
    f = np.geomspace(0.01, 100.0, 30)
    rows = "".join(f"{x:.6g},{x**-3.5:.6g}\n" for x in f)
    found = mcsim.allan.from_density(write(f"f [Hz],one-sided psd [g²/Hz]\n{rows}"))
    assert np.isnan(found.continued).all()
    assert np.isfinite(found.inside).all()
    assert "would be infinite" in found.text
    assert found.write(tmp_path / "out")


def test_tables_of_characterise_are_read(write):
    """Names without units are SI there; the interval gives the weights."""
    psd = write(
        "channel,frequency_hz,psd_one_sided,floor_one_sided\n"
        + "".join(f"{c},{f},2e-6,1\n" for c in ("accel_x", "gyro_z") for f in (0.1, 1, 10))
    )
    assert read_density(psd, channel="gyro_z").element == "gyroscope"
    assert read_density(psd, channel="accel_x").density[0] == pytest.approx(1e-6)
    with pytest.raises(InputError, match="no channel"):
        read_density(psd, channel="gyro_x")
    allan = write(
        "channel,tau_s,adev,ci_low,ci_high\naccel_x,0.1,0.3,0.29,0.31\naccel_x,1,0.1,0.08,0.12\n"
        "accel_x,10,0.03,0.02,0.05\n",
        "allan.csv",
    )
    curve = read_curve(allan)
    assert curve.element == "accelerometer"
    assert np.all(np.diff(curve.spread) > 0.0)


def test_terms_that_there_are_not_are_refused(write):
    file = write("tau [s],adev [m/s²]\n1,1\n10,0.3\n100,0.1\n1000,0.05\n10000,0.05\n")
    with pytest.raises(InputError, match='"Z" is none of'):
        mcsim.allan.to_density(file, terms=("Z",))
    with pytest.raises(InputError, match="too few"):
        mcsim.allan.to_density(file, terms=("Q", "N", "B", "K", "R"))
    with pytest.raises(InputError, match="of an Allan table"):
        mcsim.allan.to_density("MPU-9250", terms=("N",))


@pytest.mark.parametrize("sensor", [None, "BNO055"])
def test_curves_are_written(sensor, tmp_path):
    found = mcsim.allan.curves(sensor)
    names = {f.name for f in found.write(tmp_path)}
    assert names == {"curves.csv", "curves.png", "curves.svg", "provenance.json"}
    table = found.table
    if sensor is None:
        assert set(table["term"]) == {"Q", "N", "B", "K", "R", "GM", "S", "total"}
        with pytest.raises(InputError, match="of a sensor"):
            mcsim.allan.curves(axis="x")
    else:
        x = table[table["curve"] == "accelerometer x"].pivot_table("adev", "tau_s", "term")
        parts = np.sqrt(x["N"] ** 2 + x["B"] ** 2 + x["K"] ** 2)
        np.testing.assert_allclose(parts, x["total"], rtol=1e-12)


def test_flicker_of_a_sensor_ends_at_its_cut_off(capsys):
    found = mcsim.allan.curves("BNO055", axis="x", cutoff="0.01 Hz").table
    b = found[found["term"] == "B"].set_index("tau_s")["adev"]
    instability = 0.8039 / 3600.0
    for tau, value in b.items():
        expected = instability * math.sqrt(terms.flicker_variance(np.array([tau]), 0.01)[0])
        assert value == pytest.approx(expected, rel=1e-9)
    assert b.iloc[0] < 1e-3 * b.iloc[-1]
    assert exit_code(["allan", "curves", "BNO055", "--cutoff", "0 Hz"]) == 2
    assert exit_code(["allan", "curves", "--cutoff", "1 Hz"]) == 2
    assert "name one" in capsys.readouterr().err


@pytest.mark.slow
def test_recovery_beside_the_printed_errors(monkeypatch):
    """S3 on one sensor: N within the printed 0.31 % (one standard error) times three, B and K
    nowhere near it, all within their fits' intervals."""
    monkeypatch.setattr(allan_recovery, "SENSORS", ("LSM9DS1",))
    found = list(allan_recovery.recovered(seed=5))
    assert [e.term for e in found] == ["N", "B", "K"] * 3
    for entry in found:
        assert entry.printed_error == pytest.approx(0.00315, rel=0.05)
        assert entry.error == pytest.approx(1.0 / math.sqrt(2.0 * (50_400 / entry.tau - 1.0)))
        if entry.term == "N":
            assert abs(entry.off) < 3.0 * entry.printed_error
            assert entry.error == pytest.approx(entry.printed_error, rel=0.05)
    slow = [e for e in found if e.term != "N"]
    assert sum(e.inside_printed for e in slow) <= 2
    assert sum(e.inside_interval for e in found) >= 7


def test_printed_errors_have_a_row_for_each_axis():
    for sensor in allan_recovery.SENSORS:
        printed = allan_recovery.printed_coefficients(sensor)
        assert printed.shape == (3, 3)
        assert {len(allan_recovery.PRINTED_ERRORS[sensor][t]) for t in "NBK"} == {3}
