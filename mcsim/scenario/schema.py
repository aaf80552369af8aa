"""The JSON schema (draft 7) of scenario files, for editors."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from mcsim import catalogue
from mcsim.scenario.model import PlanarScenario, Range

SCHEMA_DRAFT = "http://json-schema.org/draft-07/schema#"


def scenario_schema() -> dict[str, Any]:
    """The schema that ``mcsim schema`` prints; emitted from the models."""
    schema = _schema_of(PlanarScenario)
    definitions = schema.pop("$defs")
    definitions["Range"] = _schema_of(Range)
    schema["properties"]["sweep"] = {
        "type": "object",
        "description": "Values of any scalar, by its dotted path: a list, or a range.",
        "additionalProperties": {
            "oneOf": [
                {
                    "type": "array",
                    "minItems": 1,
                    "items": {"type": ["string", "number", "boolean"]},
                },
                {"$ref": "#/definitions/Range"},
            ]
        },
    }
    for name, element in (("Accelerometer", "accelerometer"), ("Gyroscope", "gyroscope")):
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
        **{key: value for key, value in schema.items() if key != "title"},
        "definitions": _without_discriminators(definitions),
    }


def _schema_of(model: type[BaseModel]) -> dict[str, Any]:
    """Pydantic's schema of a model, with references as draft 7 writes them."""
    return model.model_json_schema(by_alias=True, ref_template="#/definitions/{model}")


def _without_discriminators(node: Any) -> Any:
    """Drop OpenAPI's ``discriminator``, which draft 7 does not know."""
    if isinstance(node, dict):
        return {k: _without_discriminators(v) for k, v in node.items() if k != "discriminator"}
    if isinstance(node, list):
        return [_without_discriminators(item) for item in node]
    return node
