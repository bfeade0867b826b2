"""The stop of the whole fleet, which the door of the page carries out."""
from __future__ import annotations

import sys

import rospy

from fleet_page.core.acts import ActOutcome
from fleet_page.nodes.fleet_commands import by_page
from graph_fleet_manager.commands.command_line import CommandProblem
from graph_fleet_manager.commands.stop import stop


def forget_node_arguments() -> None:
    """Forgets the arguments of the page's node, such as its name, in the process of the door.

    A direct stop makes this process a ROS node. If it had the name of the page, it would end the
    page.
    """
    sys.argv[1:] = [word for word in sys.argv[1:] if word.startswith('__master:=')]
    rospy.names.reload_mappings(sys.argv)


def stop_fleet(person: str) -> ActOutcome:
    """Stops all robots for a person, even if the fleet manager hangs.

    Only one stop may run at a time, because a direct stop uses the topics of the robots.
    """
    try:
        return ActOutcome(True, stop(by_page(person)))
    except CommandProblem as error:
        return ActOutcome(False, str(error))
