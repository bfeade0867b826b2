"""`omron_ros_map`: makes a `.map` file from a trajectory graph and a base map, once.

With options it is a command line tool that needs no ROS master (`--help` lists the options). If
roslaunch starts it, it reads the same options from private parameters, converts, and ends. Exit
status: 0 if the map was written, 1 if it could not be made.

Parameters
    ~graph (str): file of the trajectory graph (YAML)
    ~base_map (str): `.map` file made with MobilePlanner
    ~output (str): `.map` file to write
    ~dock_vertex (int, none): vertex at which the robot docks
    ~dock_heading (float, from the graph): heading in degrees that faces the station
    ~existing_goals (str, replace): replace | keep | drop, for goals of the base map
    ~fences (str, areas): areas | lines | none; what keeps the robot in the corridors
    ~corridor_width (float, 0.9): m
    ~edge_width (str, ""): widths of single edges in m, like `3=1.2,7=0.8`
    ~turning_margin (float, 0.05): m, free floor around the turning robot
    ~draw (str, ""): PNG file into which the result is drawn; empty: none
"""
from __future__ import annotations

import sys
from typing import List, Optional

from omron_map_converter import cli
from omron_map_converter.converter import ConversionOptions, ExistingGoals
from omron_map_converter.fences import Fences


def main(arguments: Optional[List[str]] = None) -> None:
    """Runs as a command, or as a node if roslaunch or rosrun passed names or parameters."""
    arguments = sys.argv[1:] if arguments is None else arguments
    options = [argument for argument in arguments if ':=' not in argument]
    as_node = len(options) < len(arguments) and not options
    sys.exit(_run_node() if as_node else cli.main(options))


def _run_node() -> int:
    import rospy

    from node_lifecycle import ConfigurationError, choice, parameter
    from node_lifecycle.log_file import init_node

    init_node('omron_ros_map')
    try:
        options = ConversionOptions(
            dock_vertex=parameter('~dock_vertex', kind=int) if _given('~dock_vertex') else None,
            dock_heading=(parameter('~dock_heading', kind=float) if _given('~dock_heading')
                          else None),
            existing_goals=ExistingGoals(choice(
                '~existing_goals', ExistingGoals.REPLACE.value,
                tuple(existing.value for existing in ExistingGoals))),
            fences=Fences(choice('~fences', Fences.AREAS.value,
                                 tuple(fences.value for fences in Fences))),
            corridors=cli.corridor_rules(
                parameter('~corridor_width', 0.9, float), parameter('~edge_width', ''),
                parameter('~turning_margin', 0.05, float)))
        cli.run(
            parameter('~graph'), parameter('~base_map'), parameter('~output'), options,
            say=rospy.loginfo, warn=rospy.logwarn, picture=parameter('~draw', ''))
    except (ConfigurationError, *cli.ERRORS) as error:
        rospy.logfatal('%s made no map: %s', rospy.get_name(), error)
        return 1
    return 0


def _given(name: str) -> bool:
    import rospy

    return rospy.has_param(name)
