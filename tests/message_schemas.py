"""The published schemas of the messages that are JSON."""

import json
from pathlib import Path

from jsonschema import Draft202012Validator

_FOLDER = Path(__file__).parents[1] / 'docs' / 'schemas'


def fits(schema: str, text: str) -> bool:
    """Return whether a text fits the schema of a name."""
    validator = Draft202012Validator(json.loads((_FOLDER / f'{schema}.json').read_text()))
    try:
        return bool(validator.is_valid(json.loads(text)))
    except json.JSONDecodeError:
        return False
