"""Sensors in scenarios: a built-in sensor's name, a sensor file, or a block."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BeforeValidator

from mcsim import catalogue
from mcsim.scenario.fields import reject
from mcsim.scenario.sensor_block import AccelerometerErrors, is_file, named
from mcsim.scenario.sensor_file import file_element


def named_element(element: str) -> BeforeValidator:
    """Accept the name of a sensor or of its file for the block of ``element``."""
    return named(element, file_element)


NamedAccelerometer = Annotated[AccelerometerErrors, named_element("accelerometer")]


def passes_constants(block: AccelerometerErrors) -> AccelerometerErrors:
    """Refuse a sensor that reads no constant acceleration: nothing can be reckoned from it."""
    if block.model is None or is_file(block.model):
        return block
    sensor = catalogue.find(block.model)
    if sensor.ac_coupled("accelerometer"):
        raise reject(
            f"{sensor.name} is AC-coupled: it passes no constant acceleration, which dead "
            "reckoning needs; use it in a vibration scenario, or name another sensor"
        )
    return block


ReckoningAccelerometer = Annotated[NamedAccelerometer, AfterValidator(passes_constants)]
