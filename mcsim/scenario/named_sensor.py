"""Sensors in scenarios: a built-in sensor's name, a sensor file, or a block."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator

from mcsim.scenario.sensor_block import AccelerometerErrors, named
from mcsim.scenario.sensor_file import file_element


def named_element(element: str) -> BeforeValidator:
    """Accept the name of a sensor or of its file for the block of ``element``."""
    return named(element, file_element)


NamedAccelerometer = Annotated[AccelerometerErrors, named_element("accelerometer")]
