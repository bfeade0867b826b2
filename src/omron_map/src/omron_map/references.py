"""Where an object's name is used in other metadata lines, so that an edit can follow it."""
from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Sequence

from omron_map.errors import FieldError
from omron_map.tokens import Token, tokenise

#: Lines that may name an object at any place: task arguments, routes, parameters, macros.
_GROUPS = frozenset(('cairninfo:', 'routeinfo:', 'schedinfo:', 'schedtaskinfo:', 'taskinfo:',
                     'macroinfo:'))
#: Lines of which it is known that the word after these two is an object's name.
_OWNED = frozenset((('cairninfo:', 'params'), ('cairninfo:', 'groupmember')))
_ROUTED = frozenset((('routeinfo:', 'goalafter'), ('routeinfo:', 'goalbefore')))


@dataclass(frozen=True)
class Reference:
    """A word of a metadata line that names an object, or may name one.

    `owned`: the line belongs to the object (its parameters) and goes with it. `certain`: the word
    can be nothing else than an object's name.
    """

    token: Token
    owned: bool
    certain: bool


def may_name_objects(keyword: str) -> bool:
    """Can a line whose first word, in lower case, is `keyword` name an object?"""
    return keyword in _GROUPS


def find_references(keyword: str, line: str, name: Optional[str] = None) -> List[Reference]:
    """The words of `line` that name the object `name`; without `name`, all that surely name one.

    `keyword` is the line's first word in lower case. A line that cannot be split has none, and a
    bare number is no name, except where nothing else can stand.
    """
    if not may_name_objects(keyword):
        return []
    try:
        words: Sequence[Token] = tokenise(line)
    except FieldError:
        return []
    head = (keyword, words[1].text.lower()) if len(words) > 1 else (keyword, '')
    owned, routed = head in _OWNED, head in _ROUTED
    found = []
    for index, word in enumerate(words[2:], 2):
        certain = index == 2 and (owned or routed)
        if name is None:
            wanted = certain
        else:
            wanted = word.text.lower() == name.lower() and (
                certain or word.quoted or not name.isdigit())
        if wanted:
            found.append(Reference(word, owned and certain, certain))
    return found
