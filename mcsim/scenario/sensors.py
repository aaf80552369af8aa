"""The sensors block: rate, sampling, and the error parameters of the measured channels."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le
from pydantic import model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.fields import Frequency, NotNegative, Positive, Time, reject
from mcsim.scenario.named_sensor import CONSTANTS, KIND, named_element
from mcsim.scenario.sample_times import SampleTimes, refuse_wide
from mcsim.scenario.sensor_block import AccelerometerErrors, GyroscopeErrors, is_file
from mcsim.scenario.temperature import Temperature
from mcsim.sensor_terms import TERMS


class Accelerometer(AccelerometerErrors):
    """The accelerometer axes; a value counts for all of them, or is given as [x, y, z]."""

    @model_validator(mode="after")
    def _noise_given(self) -> Accelerometer:
        if not self.has_noise:
            raise _no_noise(self.model, "accelerometer", "2.2e-3 m/s²/√Hz")
        return self


class Gyroscope(GyroscopeErrors):
    """The gyroscope axes; a value counts for all of them, or is given as [x, y, z]."""

    @model_validator(mode="after")
    def _noise_given(self) -> Gyroscope:
        if not self.has_noise:
            raise _no_noise(self.model, "gyroscope", "0.03 °/s/√Hz")
        return self


def _no_noise(model: str | None, element: str, example: str) -> Exception:
    if model is not None:
        return reject(
            f"{model}: its source gives no noise density; "
            f"write `{element}: {{model: {model}, noise_density: …}}`"
        )
    return reject(f"write `noise_density: {example}` (zero for none), or name a `model`")


class BiasCalibration(Block):
    """Rest in a known attitude, before the run, in which each channel's bias is estimated.

    Nothing tells a bias from what scale factor, misalignment and g-sensitivity make of gravity
    there: the calibration takes all of it away, and they act on what changes afterwards. It is
    taken off the output: the bias still uses up the range, and is quantised.
    """

    duration: Annotated[Time, Positive, Le(1e6)]
    """Time at rest."""
    method: Literal["mean", "kalman"] = "mean"
    """The mean of the samples, or a Kalman filter that knows the sensor's in-run noise. What the
    filter finds of a drift is corrected as it is expected to go on: by the estimate times
    exp(-t/Tc), t after the rest; a constant bias and a random walk by the estimate itself."""


class Sensors(Block):
    """The measured channels: those of acceleration, and those of angular rate."""

    rate: Annotated[Frequency, Positive, Ge(0.1), Le(100_000.0)]
    """Output rate of the sensors."""
    sampling: Literal["fir", "iir", "none", "average"] = "fir"
    """From dense truth to samples: filtered, picked, or averaged over the interval."""
    accelerometer: Annotated[Accelerometer, named_element("accelerometer"), KIND, CONSTANTS]
    gyroscope: Annotated[Gyroscope, named_element("gyroscope")]
    time_jitter: Annotated[Time, NotNegative, Le(1.0)] = 0.0
    """Standard deviation of the instants at which samples are really taken; to first order,
    by the slope between the neighbouring samples. Of the signals alone: the intervals are even;
    `time.interval_jitter` is one that intervals have."""
    time: SampleTimes = SampleTimes()
    """When samples are taken, and what their time stamps say of it."""
    calibration: BiasCalibration | None = None
    """Replaces the constant offsets by what is left after calibrating at rest."""
    temperature: Temperature | None = None
    """Of both elements, less that of their calibration; acts by the terms that go with it."""

    @model_validator(mode="after")
    def _jitter_is_small(self) -> Sensors:
        refuse_wide(self.time_jitter, self.rate, "time_jitter")
        refuse_wide(self.time.interval_jitter, self.rate, "time.interval_jitter")
        refuse_wide(self.time.stamp_jitter, self.rate, "time.stamp_jitter")
        if self.time_jitter and self.time.interval_jitter:
            raise reject(
                "`time_jitter` and `time.interval_jitter` say the same of the signals: keep the "
                "second where intervals are to vary with it, else the first"
            )
        return self

    @model_validator(mode="after")
    def _means_have_no_gaps(self) -> Sensors:
        if self.sampling == "average" and (self.time.lost or self.time.interval_jitter):
            name = "lost" if self.time.lost else "interval_jitter"
            raise reject(
                f"time.{name}: what a mean over an interval holds is lost with its sample, or "
                "belongs to the next one; write `sampling: none`, `fir` or `iir`"
            )
        return self

    @model_validator(mode="after")
    def _filter_knows_no_temperature(self) -> Sensors:
        kalman = self.calibration is not None and self.calibration.method == "kalman"
        if kalman and self.temperature is not None and self.temperature.changes:
            raise reject(
                "the Kalman filter of `calibration` knows no temperature that changes; write "
                "`method: mean`, or a constant `difference`"
            )
        return self

    @property
    def instant_jitter(self) -> float:
        """Standard deviation (s) of the instants at which samples are taken."""
        return self.time_jitter or self.time.interval_jitter

    @property
    def files(self) -> tuple[str, ...]:
        """Files of sensors and of time stamps that the block refers to, as written."""
        models = {self.accelerometer.model, self.gyroscope.model}
        stamps = (self.time.stamps.file,) if self.time.stamps else ()
        return (*sorted(name for name in models if name and is_file(name)), *stamps)

    @model_validator(mode="after")
    def _calibrated_or_assumed(self) -> Sensors:
        if self.calibration is None:
            return self
        for element in (self.accelerometer, self.gyroscope):
            for name in element.assumed_left():
                path, _ = next(TERMS[name].paths(element.ELEMENT))
                raise reject(f"calibration replaces the {name}: remove `{element.ELEMENT}.{path}`")
        return self
