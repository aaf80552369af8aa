"""The dialects by name, and which one a text is written in."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable
from dataclasses import dataclass

from mcsim.dialects import gnss_ins_sim, imu_utils, kalibr, kf_gins, matlab, own
from mcsim.dialects.description import Assumptions, Description, Reading
from mcsim.errors import InputError

_COMMENT_WIDTH = 96


@dataclass(frozen=True)
class Dialect:
    """How one tool writes a sensor; ``write`` is None where only reading makes sense."""

    name: str
    title: str
    convention: str
    marks: str
    read: Callable[[str, str, Assumptions], Reading] | None
    write: Callable[[Description, Assumptions], str] | None
    comment: str = "#"


DIALECTS = {
    dialect.name: dialect
    for dialect in (
        Dialect(
            "mcsim",
            "mcsim sensor file",
            own.CONVENTION,
            r"(?m)^(accelerometer|gyroscope)\s*:",
            own.read,
            own.write_si,
        ),
        Dialect(
            "datasheet",
            "mcsim sensor file in a data sheet's units",
            own.CONVENTION,
            "",
            None,
            own.write_data_sheet,
        ),
        Dialect(
            "allan",
            "mcsim sensor file with Allan's N, B and K",
            own.CONVENTION,
            "",
            None,
            own.write_allan,
        ),
        Dialect(
            "kalibr",
            "Kalibr imu.yaml",
            kalibr.CONVENTION,
            r"\b(accelerometer|gyroscope)_noise_density\s*:",
            kalibr.read,
            kalibr.write,
        ),
        Dialect(
            "matlab",
            "MATLAB accelparams and gyroparams",
            matlab.CONVENTION,
            r"\b(accelparams|gyroparams)\s*\(",
            matlab.read,
            matlab.write,
            comment="%",
        ),
        Dialect(
            "gnss-ins-sim",
            "gnss-ins-sim accuracy dictionary",
            gnss_ins_sim.CONVENTION,
            r"['\"]gyro_arw['\"]\s*:",
            gnss_ins_sim.read,
            gnss_ins_sim.write,
        ),
        Dialect(
            "kf-gins",
            "KF-GINS imunoise block",
            kf_gins.CONVENTION,
            r"(?m)^imunoise\s*:",
            kf_gins.read,
            kf_gins.write,
        ),
        Dialect(
            "imu_utils",
            "imu_utils result",
            imu_utils.CONVENTION,
            r"\b(gyr|acc)_n\s*:",
            imu_utils.read,
            None,
        ),
    )
}


def recognise(text: str, source: str) -> Dialect:
    """The dialect that a text is written in.

    Raises
    ------
    InputError
        None, or more than one: ``--from`` decides.
    """
    found = [d for d in DIALECTS.values() if d.marks and re.search(d.marks, text)]
    if len(found) == 1:
        return found[0]
    what = "looks like several dialects" if found else "is in none of the known dialects"
    known = ", ".join(d.name for d in found or DIALECTS.values() if d.read is not None)
    raise InputError(f"{source}: {what}; say which with --from ({known})")


def read_sensor(text: str, source: str, name: str | None, assumptions: Assumptions) -> Reading:
    """Read a sensor in the dialect ``name``, or in the one it is recognised by.

    Raises
    ------
    InputError
        Unknown, not to be read, wrong in itself, or with a question unanswered.
    """
    dialect = DIALECTS[name] if name is not None else recognise(text, source)
    if dialect.read is None:
        raise InputError(f"{dialect.name} is a way to write; read it with --from mcsim")
    return dialect.read(text, source, assumptions)


def write_sensor(sensor: Description, name: str, assumptions: Assumptions) -> str:
    """The sensor in a dialect, its convention spelled out in a comment.

    Raises
    ------
    InputError
        The dialect cannot hold this sensor, or is not to be written.
    """
    dialect = DIALECTS[name]
    if dialect.write is None:
        raise InputError(f"{dialect.name} is not written: its numbers do not say what they are")
    body = dialect.write(sensor, assumptions)
    head = textwrap.wrap(
        f"{dialect.title}: {dialect.convention}.",
        _COMMENT_WIDTH,
        initial_indent=f"{dialect.comment} ",
        subsequent_indent=f"{dialect.comment} ",
    )
    return "\n".join([*head, body])
