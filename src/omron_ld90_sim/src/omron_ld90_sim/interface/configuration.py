"""The robot's configuration in ARCL: sections of named parameters.

`configuration_table` defines them. `configAdd` lines are collected, and parsed at `configParse`, as
on the robot.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Tuple

ADDED = 'CENTRAL_SECTION'       # flags of a section that a client has added (I617-E-02 p. 148)
TEXT, WHOLE, REAL, FLAG, SEPARATOR = 'String', 'Int', 'Double', 'Bool', 'Separator'
Change = Tuple[str, str, str]       # section, name, value
_BOUNDS = {WHOLE: ('-2147483648', '2147483647'), REAL: ('-inf', 'inf')}


@dataclass
class ConfigParameter:
    """One value, and its description for `getConfigSectionInfo`; a bound may be None: no bound."""

    name: str
    type: str
    value: str
    description: str
    minimum: Optional[float] = None
    maximum: Optional[float] = None
    priority: str = 'Intermediate'
    hint: str = ''

    @property
    def info(self) -> str:
        """The description in `getConfigSectionInfo`; its last field, the delimiter, is empty."""
        unbounded = _BOUNDS.get(self.type, ('None', 'None'))
        minimum, maximum = (other if bound is None else f'{bound:.15g}' for bound, other
                            in zip((self.minimum, self.maximum), unbounded))
        return (f'{self.type} {self.name} {self.priority} {minimum} {maximum} '
                f'"{self.description}" "{self.hint}" ""')

    def check(self, value: str) -> None:
        """Raises ValueError, with a sentence, for a value of another type or out of range."""
        if self.type == FLAG:
            if value.lower() not in ('true', 'false'):
                raise ValueError(f"{self.name} must be true or false, not '{value}'")
            return
        if self.type in _BOUNDS:
            try:
                number = int(value) if self.type == WHOLE else float(value)
                if not math.isfinite(number):
                    raise ValueError
            except ValueError:
                raise ValueError(f"{self.name} must be a number, not '{value}'") from None
            if (self.minimum is not None and not number >= self.minimum
                    or self.maximum is not None and not number <= self.maximum):
                raise ValueError(f"{self.name} is out of range: '{value}'")


@dataclass
class ConfigSection:
    """A named group of parameters."""

    comment: str
    parameters: List[ConfigParameter] = field(default_factory=list)
    flags: str = ''

    def find(self, name: str) -> Optional[ConfigParameter]:
        """Returns the parameter with this name; case matters."""
        return next((p for p in self.parameters if p.name == name), None)


class RobotConfiguration:
    """All sections, and the pending import."""

    def __init__(self, sections: Dict[str, ConfigSection]) -> None:
        self.sections = sections
        self._import: Optional[List[Tuple[str, str]]] = None

    def text(self, section: str, name: str) -> str:
        """Returns a parameter's value."""
        parameter = self.sections[section].find(name)
        assert parameter is not None, f'{section}/{name}'
        return parameter.value

    def number(self, section: str, name: str) -> float:
        """Returns a parameter's value as a number."""
        return float(self.text(section, name))

    def flag(self, section: str, name: str) -> bool:
        """Returns a parameter's value as a bool."""
        return self.text(section, name).lower() == 'true'

    def set(self, section: str, name: str, value: object) -> None:
        """Changes one value. Raises ValueError, with a sentence, if this is not possible."""
        parameter = self.sections[section].find(name) if section in self.sections else None
        if parameter is None:
            raise ValueError(f"there is no parameter '{name}' in section '{section}'")
        parameter.check(str(value))
        parameter.value = str(value)

    # -- importing -----------------------------------------------------------------------------

    def start_import(self) -> None:
        """Carries out `configStart`."""
        self._import = []

    def add_to_import(self, key: str, value: str) -> bool:
        """Carries out `configAdd`; returns False if no import was started."""
        if self._import is None:
            return False
        self._import.append((key, value))
        return True

    def finish_import(self) -> Optional[Tuple[List[Change], List[str]]]:
        """Carries out `configParse`: returns the changes and the errors.

        Returns None if no import was started.
        """
        if self._import is None:
            return None
        lines, self._import = self._import, None
        changes, errors, section = [], [], ''
        for key, value in lines:
            if key.lower() == 'section':
                section = value
                continue
            parameter = self.sections[section].find(key) if section in self.sections else None
            if parameter is None:
                errors.append(f"No parameter '{key}' in section '{section}'")
                continue
            try:
                parameter.check(value)
            except ValueError as error:
                errors.append(str(error))
            else:
                changes.append((section, key, value))
        return changes, errors
