"""The robot's configuration as ARCL shows it: sections of named parameters.

Only parameters that change what the simulator does are here, each with the section and name of the
facts. `configAdd` lines are collected and parsed at `configParse`, as on the robot.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, List, Optional, Tuple

FILES = 'Files'
SERVER = 'ARCL server setup'
OUTGOING = 'Outgoing ARCL connection setup'
OUTGOING_COMMANDS = 'Outgoing ARCL commands'
DOCKING = 'Docking'
LISTS = range(1, 6)


@dataclass
class Parameter:
    """One value with what `getConfigSectionInfo` tells about it; a range of None is open."""

    name: str
    type: str           # string, int, double or bool
    value: str
    description: str
    least: Optional[float] = None
    most: Optional[float] = None
    priority: str = 'Normal'
    hint: str = ''

    def check(self, value: str) -> None:
        """Raises ValueError, with a sentence, for a value that is none of this type."""
        if self.type == 'bool':
            if value.lower() not in ('true', 'false'):
                raise ValueError(f"{self.name} must be true or false, not '{value}'")
            return
        if self.type in ('int', 'double'):
            try:
                number = int(value) if self.type == 'int' else float(value)
            except ValueError:
                raise ValueError(f"{self.name} must be a number, not '{value}'") from None
            if (self.least is not None and not number >= self.least
                    or self.most is not None and not number <= self.most):
                raise ValueError(f"{self.name} is out of range: '{value}'")


@dataclass
class Section:
    """A named group of parameters."""

    comment: str
    parameters: List[Parameter] = field(default_factory=list)

    def find(self, name: str) -> Optional[Parameter]:
        """The parameter called `name`; case matters."""
        return next((p for p in self.parameters if p.name == name), None)


def _sections() -> Dict[str, Section]:
    text, whole, real, flag = 'string', 'int', 'double', 'bool'
    commands = [Parameter('LogOutgoingCommands', flag, 'false', 'Log the commands sent')]
    for n in LISTS:
        commands += [Parameter(f'OutgoingCommands{n}', text, '',
                               'Commands to carry out, separated by |'),
                     Parameter(f'OutgoingCommands{n}Seconds', real, '0',
                               'Seconds between two runs, 0 is off', 0.0)]
    return {
        FILES: Section('The files the robot uses', [
            Parameter('Map', text, '', 'The map the robot drives on')]),
        SERVER: Section('The ARCL server', [
            Parameter('ArclConfig', flag, 'true', 'Whether ARCL may read and change this'),
            Parameter('SessionTimeoutMins', real, '-1',
                      'Minutes of silence after which a client is dropped, -1 is off')]),
        OUTGOING: Section('The connection that the robot opens', [
            Parameter('OutgoingHostname', text, '', 'Where to connect to, empty is off'),
            Parameter('OutgoingPort', whole, '0', 'Port to connect to, 0 is off', 0, 65535),
            Parameter('OutgoingSocketTimeoutInMins', real, '-1',
                      'Minutes of silence after which the robot connects again, -1 is off'),
            Parameter('SendStatusInterval', whole, '0',
                      'Milliseconds between two status lines, 0 is off', 0),
            Parameter('RequireConnectionToPathPlan', flag, 'false',
                      'Whether the robot drives only while connected')]),
        OUTGOING_COMMANDS: Section('Commands for the outgoing connection', commands),
        DOCKING: Section('When the robot docks by itself', [
            Parameter('AutoDock', flag, 'false', 'Whether the robot docks by itself'),
            Parameter('AutoDockCharge', real, '25', 'Percent below which it docks', 0, 100),
            Parameter('AutoDockIdleMins', real, '15', 'Idle minutes after which it docks', 0)]),
    }


class Configuration:
    """All sections, and a change being imported."""

    def __init__(self) -> None:
        self.sections = _sections()
        self._import: Optional[List[Tuple[str, str]]] = None

    def text(self, section: str, name: str) -> str:
        """A parameter's value."""
        parameter = self.sections[section].find(name)
        assert parameter is not None, f'{section}/{name}'
        return parameter.value

    def number(self, section: str, name: str) -> float:
        """A parameter's value as a number."""
        return float(self.text(section, name))

    def flag(self, section: str, name: str) -> bool:
        """A parameter's value as a truth."""
        return self.text(section, name).lower() == 'true'

    def set(self, section: str, name: str, value: object) -> None:
        """Changes one value; ValueError with a sentence when there is no such or it does not fit.
        """
        parameter = self.sections[section].find(name) if section in self.sections else None
        if parameter is None:
            raise ValueError(f"there is no parameter '{name}' in section '{section}'")
        parameter.check(str(value))
        parameter.value = str(value)

    # -- importing -----------------------------------------------------------------------------

    def start_import(self) -> None:
        """`configStart`."""
        self._import = []

    def add_to_import(self, key: str, value: str) -> bool:
        """`configAdd`; False when no import has been started."""
        if self._import is None:
            return False
        self._import.append((key, value))
        return True

    def finish_import(self) -> Optional[Tuple[List[Tuple[str, str, str]], List[str]]]:
        """`configParse`: the changes (section, name, value) and the errors; None if not started."""
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
