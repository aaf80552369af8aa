"""Ready parameters: Kalibr's imu.yaml and the results of imu_utils."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from mcsim.errors import InputError
from mcsim.logs.model import ACCELEROMETER, AXES, GYROSCOPE

ENDINGS = (".yaml", ".yml")
#: The Allan deviation's floor is this multiple of B: √(2 ln 2 / π).
FLOOR = 0.664

NoiseConvention = Literal["continuous", "discrete"]
WalkConvention = Literal["allan-minimum", "random-walk", "ignore"]

_KALIBR = {
    "accelerometer_noise_density": (ACCELEROMETER, "N"),
    "accelerometer_random_walk": (ACCELEROMETER, "K"),
    "gyroscope_noise_density": (GYROSCOPE, "N"),
    "gyroscope_random_walk": (GYROSCOPE, "K"),
}
_IMU_UTILS = {"Acc": (ACCELEROMETER, "acc"), "Gyr": (GYROSCOPE, "gyr")}


@dataclass(frozen=True)
class Parameters:
    """Coefficients in SI units: element to axis (``""`` for all) to N, B, K."""

    kind: str
    values: Mapping[str, Mapping[str, Mapping[str, float]]]
    rate: float | None
    notes: tuple[str, ...]


def read_parameters(
    path: Path,
    rate: float | None = None,
    noise: NoiseConvention | None = None,
    walk: WalkConvention | None = None,
) -> Parameters:
    """Read a file of ready parameters.

    ``noise`` says what the ``*_n`` of imu_utils are: ``continuous`` (Allan's N) or
    ``discrete`` (N √rate; needs ``rate``).  ``walk`` says what its ``*_w`` are: the
    minimum of the Allan deviation (0.664 B), Kalibr's random walk K, or to be ignored.

    Raises
    ------
    InputError
        Neither kind of file, a value that is no positive number, or a convention that
        the file does not tell and nobody stated.
    """
    data = _load(path)
    if set(data) & set(_IMU_UTILS):
        return _imu_utils(path, data, rate, noise, walk)
    if len(data) == 1 and isinstance(next(iter(data.values())), dict):
        data = next(iter(data.values()))  # the block imu0 of some versions
    if set(data) & set(_KALIBR):
        return _kalibr(path, data)
    raise InputError(
        f"{path}: neither Kalibr's imu.yaml (accelerometer_noise_density …) nor a result of "
        "imu_utils (Gyr: …, Acc: …)"
    )


def _load(path: Path) -> dict[str, Any]:
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise InputError(f"{path}: cannot be read ({reason})") from None
    if text.startswith("%YAML:"):  # OpenCV's header, which is no YAML
        text = text.partition("\n")[2]
    try:
        data = YAML(typ="safe", pure=True).load(text)
    except YAMLError as error:
        raise InputError(f"{path}: not YAML ({str(error).splitlines()[0]})") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: is empty or no mapping")
    return data


def _kalibr(path: Path, data: Mapping[str, Any]) -> Parameters:
    values: dict[str, dict[str, dict[str, float]]] = {}
    for key, (element, term) in _KALIBR.items():
        if key in data:
            values.setdefault(element, {}).setdefault("", {})[term] = _number(path, key, data[key])
    rate = data.get("update_rate")
    return Parameters(
        "Kalibr imu.yaml",
        values,
        None if rate is None else _number(path, "update_rate", rate),
        ("Kalibr's noise density is Allan's N (two-sided), its random walk is Allan's K",),
    )


def _imu_utils(
    path: Path,
    data: Mapping[str, Any],
    rate: float | None,
    noise: NoiseConvention | None,
    walk: WalkConvention | None,
) -> Parameters:
    if noise is None or walk is None:
        missing = [
            "--noise-convention continuous|discrete (is *_n Allan's N, or N √rate?)" * (not noise),
            "--walk-convention allan-minimum|random-walk|ignore (is *_w the minimum of the "
            "Allan deviation, or Allan's K?)" * (not walk),
        ]
        raise InputError(
            f"{path}: a result of imu_utils, whose versions mean different things; state "
            + " and ".join(filter(None, missing))
        )
    if noise == "discrete" and rate is None:
        raise InputError(f"{path}: --noise-convention discrete needs the sampling rate: --rate 200")
    scale = 1.0 if noise == "continuous" or rate is None else rate**-0.5
    values: dict[str, dict[str, dict[str, float]]] = {}
    for block, (element, prefix) in _IMU_UTILS.items():
        for axis in ("", *AXES):
            part = (data.get(block) or {}).get(f"{axis or 'avg'}-axis")
            if not isinstance(part, dict):
                continue
            found = {"N": scale * _number(path, f"{prefix}_n", part.get(f"{prefix}_n"))}
            if walk != "ignore":
                w = _number(path, f"{prefix}_w", part.get(f"{prefix}_w"))
                found |= {"B": w / FLOOR} if walk == "allan-minimum" else {"K": w}
            values.setdefault(element, {})[axis] = found
    if not values:
        raise InputError(f"{path}: holds no avg-axis, x-axis, y-axis or z-axis")
    return Parameters(
        "imu_utils result",
        values,
        rate,
        (f"*_n taken as {noise}, *_w as {walk}, as stated on the command line",),
    )


def _number(path: Path, key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 1e9:
        raise InputError(f"{path}: {key}: a positive number is needed, not {value!r}")
    return float(value)
