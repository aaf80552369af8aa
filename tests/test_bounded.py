"""Options within bounds: what a message advises is accepted when it is followed."""

import re

import pytest

from mcsim import InputError
from mcsim.api.bounded import between, not_negative, positive
from mcsim.units import KINDS


def duration(text):
    return between("--duration", text, KINDS["time"], ("1 s", "1 h"), "20 s")


def accuracy(text):
    return between("--accuracy", text, KINDS["ratio"], ("0.5 %", "50 %"), "10 %")


def rate(text):
    return positive("--rate", text, KINDS["frequency"])


def gravity_uncertainty(text):
    return not_negative("--gravity-uncertainty", text, KINDS["acceleration"])


@pytest.mark.parametrize(
    ("option", "text", "advice"),
    [
        (duration, "5", "5 s"),
        (duration, "-5", "20 s"),
        (duration, "5 m", "20 s"),
        (accuracy, "5", "5 %"),
        (accuracy, "-5", "10 %"),
        (rate, "0", "100 Hz"),
        (gravity_uncertainty, "-1", "0.01 m/s²"),
    ],
)
def test_advice_is_accepted(option, text, advice):
    with pytest.raises(InputError, match=f'for example "{re.escape(advice)}"'):
        option(text)
    assert option(advice) >= 0.0


@pytest.mark.parametrize(
    ("option", "text", "message"),
    [
        (duration, "2 h", '--duration: "2 h" must lie between 1 s and 1 h'),
        (accuracy, "-5 %", "must lie between 0.5 % and 50 %"),
        (rate, "0 Hz", "must be above zero"),
        (gravity_uncertainty, "-1 m/s²", "must not be negative"),
    ],
)
def test_what_lies_outside_is_refused(option, text, message):
    with pytest.raises(InputError, match=message):
        option(text)
    assert duration("1 h") == 3600.0
