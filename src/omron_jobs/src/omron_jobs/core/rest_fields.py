"""The fields of a JSON object that a client has posted: each is checked before it is used."""
from __future__ import annotations

import json
from typing import Any, Dict, List, Optional

from omron_jobs.core.command_line import LONGEST


class WrongRequest(Exception):
    """A request that is not carried out. The text is a sentence. `status`: HTTP status."""

    def __init__(self, text: str, status: int = 400) -> None:
        super().__init__(text)
        self.status = status


def read_object(body: bytes) -> Dict[str, Any]:
    """Returns the JSON object of a body. Raises WrongRequest."""
    try:
        found = json.loads(body.decode('utf-8'), parse_constant=_refuse_constant)
    except (ValueError, RecursionError):
        raise WrongRequest('The body is no JSON.') from None
    if not isinstance(found, dict):
        raise WrongRequest('The body is no JSON object.')
    return found


def _refuse_constant(name: str) -> None:
    raise ValueError(name)


class Fields:
    """The fields of an object. A field that is null counts as left out.

    known -- the names of the fields that the object may have
    """

    def __init__(self, found: Any, *known: str) -> None:
        """Raises WrongRequest."""
        if not isinstance(found, dict):
            raise WrongRequest('A detail is no JSON object.')
        strange = sorted(set(found) - set(known))
        if strange:
            raise WrongRequest(f'There is no field {strange[0]!a:.40}. The fields are '
                               f'{", ".join(known)}.')
        self._found = {name: value for name, value in found.items() if value is not None}

    def __contains__(self, name: str) -> bool:
        """Whether a field has a value."""
        return name in self._found

    def text(self, name: str) -> str:
        """Returns a text; empty: it was left out. Raises WrongRequest."""
        value = self._found.get(name, '')
        if not isinstance(value, str) or len(value) > LONGEST or not value.isprintable():
            raise WrongRequest(f'{name} must be a text of at most {LONGEST} characters that print.')
        return value

    def word(self, name: str) -> str:
        """Returns an id that fits into a line of ARCL; empty: none. Raises WrongRequest."""
        value = self.text(name)
        if '"' in value or len(value.split()) > 1 or value != value.strip():
            raise WrongRequest(f'{name} must have no blanks and no quotation marks.')
        return value

    def needed(self, name: str) -> str:
        """Returns a text that is not empty. Raises WrongRequest."""
        value = self.text(name)
        if not value:
            raise WrongRequest(f'{name} is missing.')
        return value

    def reason(self, name: str) -> str:
        """Returns a reason for a line of ARCL: with underscores instead of blanks."""
        value = '_'.join(self.text(name).split())
        if '"' in value:
            raise WrongRequest(f'{name} must have no quotation marks.')
        return value

    def number(self, name: str) -> Optional[int]:
        """Returns an integer of 32 bits; None: it was left out. Raises WrongRequest."""
        value = self._found.get(name)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, int) or not (
                -2 ** 31 <= value < 2 ** 31):
            raise WrongRequest(f'{name} must be a whole number of 32 bits.')
        return value

    def flag(self, name: str) -> bool:
        """Returns whether a field is true. Raises WrongRequest."""
        value = self._found.get(name, False)
        if not isinstance(value, bool):
            raise WrongRequest(f'{name} must be true or false.')
        return value

    def items(self, name: str) -> List[Any]:
        """Returns a list that is not empty. Raises WrongRequest."""
        value = self._found.get(name)
        if not isinstance(value, list) or not value:
            raise WrongRequest(f'{name} must be a list that is not empty.')
        return value
