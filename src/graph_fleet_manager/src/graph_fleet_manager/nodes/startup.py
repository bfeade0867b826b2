"""How the fleet manager's nodes start: strict parameters, diagnostics, and an end without noise.

A node that cannot work with its configuration says so once, shows it as ERROR in /diagnostics and
waits: under `respawn` it would come back for ever.
"""
from __future__ import annotations

import math
from typing import Any, Callable, Mapping, Tuple, Type

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper, Updater
from rosgraph.names import is_legal_base_name

from graph_fleet_manager.files.errors import FileError
from graph_fleet_manager.files.fleet_file import load_fleet
from graph_fleet_manager.fleet import Fleet

REQUIRED = object()
Report = Callable[[DiagnosticStatusWrapper], Any]


class ConfigurationError(Exception):
    """A parameter or file that the node cannot work with: one sentence that says what to do."""


def parameter(name: str, default: Any = REQUIRED, kind: Type = str) -> Any:
    """The parameter `name`, e.g. `~graph_file`; raises ConfigurationError.

    A whole number will do for a float, and a number for a text: roslaunch reads `007` as one.
    """
    value = rospy.get_param(name, default)
    where = f'Parameter {rospy.resolve_name(name)}'
    if value is REQUIRED or (default is REQUIRED and value == ''):
        raise ConfigurationError(f'{where} is missing: set it in the launch file.')
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if number and kind is str:
        return str(value)
    if number and kind is float and math.isfinite(value):
        return float(value)
    if type(value) is not kind or kind is float:
        raise ConfigurationError(f'{where} is {value!r}, but must be a {kind.__name__}.')
    return value


def number(name: str, default: float, least: float, most: float) -> float:
    """A number within `least`..`most`; raises ConfigurationError."""
    value: float = parameter(name, default, float)
    if not least <= value <= most:
        raise ConfigurationError(f'Parameter {rospy.resolve_name(name)} is {value}, but must lie '
                                 f'in {least}..{most}.')
    return value


def choice(name: str, default: str, allowed: Tuple[str, ...]) -> str:
    """One of these words; raises ConfigurationError."""
    value: str = parameter(name, default)
    if value not in allowed:
        raise ConfigurationError(f'Parameter {rospy.resolve_name(name)} is {value!r}, but must be '
                                 f'one of {", ".join(allowed)}.')
    return value


def fleet_of(name: str = '~fleet_file') -> Fleet:
    """The fleet in the file that a parameter names; raises ConfigurationError.

    Names of robots are those of their topics, too.
    """
    file = parameter(name)
    try:
        fleet = load_fleet(file)
    except FileError as error:
        raise ConfigurationError(str(error)) from None
    for robot in fleet.robots:
        if not is_legal_base_name(robot.name):
            raise ConfigurationError(f'{file}: robot {robot.name!r} has topics of its own, so its '
                                     'name must begin with a letter and hold only letters, digits '
                                     'and underscores.')
    return fleet


def run(name: str, start: Callable[[], Any]) -> None:
    """Runs a node: `start` reads the parameters, connects everything and returns what to keep."""
    rospy.init_node(name)
    try:
        node = start()
    except ConfigurationError as error:
        reason = str(error)
        rospy.logerr('%s cannot work: %s Mend it and restart the node.', rospy.get_name(), reason)
        node = diagnose({'configuration': lambda status: status.summary(DiagnosticStatus.ERROR,
                                                                        reason)})
    rospy.spin()
    del node


def diagnose(reports: Mapping[str, Report]) -> rospy.Timer:
    """Publishes each report once a second in /diagnostics, as `<node>: <its name>`."""
    updater = Updater()
    updater.setHardwareID('none')
    for name, report in reports.items():
        updater.add(name, _reporting(report))
    return rospy.Timer(rospy.Duration(1.0), lambda _: updater.force_update())


def _reporting(report: Report) -> Callable[[DiagnosticStatusWrapper], DiagnosticStatusWrapper]:
    def ask(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        report(status)
        return status
    return ask
