"""The correction of an accelerometer from a file: what `mcsim calibrate` writes, or a scenario."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.gum.propagation import Correction
from mcsim.scenario.document import Document, read_document
from mcsim.scenario.validation import validate
from mcsim.systems.velocity.samples import correction_of
from mcsim.systems.velocity.scenario import Calibration, Gravity, Tilt

Array = NDArray[np.float64]

#: The nine quantities of Eq. (4) and (5), in the order of every array.
NAMES = ("lxx", "lxy", "lxz", "lzx", "lzy", "lzz", "bx", "by", "bz")
#: Correlations may miss being possible ones by so much: they are written with few digits.
_ROUNDING = 1e-6


@dataclass(frozen=True)
class CorrectionInput:
    """Estimates (9,) and covariance (9, 9) of ``NAMES``; biases in fractions of g.

    ``gravity`` and ``tilt`` are those of a scenario, None where the file says nothing.
    ``mxx`` is the element of M0.
    """

    estimates: Array
    covariance: Array
    mxx: float
    correlated: bool
    gravity: Gravity | None
    tilt: Tilt | None

    @property
    def deviations(self) -> Array:
        """Standard uncertainties (9,)."""
        return np.sqrt(np.diag(self.covariance))

    def row(self, axis: str) -> Correction:
        """Eq. (4) for axis ``x``, Eq. (5) for ``z``."""
        of, u = slice(0, 3) if axis == "x" else slice(3, 6), self.deviations
        return Correction(self.estimates[of], u[of], self.estimates[6:9], u[6:9])

    def with_nonlinearity(self, share: float) -> CorrectionInput:
        """u(lxx) by Eq. (34): the largest non-linearity, a share of full scale, as rectangular."""
        covariance = self.covariance.copy()
        covariance[0, 0] += (share / abs(self.mxx)) ** 2 / 3.0
        return replace(self, covariance=covariance)


def read_correction(path: Path) -> CorrectionInput:
    """Read the block ``calibration`` of a file, and ``correlations`` beside it.

    Raises
    ------
    InputError
        No such file or block, quantities that no sensor has, or impossible correlations.
    """
    document = read_document(path)
    if "calibration" not in document.tree:
        raise InputError(
            f"{path}: calibration: is missing; give the calibration.yaml of `mcsim calibrate`, or "
            "a velocity scenario"
        )
    calibration = _block(document, "calibration", Calibration)
    quantities = [getattr(calibration, name) for name in NAMES]
    u = np.array([q.uncertainty for q in quantities])
    correlation = _correlations(document)
    return CorrectionInput(
        estimates=np.array([q.estimate for q in quantities]),
        covariance=correlation * np.outer(u, u),
        mxx=float(np.linalg.inv(correction_of(calibration)[0])[0, 0]),
        correlated=bool(np.any(correlation != np.eye(len(NAMES)))),
        gravity=_block(document, "gravity", Gravity),
        tilt=_block(document, "tilt", Tilt),
    )


def _block(document: Document, key: str, model: Any) -> Any:
    """A validated block of the file; None where it is not there."""
    held = document.tree.get(key)
    if held is None:
        return None
    if not isinstance(held, dict):
        raise InputError(f"{document.place((key,))}: {key}: a block of keys is needed here")
    lines = {path[1:]: line for path, line in document.lines.items() if path[:1] == (key,)}
    return validate(Document(held, document.source, lines), model)


def _correlations(document: Document) -> Array:
    """Correlation matrix (9, 9) from ``correlations: [[lxx, bx, -0.4], …]``."""
    found = np.eye(len(NAMES))
    place = f"{document.place(('correlations',))}: correlations"
    for item in document.tree.get("correlations") or ():
        if not (
            isinstance(item, list)
            and len(item) == 3
            and all(name in NAMES for name in item[:2])
            and item[0] != item[1]
            and isinstance(item[2], int | float)
            and abs(item[2]) <= 1.0
        ):
            raise InputError(
                f"{place}: {item}: write two different names of {', '.join(NAMES)} and a number "
                "between -1 and 1, for example [lxx, bx, -0.4]"
            )
        i, j = NAMES.index(item[0]), NAMES.index(item[1])
        found[i, j] = found[j, i] = float(item[2])
    if np.linalg.eigvalsh(found).min() < -_ROUNDING:
        raise InputError(f"{place}: no quantities can be correlated like this all together")
    return found
