"""The parameter ~fleet_file, which nearly all nodes of the fleet manager have."""
from __future__ import annotations

from rosgraph.names import is_legal_base_name

from fleet_core.files.errors import FileError
from fleet_core.files.fleet_file import load_fleet
from fleet_core.fleet import Fleet
from node_lifecycle import ConfigurationError, parameter


def fleet_of(name: str = '~fleet_file') -> Fleet:
    """Returns the fleet in the file that a parameter names.

    Raises ConfigurationError if the file is wrong, or if a robot's name cannot be a part of a
    topic's name.
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
