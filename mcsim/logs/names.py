"""What a column's name says that it holds: time, or an axis of which sensor.

Names are taken apart into words (``accelerometer_abc.x``, ``AccX``, ``linearAccelerationX``), the
axis is found, and the rest says the element, the sensor, and what was done to its signal.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import IntEnum

from mcsim.logs.model import ACCELEROMETER, AXES, GYROSCOPE, SHORT
from mcsim.logs.titles import Title, kind_of, shown_unit

TIME = "time"
#: Names of channels as ``--columns`` takes them.
CHANNELS = {f"{short}_{axis}": (element, axis) for element, short in SHORT.items() for axis in AXES}


class Rank(IntEnum):
    """How surely a column is a sensor's own output; the least one of an element is taken."""

    SENSOR = 0
    #: Of the sensor, or of a filter: ROS calls the accelerometer linear_acceleration, phones
    #: call so what a filter leaves of it without gravity.
    DOUBTFUL = 1
    #: Made by a filter, or of something else: taken only when it is named.
    VIRTUAL = 2


@dataclass(frozen=True)
class Meaning:
    """What a column is: ``time`` or a channel's name, how surely, and of which sensor."""

    name: str
    rank: Rank
    sensor: str = ""


_ACCELEROMETER = {
    "a", "acc", "accel", "acceleration", "accelerations", "accelerometer", "accelero",
    "specificforce", "gforce", "gf", "linacc", "linaccel", "linearacceleration", "accsmooth",
}  # fmt: skip
_GYROSCOPE = {
    "g", "w", "gyr", "gyro", "gyros", "gyroscope", "omega", "angvel", "angularvelocity",
    "angularrate", "rotationrate", "rotrate", "turnrate", "bodyrate",
}  # fmt: skip
#: One letter says what a column is only where no other word does.
_LETTERS = {"a": ACCELEROMETER, "g": GYROSCOPE, "w": GYROSCOPE}
#: Two words that mean one.
_PHRASES = (
    ("specific", "force"), ("g", "force"), ("angular", "velocity"), ("ang", "vel"),
    ("angular", "rate"), ("rotation", "rate"), ("rot", "rate"), ("turn", "rate"),
    ("body", "rate"), ("lin", "acc"), ("acc", "smooth"),
)  # fmt: skip
_TURNS = {"roll": "x", "pitch": "y", "yaw": "z"}
_DOUBTFUL = {
    "linear", "lin", "linacc", "linaccel", "linearacceleration", "accsmooth", "raw",
    "uncalibrated", "uncal", "calibrated", "cal", "corrected", "compensated",
}  # fmt: skip
_VIRTUAL = {
    "gravity", "grav", "user", "free", "world", "earth", "global", "enu", "ned", "nav", "filtered",
    "filt", "smooth", "smoothed", "lowpass", "lp", "hp", "highpass", "mean", "avg", "average",
    "median", "est", "estimated", "fused", "abs", "absolute", "magnitude", "norm", "total", "rms",
    "target", "setpoint", "desired", "ref", "reference", "cmd",
}  # fmt: skip
#: With one of these a column holds something else.
_FOREIGN = {
    "mag", "magnetic", "magnetometer", "angle", "orientation", "euler", "attitude", "quat",
    "quaternion", "temp", "temperature", "bias", "offset", "std", "stddev", "var", "variance",
    "cov", "covariance", "scale", "position", "pos", "velocity", "vel", "pressure", "status",
    "delta", "displacement", "jerk", "count", "interval", "dt", "diff",
}  # fmt: skip
_TIME_WORDS = {
    "time", "timestamp", "timestamps", "stamp", "stamps", "times", "t", "ts", "sec", "secs",
    "seconds", "millis", "micros", "nanos", "milliseconds", "microseconds", "nanoseconds", "msec",
    "usec", "nsec", "elapsed", "epoch", "epoc", "clock", "zeit", "temps", "tiempo", "datetime",
    "uhrzeit", "heure", "hora", "uptime", "tow", "itow", "timestartup",
}  # fmt: skip
_PLAIN_TIME = _TIME_WORDS | {
    "since", "start", "of", "s", "ms", "us", "ns", "unix", "utc", "in", "host", "device", "sensor",
    "imu", "system", "sample", "the", "field", "header", "date", "datum", "day", "local",
    "startup", "power", "on", "up", "week", "i",
}  # fmt: skip
_OTHER_TIME = {
    "gps", "gnss", "location", "logging", "ros", "boot", "reboot", "sys", "server", "fine",
    "accelerometer", "acc", "gyro", "gyroscope", "received", "arrival", "seq", "motion",
    "recording",
}  # fmt: skip
_COMPOUND = re.compile(
    rf"(?P<axis1>[xyz])(?P<word1>acc|accel|gyro|gyr)|"
    rf"(?P<word2>{'|'.join(sorted(_ACCELEROMETER | _GYROSCOPE, key=len, reverse=True))})"
    r"(?P<number>\d*)(?P<axis2>[xyz])(?P<last>\d*)"
)


def meaning_of(title: Title) -> Meaning | None:
    """What a column's title says that it holds, or None.

    A bare axis (``x-axis [g]``) takes its element from the unit, and ``gx [g]`` is a force.
    """
    words = _words(title.name)
    if _is_time(words):
        return Meaning(TIME, Rank.SENSOR if set(words) <= _PLAIN_TIME else Rank.DOUBTFUL)
    axis, rest = _axis(words)
    if axis is None or _FOREIGN & set(rest):
        return None
    named, stated = _element(rest), _element_of_unit(title.unit)
    in_g = rest == ["g"] and shown_unit(title.unit) in ("g", "mg")
    element = stated if in_g else named or stated
    if element is None:
        return None
    rank = Rank.SENSOR
    if _VIRTUAL & set(rest):
        rank = Rank.VIRTUAL
    elif _DOUBTFUL & set(rest) or (rest and named is None):
        rank = Rank.DOUBTFUL
    return Meaning(f"{SHORT[element]}_{axis}", rank, " ".join(rest))


def channel_of(name: str) -> str | None:
    """``time``, a channel's name, or None, from a column's name alone."""
    meaning = meaning_of(Title(name, name, ""))
    return meaning.name if meaning is not None and meaning.rank < Rank.VIRTUAL else None


def is_acceleration(name: str) -> bool:
    """Whether a name is that of an acceleration, with an axis or without one."""
    words = _words(name)
    axis, rest = _axis(words)
    rest = words if axis is None else rest
    return not _FOREIGN & set(rest) and _element(rest) == ACCELEROMETER


def _words(name: str) -> list[str]:
    """``linearAccelerationX`` becomes linear, acceleration, x; two words of one meaning join."""
    text = re.sub(r"\[([012])\]\s*$", lambda m: f" {AXES[int(m[1])]}", name)
    text = re.sub(r"gF(?=[xyz])", "gforce ", text)
    text = re.sub(r"m_s_?2(?=\W|_|$)|m/s\^?2|rad_s|deg_s", " ", text)
    text = re.sub(r"([a-z\d])([A-Z])|([A-Z])(?=[A-Z][a-z])", r"\1\3 \2", text)
    text = re.sub(r"(?i)(?<=ometer|oscope)(uncalibrated|calibrated|raw)", r" \1", text)
    words = re.sub(r"[^\w]+|_", " ", text).lower().split()
    for first, second in _PHRASES:
        for i in range(len(words) - 1):
            if words[i] == first and words[i + 1] in (second, *(second + axis for axis in AXES)):
                words[i : i + 2] = [first + words[i + 1]]
                break
    return words


def _is_time(words: list[str]) -> bool:
    held = set(words)
    if words[-1:] == ["timestamp"]:
        return True
    return bool(held & _TIME_WORDS) and held <= _PLAIN_TIME | _OTHER_TIME


def _axis(words: list[str]) -> tuple[str | None, list[str]]:
    """The axis, and the words without it."""
    for i in range(len(words) - 1, -1, -1):
        if words[i] in AXES:
            rest = [w for w in (*words[:i], *words[i + 1 :]) if w not in ("axis", "direction")]
            return words[i], rest
    for i in range(len(words) - 1, -1, -1):
        match = _COMPOUND.fullmatch(words[i])
        if match is not None:
            word = (match["word1"] or match["word2"]) + (match["number"] or match["last"] or "")
            return match["axis1"] or match["axis2"], [*words[:i], word, *words[i + 1 :]]
    for word, axis in _TURNS.items():
        joined = "".join(words)
        if joined in (f"{word}rate", f"{word}speed") or (
            word in words and "rate" in words and len(words) <= 3
        ):
            return axis, ["gyro"]
    return None, words


def _element(rest: list[str]) -> str | None:
    names = [_letters_of(word) for word in rest]
    long = [word for word in names if word not in _LETTERS]
    found = {ACCELEROMETER for word in long if word in _ACCELEROMETER}
    found |= {GYROSCOPE for word in long if word in _GYROSCOPE}
    if not found:
        found = {_LETTERS[word] for word in names if word in _LETTERS}
    return found.pop() if len(found) == 1 else None


def _letters_of(word: str) -> str:
    """A word without the number of the sensor: ``acc1`` is acc."""
    return re.sub(r"\d+$", "", word)


def _element_of_unit(unit: str) -> str | None:
    kind = kind_of(unit) if unit else None
    names = {"acceleration": ACCELEROMETER, "angular rate": GYROSCOPE}
    return names.get(kind.name) if kind is not None else None
