"""Functions for all strict readers of this package's files: known keys, known words, names."""
from __future__ import annotations

import difflib
from enum import Enum
from typing import Callable, Collection, Dict, List, Sequence, Type, TypeVar

import yaml

from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import Field, WrongYaml

Word = TypeVar('Word', bound=Enum)
Entry = TypeVar('Entry')
ReadEntry = Callable[[str, yaml.Node, Dict[str, yaml.Node]], Entry]
"""Reads a named element of a list. The arguments are its name, its node and its fields."""


def meant(word: str, known: Collection[str]) -> str:
    """Returns a hint about an unknown word: the nearest of the known words, or all of them."""
    near = difflib.get_close_matches(word, known, 1)
    return f'did you mean {near[0]}?' if near else f'there are: {", ".join(known) or "none"}'


def known_fields(node: yaml.Node, what: str, known: Sequence[str]) -> Dict[str, yaml.Node]:
    """Returns the fields of a mapping. Raises WrongYaml for a key that is not known."""
    fields = strict_yaml.mapping(node, what, known)
    for key in fields:
        if key not in known:
            raise WrongYaml(f'{what} has an unknown key {key!r}; {meant(key, known)}', fields[key])
    return fields


def word(fields: Dict[str, yaml.Node], name: str, kind: Type[Word], default: Word) -> Word:
    """Returns the member of an enum that a field names in small letters. Raises WrongYaml."""
    if name not in fields:
        return default
    text = strict_yaml.text((name, fields[name]))
    words = {member.name.lower(): member for member in kind}
    if text not in words:
        raise WrongYaml(f'{name} is {text!r}; {meant(text, words)}', fields[name])
    return words[text]


def optional_items(fields: Dict[str, yaml.Node], name: str) -> Sequence[yaml.Node]:
    """Returns the elements of a list; none if the field is missing."""
    return strict_yaml.items((name, fields[name])) if name in fields else ()


def named(field: Field, what: str, read: ReadEntry[Entry],
          name_of: str = 'name') -> Dict[str, Entry]:
    """Returns the elements of a list, by their names. Raises WrongYaml for a name that occurs
    twice.

    name_of -- the field that names an element without a `name`
    """
    found: Dict[str, Entry] = {}
    lines: Dict[str, int] = {}
    elements: List[yaml.Node] = strict_yaml.items(field)
    for node in elements:
        fields = strict_yaml.mapping(node, f'an entry of {field[0]}')
        given = 'name' if 'name' in fields else name_of
        name = strict_yaml.text(strict_yaml.field(fields, given, node))
        if not name.strip() or not name.isprintable():
            raise WrongYaml(f'{what} {name!r} needs a name that can be read', fields[given])
        if name in found:
            raise WrongYaml(f'{what} {name} occurs twice, first in line {lines[name]}', node)
        found[name] = read(name, node, fields)
        lines[name] = strict_yaml.line_of(node)
    return found
