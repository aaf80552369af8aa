"""Sensors in scenarios: a built-in sensor's name, a sensor file, or a block."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, ValidationInfo

from mcsim import catalogue
from mcsim.scenario.fields import reject
from mcsim.scenario.sensor_block import AccelerometerErrors, is_file, named
from mcsim.scenario.sensor_file import built_in_of_file, file_element


def named_element(element: str) -> BeforeValidator:
    """Accept the name of a sensor or of its file for the block of ``element``."""
    return named(element, file_element)


def _knows_its_kind(block: AccelerometerErrors, info: ValidationInfo) -> AccelerometerErrors:
    """Keep which built-in sensor the block is made from, by name or by a sensor file."""
    if block.model is not None:
        folder = (info.context or {}).get("folder", Path())
        block.made_from(
            built_in_of_file(folder / block.model, "accelerometer")
            if is_file(block.model)
            else catalogue.find(block.model)
        )
    return block


def _passes_constants(block: AccelerometerErrors) -> AccelerometerErrors:
    """Refuse a sensor that reads no constant acceleration: nothing can be reckoned from it."""
    sensor = block.built_in
    if sensor is not None and sensor.ac_coupled("accelerometer"):
        raise reject(
            f"{sensor.name} is AC-coupled: it passes no constant acceleration, which dead "
            "reckoning needs; use it in a vibration scenario, or name another sensor"
        )
    return block


#: What an accelerometer's block goes through after its values.
KIND = AfterValidator(_knows_its_kind)
CONSTANTS = AfterValidator(_passes_constants)

NamedAccelerometer = Annotated[AccelerometerErrors, named_element("accelerometer"), KIND]
ReckoningAccelerometer = Annotated[NamedAccelerometer, CONSTANTS]
