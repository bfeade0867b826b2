"""Upper layers import only lower ones, as docs/explanation/architecture.md says."""
from __future__ import annotations

import ast
from functools import lru_cache
from pathlib import Path
from typing import Dict, FrozenSet, Iterator, NamedTuple, Set

import pytest

SOURCES = Path(__file__).resolve().parents[2]
PACKAGES = {file.parent.name: file.parent for file in SOURCES.glob('*/src/*/__init__.py')}
ROS = {'actionlib', 'diagnostic_updater', 'genpy', 'interactive_markers', 'rosgraph', 'roslaunch',
       'roslib', 'rospkg', 'rospy', 'std_srvs', 'tf2_ros'}
SOCKETS = {'asyncio', 'selectors', 'socket', 'socketserver'}


class Layer(NamedTuple):
    """The imports that a layer may have besides itself, Python and other libraries.

    ours    -- packages and layers of this workspace; the name of a package also means its modules
               outside all layers
    ros     -- whether the layer may import ROS
    sockets -- modules of the layer that may import sockets
    """

    ours: FrozenSet[str]
    ros: bool = False
    sockets: FrozenSet[str] = frozenset()


def layer(ours: str = '', ros: bool = False, sockets: str = '') -> Layer:
    return Layer(frozenset(ours.split()), ros, frozenset(sockets.split()))


# each folder of a package is a layer; sockets='*': each module may import sockets
LAYERS: Dict[str, Layer] = {
    # libraries
    'browser_guard': layer(sockets='*'),
    'file_replacement': layer(),
    'json_records': layer(),
    'trajectory_graph': layer('file_replacement'),
    'route_protocol': layer(),
    'omron_map': layer('file_replacement'),
    'omron_map_converter': layer('file_replacement omron_map trajectory_graph'),
    'omron_arcl': layer('browser_guard', sockets='arcl_link connection transport listener'),
    'node_program': layer(),
    'xmlrpc_guard': layer('browser_guard', ros=True),
    'node_lifecycle': layer(
        'file_replacement node_program xmlrpc_guard', ros=True, sockets='*'),
    'node_host': layer('node_program', ros=True, sockets='*'),
    'graph_topic': layer('node_lifecycle trajectory_graph', ros=True),
    'rviz_drawing': layer('node_lifecycle trajectory_graph', ros=True),
    # the fleet
    'fleet_requests': layer(ros=True),
    'fleet_core': layer(),
    'fleet_core.geometry': layer('fleet_core trajectory_graph'),
    'fleet_core.planning': layer('fleet_core fleet_core.geometry trajectory_graph'),
    'fleet_core.interlocking': layer(
        'fleet_core fleet_core.geometry route_protocol trajectory_graph'),
    'fleet_core.work': layer('route_protocol trajectory_graph'),
    'fleet_core.supervision': layer(
        'fleet_core fleet_core.geometry fleet_core.interlocking fleet_core.planning '
        'fleet_core.work file_replacement json_records route_protocol trajectory_graph'),
    'fleet_core.files': layer(
        'fleet_core fleet_core.planning fleet_core.supervision fleet_core.work file_replacement '
        'trajectory_graph'),
    'fleet_core.site': layer(
        'fleet_core fleet_core.files fleet_core.planning file_replacement trajectory_graph'),
    'fleet_simulation': layer(
        'fleet_core fleet_core.files fleet_core.interlocking fleet_core.planning fleet_core.site '
        'fleet_core.supervision fleet_core.work fleet_simulation.agv file_replacement node_program '
        'omron_map route_protocol trajectory_graph'),
    'fleet_simulation.agv': layer('fleet_core browser_guard route_protocol trajectory_graph',
                                  sockets='control_socket'),
    'graph_fleet_manager': layer(),
    'graph_fleet_manager.messages': layer(
        'fleet_core fleet_core.geometry fleet_core.interlocking fleet_core.planning '
        'fleet_core.site fleet_core.supervision fleet_core.work route_protocol trajectory_graph',
        ros=True),
    'graph_fleet_manager.multimaster': layer(sockets='*'),
    'graph_fleet_manager.commands': layer(
        'fleet_core fleet_core.files fleet_core.geometry fleet_core.interlocking '
        'fleet_core.planning fleet_core.supervision fleet_core.work graph_fleet_manager.messages '
        'graph_fleet_manager.multimaster file_replacement fleet_requests node_lifecycle '
        'node_program trajectory_graph', ros=True, sockets='*'),
    'graph_fleet_manager.nodes': layer(
        'fleet_core fleet_core.files fleet_core.interlocking fleet_core.planning fleet_core.site '
        'fleet_core.supervision fleet_core.work fleet_requests fleet_simulation.agv '
        'graph_fleet_manager.commands graph_fleet_manager.messages '
        'graph_fleet_manager.multimaster graph_topic node_lifecycle route_protocol rviz_drawing '
        'trajectory_graph', ros=True),
    'fleet_page': layer(),
    'fleet_page.core': layer(
        'fleet_core.supervision fleet_core.work node_program trajectory_graph'),
    'fleet_page.door': layer('browser_guard fleet_page.core', sockets='*'),
    'fleet_page.web': layer('fleet_core.supervision fleet_page.core fleet_page.door', sockets='*'),
    'fleet_page.nodes': layer(
        'fleet_core.supervision fleet_core.work fleet_page.core fleet_page.door fleet_page.web '
        'fleet_requests graph_fleet_manager.commands graph_fleet_manager.messages '
        'graph_fleet_manager.nodes graph_topic node_lifecycle trajectory_graph',
        ros=True, sockets='*'),
    'fleet_bringup': layer(
        'fleet_core fleet_core.files fleet_core.planning node_program omron_map '
        'omron_map_converter trajectory_graph', ros=True, sockets='*'),
    'fleet_services': layer(
        'fleet_bringup fleet_core.files fleet_core.supervision trajectory_graph', ros=True),
    'fleet_services.nodes': layer('fleet_services node_lifecycle', ros=True, sockets='*'),
    'fleet_devices': layer(),
    'fleet_devices.core': layer('route_protocol'),
    'fleet_devices.drivers': layer('fleet_core.work fleet_devices.core'),
    'fleet_devices.commands': layer(
        'fleet_core.supervision graph_fleet_manager.commands graph_fleet_manager.messages '
        'route_protocol', ros=True),
    'fleet_devices.nodes': layer(
        'fleet_core.files fleet_core.work fleet_devices.core fleet_devices.drivers json_records '
        'node_lifecycle omron_arcl route_protocol trajectory_graph', ros=True),
    # jobs
    'omron_jobs': layer(),
    'omron_jobs.core': layer('omron_arcl'),
    'omron_jobs.client': layer(),
    'omron_jobs.network': layer(
        'browser_guard omron_arcl omron_jobs.client omron_jobs.core',
        sockets='job_port outgoing_link rest_port'),
    'omron_jobs.fleet': layer(
        'fleet_core.supervision fleet_core.work omron_jobs.core trajectory_graph'),
    'omron_jobs.day': layer(
        'file_replacement fleet_core.files fleet_core.supervision fleet_core.work fleet_simulation '
        'node_program omron_jobs.core omron_jobs.fleet trajectory_graph'),
    'omron_jobs.nodes': layer(
        'browser_guard fleet_core.files fleet_core.work fleet_requests '
        'graph_fleet_manager.messages graph_topic json_records node_lifecycle omron_jobs.client '
        'omron_jobs.core omron_jobs.fleet '
        'omron_jobs.network trajectory_graph', ros=True, sockets='job_server'),
    # graphs
    'graph_editor': layer('file_replacement graph_editor.checking graph_editor.making omron_map '
                          'trajectory_graph'),
    'graph_editor.making': layer('graph_editor trajectory_graph'),
    'graph_editor.checking': layer('graph_editor graph_editor.making trajectory_graph'),
    'graph_editor.editor': layer('trajectory_graph'),
    'graph_editor.nodes': layer(
        'graph_editor graph_editor.checking graph_editor.editor graph_editor.making '
        'node_lifecycle omron_map rviz_drawing trajectory_graph', ros=True),
    # the LD-90
    'omron_ld90': layer(),
    'omron_ld90.bridge': layer(
        'omron_arcl omron_ld90 omron_map_converter route_protocol trajectory_graph'),
    'omron_ld90.operator': layer('omron_arcl omron_ld90 omron_map route_protocol'),
    'omron_ld90.nodes': layer(
        'fleet_requests graph_topic json_records node_lifecycle omron_arcl '
        'omron_ld90 omron_ld90.bridge omron_ld90.operator omron_map omron_map_converter '
        'route_protocol rviz_drawing trajectory_graph', ros=True),
    'omron_ld90_sim': layer('omron_ld90_sim.interface'),
    'omron_ld90_sim.motion': layer('omron_map'),
    'omron_ld90_sim.devices': layer('omron_ld90_sim omron_ld90_sim.motion'),
    'omron_ld90_sim.behaviour': layer(
        'omron_map omron_ld90_sim omron_ld90_sim.motion omron_ld90_sim.devices'),
    'omron_ld90_sim.interface': layer(
        'browser_guard omron_map omron_ld90_sim omron_ld90_sim.motion omron_ld90_sim.devices '
        'omron_ld90_sim.behaviour', sockets='*'),
    # VDA 5050
    'vda5050_protocol': layer('vda5050_protocol.values'),
    'vda5050_protocol.values': layer(),
    'vda5050_mqtt': layer(sockets='link'),
    'vda5050_bench': layer('trajectory_graph vda5050_bench.rules vda5050_mqtt vda5050_protocol'),
    'vda5050_bench.rules': layer('vda5050_bench'),
    'vda5050_vehicle': layer(),
    'vda5050_vehicle.drivers': layer(
        'route_protocol trajectory_graph vda5050_protocol vda5050_protocol.values'),
    'vda5050_vehicle.core': layer(
        'json_records route_protocol vda5050_protocol vda5050_protocol.values '
        'vda5050_vehicle.drivers'),
    'vda5050_vehicle.nodes': layer(
        'file_replacement graph_topic node_lifecycle route_protocol trajectory_graph '
        'vda5050_mqtt vda5050_protocol vda5050_protocol.values vda5050_vehicle.core '
        'vda5050_vehicle.drivers', ros=True),
}


def layer_of(module: str) -> str:
    """Returns the layer of a module: `omron_ld90.bridge` for `omron_ld90.bridge.events.Link`."""
    package, _, rest = module.partition('.')
    folder = rest.split('.')[0]
    is_folder = bool(folder) and (PACKAGES[package] / folder / '__init__.py').exists()
    return f'{package}.{folder}' if is_folder else package


def files_of(name: str) -> Iterator[Path]:
    package, _, folder = name.partition('.')
    if folder:
        return (PACKAGES[package] / folder).rglob('*.py')
    return PACKAGES[package].glob('*.py')


@lru_cache(maxsize=None)
def imported_by(file: Path) -> Set[str]:
    """Returns the names of the modules that a file imports, on any line."""
    names: Set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            names.update(name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.update(f'{node.module}.{name.name}' for name in node.names)
    return names


@pytest.mark.parametrize('name', LAYERS)
def test_a_layer_imports_only_what_it_may(name: str) -> None:
    may = LAYERS[name]
    found = {}
    for file in files_of(name):
        wrong = set()
        for module in imported_by(file):
            top = module.split('.')[0]
            if top in PACKAGES:
                is_wrong = layer_of(module) not in {name, *may.ours}
            elif top in SOCKETS:
                is_wrong = not may.sockets & {'*', file.stem}
            else:
                is_wrong = not may.ros and (top in ROS or top.endswith('_msgs'))
            if is_wrong:
                wrong.add(module)
        if wrong:
            found[file.name] = sorted(wrong)
    assert found == {}


@pytest.mark.parametrize('name', LAYERS)
def test_a_layer_uses_all_that_it_may(name: str) -> None:
    """This keeps the table true, without needless entries."""
    used = {layer_of(module) for file in files_of(name) for module in imported_by(file)
            if module.split('.')[0] in PACKAGES}
    assert LAYERS[name].ours <= used


def test_every_folder_of_every_package_is_in_the_table() -> None:
    folders = {layer_of('.'.join(file.relative_to(home.parent).with_suffix('').parts))
               for home in PACKAGES.values() for file in home.rglob('*.py')}
    assert folders == set(LAYERS)
