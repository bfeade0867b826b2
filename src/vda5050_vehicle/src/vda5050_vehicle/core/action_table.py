"""The table of actions: what a vehicle can do besides driving, and how each action is executed.

The table is a YAML file (`actions.yaml`), so that this package does not depend on a robot. Each
action is executed as a goal of a ROS action. The text fields of the goal may contain parameters of
the action, e.g. `say {text}`.
"""
from __future__ import annotations

import re
import string
from dataclasses import dataclass, field, replace
from typing import Any, Dict, FrozenSet, Mapping, Optional, Set, Tuple

from vda5050_protocol.action_queue import Scope
from vda5050_protocol.values import BlockingType, VdaAction

TEXT_LIMIT = 200  # characters of a parameter
PRINTABLE = r'[^\x00-\x1f\x7f]*'


class WrongTable(Exception):
    """A table that cannot be used; the text names the entry and the remedy."""


class WrongAction(Exception):
    """An action that the vehicle cannot execute; `key` is the wrong field or parameter."""

    def __init__(self, key: str, description: str) -> None:
        super().__init__(description)
        self.key = key


_TYPES: Mapping[str, Tuple[type, ...]] = {
    'BOOL': (bool,), 'NUMBER': (int, float), 'INTEGER': (int,), 'FLOAT': (int, float),
    'STRING': (str,)}


@dataclass(frozen=True)
class Parameter:
    """A parameter of an action.

    pattern     -- regular expression that must match the whole text
    least, most -- bounds of a number
    """

    key: str
    type: str
    description: str = ''
    optional: bool = False
    pattern: str = PRINTABLE
    least: float = -1e9
    most: float = 1e9
    default: Any = ''

    def check(self, value: Any) -> None:
        """Raises WrongAction if the value is not allowed."""
        value = self.value_of(value)
        if (not isinstance(value, _TYPES[self.type])
                or isinstance(value, bool) is not (self.type == 'BOOL')):
            raise WrongAction(self.key, f'{self.key} must be of type {self.type}')
        if isinstance(value, str):
            if len(value) > TEXT_LIMIT or not re.fullmatch(self.pattern, value):
                raise WrongAction(self.key, f'{self.key} may have up to {TEXT_LIMIT} characters '
                                            f'and must match {self.pattern}')
        elif isinstance(value, (int, float)) and not self.least <= value <= self.most:
            raise WrongAction(self.key, f'{self.key} must lie in {self.least:g}..{self.most:g}')

    def value_of(self, value: Any) -> Any:
        """Returns the value; 1.0 becomes 1 for the type INTEGER, because JSON has no integers."""
        if self.type == 'INTEGER' and isinstance(value, float) and value.is_integer():
            return int(value)
        return value


@dataclass(frozen=True)
class ActionCall:
    """A goal of a ROS action: the action's name and type, and the fields of the goal."""

    server: str
    type: str
    goal: Mapping[str, Any]

    def fields(self, arguments: Mapping[str, Any]) -> Dict[str, Any]:
        """Returns the fields of the goal for the given arguments."""
        return {name: value.format(**arguments) if isinstance(value, str) else value
                for name, value in self.goal.items()}


@dataclass(frozen=True)
class ActionSpec:
    """An entry of the table; without `call` the vehicle executes the action itself.

    moves           -- whether the action moves the robot; if so, it is refused as an instant action
                       while an order is active
    executed_as     -- the blocking type on this robot; None: the blocking type of the message
    cancellable     -- whether cancelOrder ends the action
    commands_motion -- whether the robot treats the action as a drive with a new epoch

    The attributes are the columns of the table.
    """

    action_type: str
    description: str
    scopes: FrozenSet[Scope]
    blocking: Tuple[BlockingType, ...] = tuple(BlockingType)
    parameters: Tuple[Parameter, ...] = ()
    cancellable: bool = True
    moves: bool = False
    executed_as: Optional[BlockingType] = None
    result: str = ''
    commands_motion: bool = False
    call: Optional[ActionCall] = field(default=None, compare=False)

    def check(self, action: VdaAction, scope: Scope) -> None:
        """Raises WrongAction if the action does not agree with the table."""
        if scope not in self.scopes:
            raise WrongAction('actionType', f'{self.action_type} is not a {scope.value} action')
        if action.blocking_type not in self.blocking:
            raise WrongAction('blockingType', f'{self.action_type} must be '
                              + ' or '.join(kind.value for kind in self.blocking))
        self.check_arguments(action.arguments)

    def check_arguments(self, arguments: Mapping[str, Any]) -> None:
        """Raises WrongAction if the arguments do not fit the action."""
        known = {parameter.key: parameter for parameter in self.parameters}
        for key, value in arguments.items():
            if key not in known:
                raise WrongAction(key, f'{self.action_type} has no parameter {key[:40]!r}')
            known[key].check(value)
        for key, parameter in known.items():
            if key not in arguments and not parameter.optional:
                raise WrongAction(key, f'{self.action_type} needs the parameter {key}')

    def with_defaults(self, given: Mapping[str, Any]) -> Dict[str, Any]:
        """Returns the given arguments, and default values for optional arguments not given."""
        return {p.key: p.value_of(given.get(p.key, p.default)) for p in self.parameters
                if p.optional or p.key in given}


class ActionTable:
    """The entries of the table by action type."""

    def __init__(self, specs: Tuple[ActionSpec, ...]) -> None:
        self.specs: Mapping[str, ActionSpec] = {spec.action_type: spec for spec in specs}

    def check(self, action: VdaAction, scope: Scope) -> ActionSpec:
        """Returns the entry of an action; raises WrongAction."""
        spec = self.specs.get(action.action_type)
        if spec is None:
            raise WrongAction('actionType', f'the vehicle has no action {action.action_type!r}')
        spec.check(action, scope)
        return spec

    def as_executed(self, action: VdaAction) -> VdaAction:
        """Returns the action with its blocking type on this robot."""
        spec = self.specs.get(action.action_type)
        if spec is None or spec.executed_as is None:
            return action
        return replace(action, blocking_type=spec.executed_as)

    def moves(self, action: VdaAction) -> bool:
        """Returns whether the action moves the robot."""
        spec = self.specs.get(action.action_type)
        return spec is not None and spec.moves

    def commands_motion(self, action: VdaAction) -> bool:
        """Returns whether the action may change the epoch of the robot's motion."""
        spec = self.specs.get(action.action_type)
        return spec is not None and (spec.moves or spec.commands_motion)


def read_table(document: Any) -> Tuple[ActionSpec, ...]:
    """Returns the entries of a parsed `actions.yaml`; raises WrongTable."""
    actions = document.get('actions') if isinstance(document, dict) else None
    if not isinstance(actions, dict):
        raise WrongTable('it needs the key `actions:` with one entry per action type')
    return tuple(_checked(_entry(str(name), line)) for name, line in actions.items())


_KEYS = {'description', 'scopes', 'blocking', 'executed_as', 'parameters', 'cancellable',
         'moves', 'commands_motion', 'result', 'server', 'type', 'goal'}


def _entry(name: str, line: Any) -> ActionSpec:
    if not isinstance(line, dict) or not {'server', 'type', 'goal', 'scopes'} <= set(line):
        raise WrongTable(f'action {name} needs server, type, goal and scopes')
    if set(line) - _KEYS:
        raise WrongTable(f'action {name} has unknown keys: {", ".join(sorted(set(line) - _KEYS))};'
                         f' the known keys are {", ".join(sorted(_KEYS))}')
    try:
        parameters = tuple(Parameter(key, **values)
                           for key, values in (line.get('parameters') or {}).items())
        return ActionSpec(
            name, str(line.get('description', '')),
            frozenset(Scope(scope) for scope in line['scopes']),
            tuple(map(BlockingType, line.get('blocking', BlockingType))),
            parameters, bool(line.get('cancellable', True)), bool(line.get('moves', False)),
            BlockingType(line['executed_as']) if 'executed_as' in line else None,
            str(line.get('result', '')), bool(line.get('commands_motion', False)),
            ActionCall(str(line['server']), str(line['type']), dict(line['goal'])))
    except (TypeError, ValueError) as error:
        raise WrongTable(f'action {name}: {error}') from None


def _checked(spec: ActionSpec) -> ActionSpec:
    """Returns the entry if its parts agree with each other; raises WrongTable."""
    if spec.executed_as is not None and spec.executed_as not in spec.blocking:
        raise WrongTable(f'action {spec.action_type}: executed_as is {spec.executed_as.value}, '
                         'which is not in its blocking')
    for parameter in spec.parameters:
        if parameter.type not in _TYPES:
            raise WrongTable(f'action {spec.action_type}: parameter {parameter.key} has type '
                             f'{parameter.type}; the types are {", ".join(_TYPES)}')
    unknown = _arguments_in(spec.call) - {parameter.key for parameter in spec.parameters}
    if unknown:
        raise WrongTable(f'action {spec.action_type}: its goal uses {", ".join(sorted(unknown))}, '
                         'which is not a parameter of the action')
    return spec


def _arguments_in(call: Optional[ActionCall]) -> Set[str]:
    """Returns the arguments that the goal of a call contains."""
    values = call.goal.values() if call else ()
    return {field for value in values if isinstance(value, str)
            for _, field, _, _ in string.Formatter().parse(value) if field is not None}
