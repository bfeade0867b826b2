"""The types of map objects in the map's `MapInfo:` lines, and the objects' parameters.

`MapInfo: <meta type> Name=<type> Label=... Desc=...` declares a type. A line
`MapInfo: ArgDesc Name=... Parent=<type> Type=... Priority=... Desc=...` declares one of its
parameters. `CairnInfo: Params "<object>" <value>...` has the values of one object, in the order of
the declarations.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Dict, Iterator, List

from omron_map import MapDocument
from omron_map.errors import FieldError
from omron_map.tokens import tokenise

META_TYPES = ('GoalType', 'DockType', 'LocationType', 'BoundaryType', 'SectorType')
_WITH_HEADING = 'WithHeading'


@dataclass(frozen=True)
class ObjectType:
    """A type of map objects; a type that is not declared has no label and no description."""

    name: str
    meta: str
    label: str = ''
    description: str = ''


@dataclass(frozen=True)
class TypeArgument:
    """A parameter of the objects of one type."""

    name: str
    type: str
    importance: str
    description: str


BUILT_IN = (    # types that a map need not declare, including the LD-90's dock
    ObjectType('Goal', 'GoalType'), ObjectType('DockLynx', 'DockType'),
    ObjectType('RobotHome', 'LocationType'), ObjectType('ForbiddenArea', 'SectorType'),
    ObjectType('ForbiddenLine', 'BoundaryType'),
)
UNKNOWN = ObjectType('', 'SectorType')      # stands for a type that is not declared


def object_types(document: MapDocument) -> List[ObjectType]:
    """Returns the built-in, declared and used types, by name."""
    types = {known.name: known for known in BUILT_IN}
    for words in _lines(document, 'mapinfo:'):
        pairs = _pairs(words)
        if words[0] in META_TYPES and 'Name' in pairs:
            name = pairs['Name']
            types[name] = ObjectType(name, words[0], pairs.get('Label', ''), pairs.get('Desc', ''))
    for kind in ('GoalWithHeading', *(obj.kind for obj in document.objects)):
        plain = kind[:-len(_WITH_HEADING)] if kind.endswith(_WITH_HEADING) else kind
        types.setdefault(kind, replace(types.get(plain, UNKNOWN), name=kind))
    return sorted(types.values(), key=lambda known: known.name.lower())


def arguments(document: MapDocument, kind: str) -> List[TypeArgument]:
    """Returns the parameters of a type's objects."""
    described = (_pairs(words) for words in _lines(document, 'mapinfo:') if words[0] == 'ArgDesc')
    return [TypeArgument(pairs.get('Name', ''), pairs.get('Type', ''), pairs.get('Priority', ''),
                         pairs.get('Desc', ''))
            for pairs in described if pairs.get('Parent') == kind]


def parameters(document: MapDocument, name: str) -> List[str]:
    """Returns the parameter values that the map has for the object `name`."""
    for words in _lines(document, 'cairninfo:'):
        if words[0] == 'Params' and words[1:2] and words[1].lower() == name.lower():
            return words[2:]
    return []


def _lines(document: MapDocument, keyword: str) -> Iterator[List[str]]:
    for record in document.records:
        if record.keyword == keyword:
            try:
                words = [token.text for token in tokenise(record.text)[1:]]
            except FieldError:
                continue        # the map's own warnings report such a line
            if words:
                yield words


def _pairs(words: List[str]) -> Dict[str, str]:
    return {key: value for key, equals, value in (word.partition('=') for word in words) if equals}
