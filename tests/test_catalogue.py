"""The built-in sensors: every value readable, every source named, the tables as printed."""

import math

import pytest

from mcsim import catalogue
from mcsim.scenario.document import parse_document
from mcsim.scenario.sensor_file import SensorFile
from mcsim.scenario.validation import validate
from mcsim.units import KINDS, parse
from tests.conftest import density, scenario

G = 9.80665
KIND_OF = {
    "noise_density": ("acceleration noise density", "angular rate noise density"),
    "noise_density_z": ("acceleration noise density",),
    "velocity_random_walk": ("velocity random walk",),
    "bias_instability": ("acceleration",),
    "acceleration_random_walk": ("acceleration random walk",),
    "range": ("acceleration",),
    "ranges": ("acceleration", "angular rate"),
    "bandwidth": ("frequency",),
    "rate": ("frequency",),
    "zero_g_offset": ("acceleration",),
    "standard_deviation": ("acceleration",),
    "standard_deviation_z": ("acceleration",),
    "static_bias": ("acceleration",),
    "gauss_markov_deviation": ("acceleration",),
    "gauss_markov_correlation_time": ("time",),
}
NOT_QUANTITIES = {"bits", "sensitivity", "nonlinearity", "misalignment"}
NAMED = {
    *("LIS3DH", "LIS33DE", "LSM330DL", "L3G4200D", "CMR3000-D01"),
    *("ADIS16375", "BG2180", "Phidget 1059", "ADXL330"),
    *("MTI-300", "MPU-9250", "LSM9DS1", "BNO055", "LSM303DLHC", "MTN-1100"),
}


def record(name, source, origin):
    found = [
        r
        for r in catalogue.find(name).records["accelerometer"]
        if r.source == source and r.origin == origin
    ]
    assert len(found) == 1
    return found[0]


def axes(values, kind):
    return [parse(value, KINDS[kind]) for value in values]


def test_every_sensor_of_the_sources_is_there():
    assert set(catalogue.sensors()) == NAMED


@pytest.mark.parametrize("name", sorted(NAMED))
def test_what_a_scenario_takes_is_a_valid_block_of_one_value_or_three_per_key(name):
    sensor = catalogue.find(name)
    for element, quantities in sensor.elements.items():
        for value in quantities.values():
            assert isinstance(value, str) or len(value) == 3
        document = parse_document(f"{element}: {name}\n")
        block = getattr(validate(document, SensorFile), element)
        assert set(quantities) < set(type(block).model_fields)


@pytest.mark.parametrize("name", sorted(NAMED))
def test_every_recorded_value_is_a_quantity_with_a_source(name):
    sensor = catalogue.find(name)
    for element in sensor.elements:
        assert sensor.records[element]
        for given in sensor.records[element]:
            assert given.citation
            for key, value in given.quantities.items():
                if key in NOT_QUANTITIES:
                    continue
                position = 1 if element == "gyroscope" else 0
                kind = KINDS[KIND_OF[key][min(position, len(KIND_OF[key]) - 1)]]
                for text in value if isinstance(value, list) else [value]:
                    assert math.isfinite(parse(text, kind))


@pytest.mark.parametrize("name", sorted(NAMED))
def test_origins_are_told_apart(name):
    sensor = catalogue.find(name)
    origins = {r.origin for element in sensor.elements for r in sensor.records[element]}
    assert origins <= {"data sheet", "measured"}
    assert ("measured" in sensor.origin) == ("measured" in origins)


@pytest.mark.parametrize(
    ("name", "density", "bandwidth", "noise"),
    [
        ("MTI-300", "data sheet", 375.0, 1719.6),
        ("MPU-9250", "data sheet", 460.0, 6434.2),
        ("LSM9DS1", "measured", 408.0, 4241.7),
        ("BNO055", "data sheet", 62.5, 1185.8),
        ("LSM303DLHC", "data sheet", 672.0, 5703.0),
    ],
)
def test_noise_column_of_table_5_2_follows_from_density_and_bandwidth(
    name, density, bandwidth, noise
):
    """The printed noise in µg is the density times the root of the bandwidth."""
    values = record(name, "thesis-table-5.2", density).quantities
    sheet = record(name, "thesis-table-5.2", "data sheet").quantities
    assert parse(sheet["bandwidth"], KINDS["frequency"]) == bandwidth
    text = values["noise_density"]
    text = text[0] if isinstance(text, list) else text
    micro_g = parse(text, KINDS["acceleration noise density"]) / G * 1e6
    # The source rounds the density of LSM9DS1 to 210 before it multiplies.
    assert micro_g * math.sqrt(bandwidth) == pytest.approx(noise, rel=5e-4)


@pytest.mark.parametrize(
    ("name", "bandwidth"),
    [("MTI-300", 375.0), ("MPU-9250", 460.0), ("BNO055", 62.5), ("LSM9DS1", 307.0)],
)
def test_measured_densities_are_deviations_over_the_root_of_a_bandwidth(name, bandwidth):
    """Eq. (5.1); LSM9DS1 needs another bandwidth than the 408 Hz printed, as its note says."""
    deviations = axes(
        record(name, "thesis-table-5.1", "measured").quantities["standard_deviation"],
        "acceleration",
    )
    densities = axes(
        record(name, "thesis-table-5.2", "measured").quantities["noise_density"],
        "acceleration noise density",
    )
    for deviation, printed in zip(deviations, densities, strict=True):
        # Deviations are printed with three or four digits.
        assert deviation / math.sqrt(bandwidth) == pytest.approx(printed, rel=1e-2)


@pytest.mark.parametrize(
    ("name", "source", "origin", "words"),
    [
        ("MTN-1100", "thesis-table-5.1", "measured", "0.0001"),
        ("LSM303DLHC", "thesis-tables-5.4-5.6", "measured", "slip"),
        ("MTI-300", "thesis-table-5.2", "data sheet", "150 µg/√Hz in Table 4.2"),
        ("BNO055", "thesis-table-5.2", "data sheet", "190 µg/√Hz in Table 4.2"),
        ("LSM9DS1", "thesis-table-5.2", "measured", "307 Hz"),
    ],
)
def test_contradictions_of_the_source_are_named(name, source, origin, words):
    assert words in record(name, source, origin).note


@pytest.mark.parametrize("name", sorted(NAMED))
def test_what_a_source_says_of_each_axis_a_scenario_takes_of_each(name):
    """B and K of one axis are not another's; one value counts only where a source gives one."""
    sensor = catalogue.find(name)
    for element, taken in sensor.elements.items():
        for key, value in taken.items():
            given = [r.quantities[key] for r in sensor.records[element] if key in r.quantities]
            alike = [g[0] for g in given if isinstance(g, list) and len(set(g)) == 1]
            assert not given or value in [*given, *alike]
    if name == "MTI-300":
        block = sensor.elements["accelerometer"]
        assert block["bias_instability"][2] == "2.7729 m/s/h"
        # Its z value of N, 14 times the other axes', contradicts Table 5.1 and is not taken.
        assert block["noise_density"] == "88.8 µg/√Hz"


def test_scenarios_take_measured_sensors_by_name():
    s = scenario({"sensors.accelerometer": "MPU-9250"})
    assert density(s.base.sensors.accelerometer) == pytest.approx(300e-6 * G)


def test_a_named_sensors_values_yield_to_those_written():
    text = "accelerometer: {model: BNO055, velocity_random_walk: 0.06 m/s/√h, range: 2 g}\n"
    block = validate(parse_document(text), SensorFile).accelerometer
    assert block.noise_density is None
    assert block.velocity_random_walk == (pytest.approx(1e-3),)
    assert block.range == (2 * G,)
    assert block.bandwidth == (62.5,)
