"""The JSON schema (draft 7) of scenario files, for editors."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from mcsim import catalogue
from mcsim.scenario.run import Range
from mcsim.systems import SYSTEMS

SCHEMA_DRAFT = "http://json-schema.org/draft-07/schema#"
_SWEEP = {
    "type": "object",
    "description": "Values of any scalar, by its dotted path: a list, or a range.",
    "additionalProperties": {
        "oneOf": [
            {"type": "array", "minItems": 1, "items": {"type": ["string", "number", "boolean"]}},
            {"$ref": "#/definitions/Range"},
        ]
    },
}


def scenario_schema() -> dict[str, Any]:
    """The schema that ``mcsim schema`` prints; emitted from the models."""
    definitions: dict[str, Any] = {"Range": _schema_of(Range)}
    models = {name: case.scenario for name, case in SYSTEMS.items()}
    for model in models.values():
        schema = _schema_of(model)
        definitions |= schema.pop("$defs")
        schema["properties"]["sweep"] = _SWEEP
        definitions[model.__name__] = schema
    for name, element in (
        ("Accelerometer", "accelerometer"),
        ("AccelerometerErrors", "accelerometer"),
        ("Gyroscope", "gyroscope"),
    ):
        block = definitions[name]
        definitions[name] = {
            "anyOf": [
                {
                    "enum": [s.name for s in catalogue.sensors().values() if element in s.elements],
                    "description": "A sensor of the catalogue",
                },
                block,
            ]
        }
    return {
        "$schema": SCHEMA_DRAFT,
        "title": "mcsim scenario",
        "type": "object",
        "required": ["case"],
        "properties": {"case": {"enum": list(models)}},
        # One branch per case, so that editors check against the case that is named.
        "allOf": [
            {
                "if": {"properties": {"case": {"const": name}}},
                "then": {"$ref": f"#/definitions/{model.__name__}"},
            }
            for name, model in models.items()
        ],
        "definitions": definitions,
    }


def _schema_of(model: type[BaseModel]) -> dict[str, Any]:
    """Pydantic's schema of a model, with references as draft 7 writes them."""
    return model.model_json_schema(by_alias=True, ref_template="#/definitions/{model}")
