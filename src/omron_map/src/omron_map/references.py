"""Finds the uses of an object's name in other metadata lines, so that an edit can change them."""
from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Sequence

from omron_map.errors import FieldError
from omron_map.tokens import Token, tokenise

#: Lines that may contain an object's name: task arguments, routes, parameters, macros.
_GROUPS = frozenset(('cairninfo:', 'routeinfo:', 'schedinfo:', 'schedtaskinfo:', 'taskinfo:',
                     'macroinfo:'))
#: Lines in which the word after these two words is always an object's name.
_OWNED = frozenset((('cairninfo:', 'params'), ('cairninfo:', 'groupmember')))
_ROUTED = frozenset((('routeinfo:', 'goalafter'), ('routeinfo:', 'goalbefore')))


@dataclass(frozen=True)
class Reference:
    """A word of a metadata line that names an object, or may name one.

    owned   -- the line has parameters of the object, and is removed together with it
    certain -- the word is certainly an object's name
    """

    token: Token
    owned: bool
    certain: bool


def may_name_objects(keyword: str) -> bool:
    """Returns whether a line with this first word (lower case) may name an object."""
    return keyword in _GROUPS


def find_references(keyword: str, line: str, name: Optional[str] = None) -> List[Reference]:
    """Returns the words of `line` that name the object `name`.

    Without `name` it returns all words that certainly name an object. `keyword` is the line's first
    word in lower case. A line that cannot be split into words has no references. A number without
    quotes counts as a name only at a place where the line must have a name.
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
