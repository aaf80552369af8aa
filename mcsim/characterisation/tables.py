"""Allan deviations and spectra as tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mcsim.characterisation.analysis import Characterisation
from mcsim.characterisation.spectrum import Spectrum, binned

if TYPE_CHECKING:
    import pandas as pd


def allan_table(found: Characterisation) -> pd.DataFrame:
    """Columns channel, tau_s, adev, ci_low, ci_high; m/s² and rad/s, of the log as recorded."""
    import pandas as pd

    return pd.concat(
        pd.DataFrame(
            {
                "channel": result.channel.name,
                "tau_s": np.round(result.curve.tau, 9),
                "adev": result.curve.deviation,
                "ci_low": result.low,
                "ci_high": result.high,
            }
        )
        for result in found.channels
    )


def psd_table(found: Characterisation) -> pd.DataFrame:
    """Columns channel, frequency_hz, and density and floor, SI unit squared per Hz."""
    import pandas as pd

    def table(name: str, spectrum: Spectrum) -> pd.DataFrame:
        frequency, density, floor = binned(spectrum)
        return pd.DataFrame(
            {
                "channel": name,
                "frequency_hz": frequency,
                "psd_one_sided": density,
                "floor_one_sided": floor,
            }
        )

    return pd.concat(table(r.channel.name, r.inspection.spectrum) for r in found.channels)
