"""A noise dialect of your own: the sheet of a laboratory, a name and a number in each line.

mcsim --with docs/examples/lab_sheet.py convert SENSOR --to lab-sheet
"""

import mcsim
from mcsim import InputError, Term

# Name in the sheet, element, key of mcsim's, unit; and how a list of all tools shows it.
TERMS = (
    Term("ARW", "gyroscope", "angle_random_walk", "°/√h", "the sheet", "°/√h, two-sided"),
    Term("VRW", "accelerometer", "velocity_random_walk", "m/s/√h", "the sheet", "m/s/√h"),
)


def lines_of(text):
    plain = (line.partition("#")[0].split(maxsplit=1) for line in text.splitlines())
    return dict(pair for pair in plain if len(pair) == 2)


def recognises(text):
    return set(lines_of(text)) >= {term.name for term in TERMS}


def read(text, source, assumptions):
    held, elements = lines_of(text), {}
    for term in TERMS:
        try:
            elements[term.element] = {term.key: (float(held[term.name]) * term.si,)}
        except (KeyError, ValueError):
            raise InputError(f"{source}: needs a line such as `{term.name} 0.2`") from None
    return mcsim.Reading(mcsim.Description(held.get("SENSOR"), None, elements))


def write(sensor, assumptions):
    lines = [f"SENSOR {sensor.name}"] if sensor.name else []
    for term in TERMS:
        # Allan's N, be it given as such or as a one-sided density.
        values = mcsim.two_sided(sensor.elements.get(term.element, {}), term.element)
        if values is None:
            raise InputError(f"the sheet needs the white noise of the {term.element}")
        lines.append(f"{term.name} {assumptions.one(values, term.key) / term.si!r}")
    # What the sheet has no words for is said.
    carried = ["noise_density", *(term.key for term in TERMS)]
    return "\n".join([*mcsim.without_words(sensor, carried), *lines]) + "\n"


mcsim.add(
    mcsim.Dialect(
        "lab-sheet",
        "sheet of the laboratory",
        "ARW and VRW are Allan's N, two-sided: N² fs",
        recognises,
        read,
        write,
        terms=TERMS,
        ending=".sheet",
    )
)
