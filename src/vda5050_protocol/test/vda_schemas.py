"""The official JSON schemas of the standard, for the tests.

scripts/test.sh provides them (`provide_vda5050_schemas`). VDA5050_SCHEMAS names a folder with
other schemas: one folder per version, with the files of the standard's folder json_schemas.
"""
from __future__ import annotations

import json
import os
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, Iterator, Optional, Tuple

import pytest
from jsonschema import Draft7Validator
from vda_messages import ROOT

_FOLDERS = (ROOT / 'build' / 'vda5050_schemas', Path(os.environ.get('VDA5050_SCHEMAS', '/nowhere')))


@lru_cache(maxsize=None)
def _schema(version: str, topic: str) -> Optional[Dict[str, Any]]:
    folder = next((place / version for place in _FOLDERS if (place / version).is_dir()), None)
    if folder is None:
        pytest.skip(f'the JSON schemas of {version} are neither in {_FOLDERS[0]} (scripts/test.sh '
                    'gets them from PyPI and GitHub, if it can) nor in VDA5050_SCHEMAS')
    file = next(folder.glob(f'{topic}.*'), None)
    return None if file is None else json.loads(file.read_text(encoding='utf-8'))


def validator(version: str, topic: str) -> Optional[Draft7Validator]:
    """Returns the validator of a topic's messages; None if the version has no schema for it.

    The schemas of 3.0 name a later draft, but use only keywords of draft 7.
    """
    schema = _schema(version, topic)
    if schema is None:
        return None
    Draft7Validator.check_schema(schema)
    return Draft7Validator(schema)


def problems(version: str, topic: str, message: Dict[str, Any]) -> Tuple[str, ...]:
    """Returns the errors of a message, and its keys that the schema does not have."""
    schema, found = _schema(version, topic), validator(version, topic)
    if schema is None or found is None:
        return ()
    return (*(error.message for error in found.iter_errors(message)),
            *(f'{path}: the schema of {version} has no such key'
              for path in _unknown(message, schema, schema, '')))


def paths(version: str, topic: str) -> Iterator[str]:
    """Yields the paths of all fields of a message, such as `nodes.nodePosition.theta`."""
    schema = _schema(version, topic)
    if schema is not None:
        yield from _paths(schema, schema, '')


def _resolved(schema: Dict[str, Any], root: Dict[str, Any]) -> Dict[str, Any]:
    while '$ref' in schema:
        target: Any = root
        for part in schema['$ref'].lstrip('#/').split('/'):
            target = target[part]
        schema = target
    return schema


def _paths(schema: Dict[str, Any], root: Dict[str, Any], path: str) -> Iterator[str]:
    schema = _resolved(schema, root)
    if 'items' in schema:
        yield from _paths(schema['items'], root, path)
    for key, inner in schema.get('properties', {}).items():
        here = f'{path}.{key}' if path else key
        yield here
        yield from _paths(inner, root, here)


def _unknown(value: Any, schema: Dict[str, Any], root: Dict[str, Any], path: str) -> Iterator[str]:
    schema = _resolved(schema, root)
    if isinstance(value, list):
        for item in value:
            yield from _unknown(item, schema.get('items', {}), root, path)
    elif isinstance(value, dict) and 'properties' in schema:
        for key, item in value.items():
            here = f'{path}.{key}' if path else key
            if key not in schema['properties']:
                yield here
            else:
                yield from _unknown(item, schema['properties'][key], root, here)
