"""What holds of every search result's JSON."""

import json

import jsonschema

from kneecore import Knee, SearchResult
from kneecore._assets import asset_path

SCHEMA = json.loads(asset_path("result.schema.json").read_text(encoding="utf-8"))


def _keys(kind):
    return {*SCHEMA["properties"], *SCHEMA["$defs"][kind]["properties"]}


KNEE_KEYS, MODEL_KEYS = _keys("of_knees"), _keys("of_any_model")
"""All keys of a result of knees, and of one of any other model."""
ONLY_IF_ASKED_FOR = {"half_step_change_deg"}


def check_comes_back(result):
    """Check a result's JSON against the schema and its way back; return it parsed."""
    text = result.to_json()
    document = json.loads(text)
    jsonschema.validate(document, SCHEMA)
    keys = KNEE_KEYS if isinstance(result.model, Knee) else MODEL_KEYS
    assert set(document) - keys == set()
    assert keys - set(document) - ONLY_IF_ASKED_FOR == set()
    again = SearchResult.from_json(text)
    assert again.to_json() == text
    assert str(again) == str(result)
    return document


def older(document):
    """Return a document as an earlier version wrote it: without a digest."""
    document = {key: value for key, value in document.items() if key != "digest"}
    return document | {"versions": document["versions"] | {"kneecore": "0.1"}}
