"""Decides which files of a site are secrets: by their content, never by their mode."""
from __future__ import annotations

from typing import FrozenSet, Tuple

import yaml

#: The first bytes of files without secrets: maps of robots and pictures.
_KNOWN = (b'2D-Map', b'\x89PNG\r\n', b'P5', b'P2')
#: The keys of YAML files without secrets: graph, fleet file, site file, and ROS map.
_DOCUMENTS: Tuple[FrozenSet[str], ...] = tuple(map(frozenset, (
    ('vertices', 'edges'), ('robots', 'robot_types'), ('name', 'arguments'),
    ('image', 'resolution'))))
_CERTIFICATE, _PRIVATE = b'-----BEGIN CERTIFICATE-----', b'PRIVATE KEY-----'
_WORDS = ('password', 'passwd', 'token', 'secret')


def is_secret(content: bytes) -> bool:
    """Returns True for every file, except for the kinds that are known to have no secrets."""
    if content.startswith(_KNOWN):
        return False
    if content.lstrip().startswith(_CERTIFICATE):
        return _PRIVATE in content
    try:
        document = yaml.load(content, Loader=yaml.CSafeLoader)
    except (yaml.YAMLError, UnicodeDecodeError):
        return True
    if not isinstance(document, dict) or not all(isinstance(key, str) for key in document):
        return True
    if any(word in key.lower() for key in document for word in _WORDS):
        return True
    return not any(keys <= {key.lower() for key in document} for keys in _DOCUMENTS)
