"""The launch file of a fleet. roslaunch has no loops, so the file has an entry for each robot.

The nodes of one robot are in the launch files of its package, which are included.
"""
from __future__ import annotations

import shlex
import xml.etree.ElementTree as ET
from enum import Enum
from typing import Any, Collection, Dict, Sequence
from xml.dom import minidom

from fleet_bringup.errors import CannotStart
from fleet_bringup.files import StartedSite
from fleet_bringup.options import Options
from fleet_bringup.robot_entries import AGV, LD90, RobotEntry

RESPAWN = {'respawn': 'true', 'respawn_delay': '2'}
#: The file in ROS_HOME in which the bridge of a real robot keeps its last route.
ROUTE_FILE = 'omron_ld90/{}_route.json'
#: The format of log lines. It includes the node's name, because all robots share one screen. A
#: format that the user or `start_output` has set is kept.
SCREEN = "$(eval optenv('ROSCONSOLE_FORMAT', '[${severity}] [${time}] ${node}: ${message}'))"
#: Seconds in which a simulated door opens, and in which a simulated PLC hands a load over.
TRAVEL, HAND_OVER = 3.0, 3.0
#: Namespace of the node that shows the map of the LD-90s.
MAP = 'fleet'
#: An argument of the launch file: the program that roslaunch starts in place of a hosted node. It
#: is an argument because `$(find ...)` does not work in a quoted text.
HOSTED_BY = {'name': 'hosted_by', 'value': '$(find node_host)/hosted'}
#: The attributes that turn a node into a fork. roslaunch splits the prefix at blanks unless it is
#: quoted.
HOSTED = {'launch-prefix': '"$(arg hosted_by)"'}
#: The modules of the fleet manager's nodes, which the node host imports once for all forks.
MODULES = tuple(f'graph_fleet_manager.nodes.{node}' for node in (
    'graph_server', 'path_planner', 'path_supervisor', 'fleet_visualisation'))


class Part(Enum):
    """A part of the fleet that can have its own launch file."""

    SIMULATORS = 'simulators'
    ROBOTS = 'robots'
    MANAGER = 'manager'
    PAGE = 'page'


def parts_of(entries: Sequence[RobotEntry], options: Options) -> Sequence[Part]:
    """Returns the parts that a fleet has, in the order in which they start."""
    has = {Part.SIMULATORS: any(entry.is_simulated for entry in entries),
           Part.ROBOTS: any(entry.robot.driver == LD90 for entry in entries),
           Part.MANAGER: True,
           Part.PAGE: options.fleet_manager and options.page}
    return [part for part in Part if has[part]]


def launch_text(entries: Sequence[RobotEntry], site: StartedSite, options: Options,
                files: Dict[str, str], parts: Collection[Part] = tuple(Part)) -> str:
    """Returns the launch file of some parts. `files`: paths by the kind of file, see
    `command.prepare`.
    """
    root = ET.Element('launch')
    root.append(ET.Comment(f' Made by scripts/run.sh fleet:={options.fleet} '.replace('--', '- -')))
    ET.SubElement(root, 'env', name='ROSCONSOLE_FORMAT', value=SCREEN)
    parts = [part for part in parts_of(entries, options) if part in parts]
    ET.SubElement(root, 'arg', HOSTED_BY)
    if options.hosted and parts != [Part.PAGE]:
        _include(root, 'omron_ld90', 'robot_host',
                 {'more_modules': ' '.join(MODULES)} if Part.MANAGER in parts else {})
    for part in parts:
        _PARTS[part](root, entries, site, options, files)
    return minidom.parseString(ET.tostring(root)).toprettyxml('  ')


def _simulators(root: ET.Element, entries: Sequence[RobotEntry], site: StartedSite,
                options: Options, files: Dict[str, str]) -> None:
    if any(entry.robot.driver == LD90 and entry.is_simulated for entry in entries):
        _ld90_simulator(root, site, options, files)
        for entry in entries:
            if entry.robot.driver == LD90 and entry.is_simulated:
                # so that the controllers remember no robots of an earlier run
                ET.SubElement(root, 'param', name=f'{entry.name}/omron_controller/robot_id',
                              type='str', value='$(anon simulator)')
    if any(entry.robot.driver == AGV for entry in entries):
        _node(root, 'agv_sim', 'graph_fleet_manager', 'agv_sim', {
            'fleet_file': files['fleet'], 'graph_file': site.graph_file,
            'sim_speed': options.sim_speed, 'control_port': options.control_port + 1},
            _hosted(options, {}))


def _robots(root: ET.Element, entries: Sequence[RobotEntry], site: StartedSite, options: Options,
            files: Dict[str, str]) -> None:
    for entry in entries:
        if entry.robot.driver == LD90:
            _ld90(root, entry, site, options, files)


def _manager(root: ET.Element, entries: Sequence[RobotEntry], site: StartedSite, options: Options,
             files: Dict[str, str]) -> None:
    if options.fleet_manager:
        _include(root, 'graph_fleet_manager', 'fleet_manager', {
            'graph_file': site.graph_file, 'fleet_file': files['fleet'],
            'sim_speed': options.sim_speed, 'hosted': _xml(options.hosted), **_memory(files),
            **({'work_file': site.work_file} if site.work_file else {}),
            **({'multimaster': 'true'} if any(entry.computer for entry in entries) else {})})
    if site.has_devices:
        _devices(root, site, options, files)
    if options.work:
        _node(root, 'plc_sim', 'graph_fleet_manager', 'plc_sim',
              {'seconds': HAND_OVER / options.sim_speed}, _hosted(options, RESPAWN))
    if options.demo:
        _node(root, 'random_missions', 'graph_fleet_manager', 'random_missions', {},
              _hosted(options, RESPAWN))
    _pictures(root, site, options, files)


def _devices(root: ET.Element, site: StartedSite, options: Options, files: Dict[str, str]) -> None:
    _node(root, 'fleet_devices', 'fleet_devices', 'fleet_devices', {
        'work_file': site.work_file, 'graph_file': site.graph_file,
        'simulated_travel': TRAVEL / options.sim_speed,
        **({'memory_file': files['device_memory'], 'steps_file': files['device_steps']}
           if 'device_memory' in files else {})}, RESPAWN)


def _memory(files: Dict[str, str]) -> Dict[str, str]:
    """Returns the files in which the fleet manager keeps data; empty for real robots: the fleet
    manager then uses its default files.
    """
    return {name: files[key] for name, key in (
        ('closed_edges_file', 'closed_edges'), ('journal', 'journal')) if key in files}


def _ld90_simulator(root: ET.Element, site: StartedSite, options: Options,
                    files: Dict[str, str]) -> None:
    lists = [] if options.lasers else ['--outgoing-commands', '0.5:Status']
    node = _node(root, 'ld90_sim', 'omron_ld90_sim', 'ld90_sim', {})
    node.set('args', _words(
        '--map', site.map_file, '--robots', files['robots'],
        '--password-file', files['simulator_password'], '--speed', options.sim_speed,
        '--control', options.control_port, *lists))


def _ld90(root: ET.Element, entry: RobotEntry, site: StartedSite, options: Options,
          files: Dict[str, str]) -> None:
    _include(root, 'omron_ld90', 'robot', {
        'robot_name': entry.name, 'robot_ip': entry.host or '127.0.0.1',
        'arcl_port': entry.arcl_port, 'outgoing_port': entry.outgoing_port,
        'password_file': entry.password_file or files['simulator_password'],
        'map_file': site.map_file, 'graph_file': site.graph_file, 'dock_vertex': site.dock,
        'route_file': '' if entry.is_simulated else ROUTE_FILE.format(entry.name),
        'strategy': options.strategy, 'hosted': _xml(options.hosted), 'node_host': 'false'})
    group = ET.SubElement(root, 'group', ns=entry.name)
    if entry.is_simulated:  # so parameters of an earlier run at the same ROS master do not apply
        group.set('clear_params', 'true')
    _node(group, 'robot_state_publisher', 'omron_ld90', 'robot_state_publisher', {
        'base_frame': f'{entry.name}/base_link', 'laser_frame': f'{entry.name}/laser_link'},
        _hosted(options, RESPAWN))


def _pictures(root: ET.Element, site: StartedSite, options: Options, files: Dict[str, str]) -> None:
    if site.map_file:
        group = ET.SubElement(root, 'group', ns=MAP)
        _node(group, 'map_visualisation', 'omron_ld90', 'map_visualisation',
              {'map_file': site.map_file}, _hosted(options, RESPAWN))
    _node(root, 'fleet_visualisation', 'graph_fleet_manager', 'fleet_visualisation',
          {'fleet_file': files['fleet'],
           **({} if options.page else {'says_ready': _xml(options.fleet_manager)})},
          _hosted(options, RESPAWN))
    if options.rviz:
        node = _node(root, 'rviz', 'omron_ld90', 'rviz_view', {})
        node.set('args', _words(site.map_file, files['rviz']))


def _page(root: ET.Element, entries: Sequence[RobotEntry], site: StartedSite, options: Options,
          files: Dict[str, str]) -> None:
    _node(root, 'fleet_page', 'fleet_page', 'fleet_page', {
        'fleet_file': files['fleet'], 'map_topic': f'/{MAP}/map', 'listen': options.listen,
        'port': options.page_port, 'token_file': options.token_file,
        'certificate': options.certificate_file, 'key': options.key_file,
        **{name: files[key] for name, key in (('journal', 'journal'), ('folder', 'page'))
           if key in files}}, RESPAWN)


_PARTS = {Part.SIMULATORS: _simulators, Part.ROBOTS: _robots, Part.MANAGER: _manager,
          Part.PAGE: _page}


def _hosted(options: Options, more: Dict[str, str]) -> Dict[str, str]:
    return {**HOSTED, **more} if options.hosted else more


def _xml(value: bool) -> str:
    return str(value).lower()


def _node(parent: ET.Element, name: str, package: str, kind: str, parameters: Dict[str, Any],
          more: Dict[str, str] = {}) -> ET.Element:  # noqa: B006 - never changed
    node = ET.SubElement(parent, 'node', {'name': name, 'pkg': package, 'type': kind,
                                          'output': 'screen', **more})
    for key, value in parameters.items():
        ET.SubElement(node, 'param', name=key, value=literal(value))
    return node


def _include(parent: ET.Element, package: str, launch: str, arguments: Dict[str, Any]) -> None:
    include = ET.SubElement(parent, 'include', file=f'$(find {package})/launch/{launch}.launch')
    for key, value in arguments.items():
        ET.SubElement(include, 'arg', name=key, value=literal(value))


def literal(value: Any) -> str:
    """Returns a value that roslaunch uses unchanged. Raises CannotStart for a value that roslaunch
    would evaluate.

    roslaunch replaces `$(...)` everywhere, even in results of Python, and has no way to quote it.
    """
    text = str(value)
    if '$(' in text:
        raise CannotStart(f'"{text}" contains "$(", which roslaunch would evaluate: rename what '
                          'has this name.')
    return text


def _words(*values: Any) -> str:
    """Returns the arguments of a program, each quoted as one word."""
    return ' '.join(shlex.quote(literal(value)) for value in values)
