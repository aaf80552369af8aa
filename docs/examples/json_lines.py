"""A log format of your own: a line of JSON for each sample, the first line for the units.

mcsim --with docs/examples/json_lines.py characterise LOG.jsonl
"""

import json

import mcsim


def recognises(path):
    return path.suffix == ".jsonl"


def columns(path, options):
    """Whatever is wrong with the file may be raised as it comes: it becomes one message."""
    with path.open(encoding="utf-8") as lines:
        units, *rows = map(json.loads, lines)
    values = {name: [row[name] for row in rows] for name in units}
    titles = {name: f"{name} [{unit}]" if unit else name for name, unit in units.items()}
    return mcsim.log_columns(path, {titles[name]: held for name, held in values.items()})


mcsim.add(
    mcsim.LogFormat("json-lines", "log of JSON lines", recognises, columns, endings=(".jsonl",))
)
