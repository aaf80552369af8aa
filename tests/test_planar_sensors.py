"""Table 1 of the planar paper beside the catalogue."""

from dataclasses import replace

import pytest

import mcsim
from mcsim.papers import planar_sensors
from mcsim.papers.planar_sensors import PRINTED, entries, verdict


def test_the_catalogue_holds_the_printed_table():
    found = list(entries())
    assert [e.sensor for e in found] == [name for name, of in PRINTED.items() for _ in of]
    assert all(e.agrees for e in found)
    assert verdict(found) == "All 6 elements of the catalogue agree with the print in every digit."


@pytest.mark.parametrize(
    "slip", [{"density": 2.2e-2 * 1.05}, {"largest": 80.0}, {"rate": 1344.0}, {"density": None}]
)
def test_a_slip_of_the_catalogue_is_named(slip):
    first, *rest = entries()
    assert verdict([replace(first, **slip), *rest]).endswith("differs from the print in LIS3DH "
                                                            "(accelerometer).")  # fmt: skip


def test_powers_of_ten_are_those_of_the_paper_s_base_parameters():
    """The text prints the base densities as 2.2e-3 and 3.0e-2, exponents lost there as well."""
    table = mcsim.table("planar-sensors").tables["planar-sensors"].set_index(["type", "element"])
    densities = table["noise density"]
    assert densities["LSM330DL", "accelerometer"] == 2.2e-3
    assert densities["LSM330DL", "gyroscope"] == 3.0e-2
    assert list(table["power of ten restored"].dropna()) == [-3, -3, -2, -2, -1]
    assert densities.isna().sum() == 1


def test_derived_columns_have_the_conventions_of_convert():
    """N is two-sided, and a sample's deviation is ND √(fs / 2)."""
    found = {(e.sensor, e.element): e for e in entries()}
    gyroscope = found["LSM330DL", "gyroscope"]
    assert gyroscope.walk == pytest.approx(0.03 * 60.0 / 2.0**0.5)
    assert gyroscope.sample == pytest.approx(0.03 * 50.0**0.5)
    assert "1.27" in mcsim.table("planar-sensors").text
    assert found["LIS33DE", "accelerometer"].walk is None


def test_what_the_scan_lost_is_said():
    text = planar_sensors.sensor_table().text
    assert "2.2·10^[-3] m/s²/√Hz" in text
    assert "224 µg/√Hz" in text
    assert "not specified" in text
