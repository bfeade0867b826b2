"""The steps of a fleet's mission, carried out with the table of actions.

VDA 5050 and the fleet (`route_protocol.steps`) use the same table. Actions that move the robot, or
that the robot treats as a drive, are refused, because the fleet would lose track of the robot. A
step `wait` needs no action: this module measures the time, and the fleet lets the robot stand.

A step that was begun and did not succeed is UNKNOWN: the ROS action does not say whether it had an
effect. A step that was never begun has FAILED.
"""
from __future__ import annotations

from typing import Any, Dict, Mapping, Optional, Protocol, Tuple

from route_protocol.steps import (
    ActorState,
    Reaction,
    StepCode,
    StepCommand,
    StepReport,
    Word,
)
from vda5050_vehicle.core.action_table import ActionSpec, ActionTable, WrongAction

WAIT = 'wait'        # the type of a step that is timed here
LONGEST_WAIT = 1e6   # s
PATIENCE = 5.0       # s that a step waits for its action server


class ActionLink(Protocol):
    """Carries out the actions of the table, and reports the end of each to `TableSteps.ended`."""

    def is_ready(self, spec: ActionSpec) -> bool:
        """Returns whether a goal would reach its server now."""

    def start(self, name: str, spec: ActionSpec, arguments: Mapping[str, Any]) -> None:
        """Begins an action under a name."""

    def cancel(self, name: str) -> None:
        """Requests the end of an action."""


class TableSteps:
    """Carries out the steps of one robot. Times are in s of any monotonic clock.

    run -- number of this run, higher than the numbers of all earlier runs
    """

    def __init__(self, table: ActionTable, link: ActionLink, run: int) -> None:
        self._table, self._link = table, link
        self._state = ActorState(run)
        self._waits: Dict[int, float] = {}
        self._waiting: Dict[int, Tuple[ActionSpec, Mapping[str, Any], float]] = {}

    @property
    def news(self) -> object:
        """The values whose changes are reported at once."""
        return self._state.last, self._state.steps

    def report(self) -> StepReport:
        """Returns the next report."""
        self._state, report = self._state.report()
        return report

    def receive(self, command: StepCommand, now: float) -> None:
        """Handles a command."""
        self._state, reaction = self._state.obey(command)
        if reaction is Reaction.BEGIN:
            self._begin(command, now)
        elif reaction is Reaction.BREAK_OFF:
            self._break_off(command.key)

    def _begin(self, command: StepCommand, now: float) -> None:
        try:
            if command.type == WAIT:
                self._waits[command.key] = now + _seconds(command)
                return
            spec = self._table.specs.get(command.type)
            if spec is None or spec.call is None:
                self._fail(command.key, StepCode.UNKNOWN_TYPE,
                           f'the robot has no step {command.type}')
            elif spec.moves or spec.commands_motion:
                self._fail(command.key, StepCode.UNKNOWN_TYPE,
                           f'{command.type} moves the robot: it cannot be a step of a fleet')
            else:
                self._waiting[command.key] = spec, _arguments(spec, command), now + PATIENCE
                self.tick(now)
        except WrongAction as wrong:
            self._fail(command.key, StepCode.WRONG_PARAMETER, str(wrong))

    def _fail(self, key: int, code: StepCode, text: str) -> None:
        self._state = self._state.end(key, Word.FAILED, code, text)

    def _break_off(self, key: int) -> None:
        """Ends a step that was not sent to its server yet; asks the server to end a sent step."""
        if key in self._waits or key in self._waiting:
            self._waits.pop(key, None)
            self._waiting.pop(key, None)
            self._state = self._state.end(key, Word.CANCELLED)
        else:
            self._link.cancel(str(key))

    def tick(self, now: float) -> None:
        """Begins and ends the steps that are due. The caller calls it several times a second."""
        for key, until in list(self._waits.items()):
            if now >= until:
                del self._waits[key]
                self._state = self._state.end(key, Word.DONE)
        for key, (spec, arguments, until) in list(self._waiting.items()):
            if self._link.is_ready(spec):
                del self._waiting[key]
                self._link.start(str(key), spec, arguments)
            elif now >= until:
                del self._waiting[key]
                server = spec.call.server if spec.call is not None else ''
                self._fail(key, StepCode.NOT_READY, f'there is no action server {server}')

    def ended(self, name: str, succeeded: bool, text: str) -> None:
        """Notes that an action has ended."""
        self._state = self._state.end(
            int(name), Word.DONE if succeeded else Word.UNKNOWN,
            StepCode.NONE if succeeded else StepCode.OTHER, '' if succeeded else text)


def _seconds(command: StepCommand) -> float:
    """Returns the duration of a wait. Raises WrongAction."""
    given = dict(command.parameters)
    for key in given:
        if key != 'seconds':
            raise WrongAction(key, f'{WAIT} has no parameter {key[:40]!r}')
    seconds = _number(given.get('seconds', ''))
    if seconds is None or not 0.0 <= seconds <= LONGEST_WAIT:
        raise WrongAction('seconds', f'seconds must be a number from 0 to {LONGEST_WAIT:.0f}')
    return seconds


def _arguments(spec: ActionSpec, command: StepCommand) -> Mapping[str, Any]:
    """Returns the arguments of an action. Raises WrongAction."""
    types = {parameter.key: parameter.type for parameter in spec.parameters}
    given = {key: _value(types.get(key, 'STRING'), text) for key, text in command.parameters}
    spec.check_arguments(given)
    return spec.with_defaults(given)


def _value(type_name: str, text: str) -> Any:
    """Returns the text as a value of this type; the text itself if it cannot be converted."""
    if type_name == 'STRING':
        return text
    if type_name == 'BOOL':
        return {'true': True, 'false': False}.get(text.lower(), text)
    number = _number(text)
    return text if number is None else number


def _number(text: str) -> Optional[float]:
    try:
        return float(text)
    except ValueError:
        return None
