"""Converts commands for steps, and reports of steps, to and from messages of `itrci_nav_msgs`.

Only this module uses the fields of these messages. It does not import ROS.
"""
from __future__ import annotations

from typing import Any, Type

from route_protocol.steps import ShownStep, StepAct, StepCode, StepCommand, StepReport, Word

MOST_STEPS = 1000      # maximum number in one report; a report with more steps is refused
_LONGEST_TEXT = 500    # maximum number of characters kept of a robot's text


class WrongStepMessage(ValueError):
    """A message that cannot be used. The text of the error is a clause that says why."""


def command_of(message: Any) -> StepCommand:
    """Returns the command in an `itrci_nav_msgs/StepCommand`. Raises WrongStepMessage."""
    try:
        act = StepAct(message.act)
    except ValueError:
        raise WrongStepMessage(f'its act is {message.act}, which does not exist') from None
    return StepCommand(message.key, act, message.known_run, message.type,
                       tuple((one.name, one.value) for one in message.parameters),
                       message.timeout)


def fill_command(message: Any, command: StepCommand, parameter_type: Type[Any]) -> Any:
    """Fills an empty `itrci_nav_msgs/StepCommand` and returns it.

    parameter_type -- the message type of its parameters
    """
    message.key, message.act, message.known_run = command.key, int(command.act), command.known_run
    message.type, message.timeout = command.type, command.timeout
    message.parameters = [parameter_type(name, value) for name, value in command.parameters]
    return message


def step_report_of(message: Any) -> StepReport:
    """Returns the report in an `itrci_nav_msgs/StepStates`. Raises WrongStepMessage."""
    if len(message.steps) > MOST_STEPS:
        raise WrongStepMessage(f'it has more than {MOST_STEPS} steps')
    try:
        steps = tuple(ShownStep(one.key, Word(one.state), StepCode(one.code), _words(one.text))
                      for one in message.steps)
    except ValueError as error:
        raise WrongStepMessage(f'a step has a state or code that does not exist ({error})'
                               ) from None
    return StepReport(message.run, message.number, message.last, steps)


def fill_step_report(message: Any, report: StepReport, state_type: Type[Any]) -> Any:
    """Fills an empty `itrci_nav_msgs/StepStates` and returns it.

    state_type -- the message type of its steps
    """
    message.run, message.number, message.last = report.run, report.number, report.last
    message.steps = [state_type(one.key, int(one.word), int(one.code), one.text)
                     for one in report.steps]
    return message


def _words(text: str) -> str:
    return ''.join(letter if letter.isprintable() else '?' for letter in text[:_LONGEST_TEXT])
