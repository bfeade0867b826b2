"""Each launch file: documented arguments, the interface's arguments, and the resulting nodes."""
from __future__ import annotations

import re
import shlex
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from roslaunch.config import ROSLaunchConfig
from roslaunch.core import RLException
from roslaunch.loader import LoadException
from roslaunch.xmlloader import XmlLoader, XmlParseException

ROOT = Path(__file__).resolve().parents[4]
LAUNCH_FILES = sorted([*ROOT.glob('launch/*.launch'), *ROOT.glob('src/*/launch/*.launch')])
PLACES = {file.name: file for file in LAUNCH_FILES}
REFUSALS = (RLException, LoadException, XmlParseException)
#: Values for arguments that have no default, as a user would give them.
GIVEN = {
    'edit.launch': ['map_file:=/nowhere/site.map', 'graph_file:=/nowhere/graph.yaml'],
    'editor_rviz.launch': ['map_file:=/nowhere/site.map'],
    'fleet_manager.launch': ['graph_file:=/nowhere/graph.yaml', 'fleet_file:=/nowhere/fleet.yaml'],
    'job_client.launch': ['fleet_manager_ip:=10.0.0.1', 'password_file:=/nowhere/password'],
    'job_server.launch': ['password_file:=/nowhere/password'],
    'join_masters.launch': ['peer:=127.0.0.3'],
    'map_converter.launch': ['base_map:=/nowhere/base.map', 'graph_file:=/nowhere/graph.yaml',
                             'output:=/nowhere/out.map'],
    'multimaster.launch': ['peer:=127.0.0.3'],
}
CONTRACT = {'robot_name', 'sim', 'robot_ip', 'arcl_port', 'outgoing_port', 'password_file',
            'map_file', 'base_map', 'graph_file', 'strategy', 'fleet_manager', 'rviz', 'sim_speed'}


def arguments(file: Path):
    return [element for element in ElementTree.parse(file).getroot() if element.tag == 'arg']


def expand(name: str, *given: str):
    """Returns the nodes that roslaunch would start, by name, and their parameters."""
    config = ROSLaunchConfig()
    # roscore's own launch file is left out, because it runs a program for each of its parameters
    XmlLoader().load(str(PLACES[name]), config, argv=[*GIVEN.get(name, []), *given], verbose=False)
    nodes = {node.namespace + node.name: node for node in config.nodes}
    return nodes, {key: parameter.value for key, parameter in config.params.items()}


@pytest.fixture(autouse=True)
def no_display(monkeypatch):
    monkeypatch.delenv('DISPLAY', raising=False)


@pytest.mark.parametrize('file', LAUNCH_FILES, ids=lambda file: file.name)
def test_every_argument_says_what_it_is(file):
    missing = [arg.get('name') for arg in arguments(file) if not arg.get('doc')]
    assert not missing, f'{file.name}: no doc= on {missing}'


def test_each_launch_has_an_id_of_its_own_that_restarted_nodes_keep():
    name = '/omron_ld90/omron_edges_to_vertices/launch_id'
    assert len({expand('robot.launch')[1][name] for _ in range(3)}) == 3


@pytest.mark.parametrize('name, is_simulated', [
    ('full_stack.launch', 'true'), ('full_stack.launch', 'false'), ('two_robots.launch', 'true')])
def test_a_simulated_robot_begins_anew_whatever_its_ros_master_remembers(name, is_simulated):
    given = [f'sim:={is_simulated}'] if name == 'full_stack.launch' else []
    records = [value for key, value in expand(name, *given)[1].items()
               if key.endswith('/omron_edges_to_vertices/route_record')]
    robots = {'full_stack.launch': 1, 'two_robots.launch': 2}[name]
    assert records == [''] * (robots if is_simulated == 'true' else 0)


@pytest.mark.parametrize('name, is_simulated', [
    ('full_stack.launch', 'true'), ('full_stack.launch', 'false'), ('two_robots.launch', 'true')])
def test_each_start_of_a_simulator_is_a_robot_that_no_controller_remembers(name, is_simulated):
    given = [f'sim:={is_simulated}'] if name == 'full_stack.launch' else []
    ids = [tuple(value for key, value in expand(name, *given)[1].items()
                 if key.endswith('/omron_controller/robot_id')) for _ in range(2)]
    robots = {'full_stack.launch': 1, 'two_robots.launch': 2}[name]
    assert len(ids[0]) == (robots if is_simulated == 'true' else 0)
    assert not set(ids[0]) & set(ids[1])


@pytest.mark.parametrize('given, advice', [
    ([], 'command'), (['fleet_manager:=true'], 'mission'),
    (['multimaster:=true', 'peer:=10.0.0.9'], 'mission'),
    (['vda5050:=true', 'mqtt_broker:=127.0.0.1:1883'], 'nothing')])
def test_a_start_says_what_to_do_with_a_robot_that_is_ready(given, advice):
    _, values = expand('full_stack.launch', *given)
    assert [value for key, value in values.items() if key.endswith('/ready_advice')] == [advice]


@pytest.mark.parametrize('given, expected', [
    (None, '[${severity}] [${time}] ${node}: ${message}'), ('${message}', '${message}')])
def test_of_two_robots_every_line_on_the_screen_tells_whose_it_is(monkeypatch, given, expected):
    """This also holds for a fleet, see fleet_bringup. The format that a user has set is kept."""
    monkeypatch.delenv('ROSCONSOLE_FORMAT', raising=False)
    if given:
        monkeypatch.setenv('ROSCONSOLE_FORMAT', given)
    nodes, _ = expand('two_robots.launch')
    assert {name: node.env_args for name, node in nodes.items()} == {
        name: [('ROSCONSOLE_FORMAT', expected)] for name in nodes}


@pytest.mark.parametrize('file', LAUNCH_FILES, ids=lambda file: file.name)
def test_every_launch_file_expands(file):
    try:
        nodes, _ = expand(file.name)
    except REFUSALS as error:
        pytest.fail(f'{file.name}: {error}')
    assert nodes, f'{file.name} starts nothing'


@pytest.mark.parametrize('file', LAUNCH_FILES, ids=lambda file: file.name)
def test_the_interface_reference_has_every_argument_with_its_default_and_meaning(file):
    text = (ROOT / 'docs' / 'reference' / 'interface.md').read_text(encoding='utf-8')
    section = text.split(f'### `{file.name}`')[1].split('###')[0]
    rows = {name: (default, meaning) for name, default, meaning
            in re.findall(r'^\| `(\w+)` \| (.*?) \| (.*) \|$', section, re.MULTILINE)}
    assert list(rows) == [arg.get('name') for arg in arguments(file)]
    for arg in arguments(file):
        default, meaning = rows[arg.get('name')]
        assert meaning == arg.get('doc')
        set_to = arg.get('default', arg.get('value'))
        if set_to is None or not set_to.startswith('$(eval'):  # $(eval ...) is described in words
            assert default == {None: 'required', '': 'empty'}.get(set_to, f'`{set_to}`')


def test_the_full_stack_has_the_arguments_of_the_contract():
    names = {arg.get('name') for arg in arguments(PLACES['full_stack.launch'])}
    assert names >= CONTRACT


def test_the_full_stack_hands_the_settings_of_a_vda_5050_master_on():
    given = {'version': '2.0.0', 'interface_name': 'rmf2', 'manufacturer': 'ACME',
             'serial_number': '0042', 'map_id': '7', 'ignored_fields': 'theta,mapId'}
    _, parameters = expand('full_stack.launch', 'vda5050:=true', *(
        f'vda5050_{name}:={value}' for name, value in given.items()))
    adapter = '/omron_ld90/vda5050_vehicle/'
    assert {name: parameters[adapter + name] for name in given} == given
    _, by_default = expand('full_stack.launch', 'vda5050:=true', 'robot_name:=lab')
    assert by_default['/lab/vda5050_vehicle/serial_number'] == 'lab'
    assert by_default['/lab/vda5050_vehicle/version'] == '2.1.0'


def test_the_full_stack_starts_the_robot_its_simulator_and_the_visualisation():
    nodes, _ = expand('full_stack.launch')
    assert set(nodes) >= {f'/omron_ld90/{name}' for name in (
        'ld90_sim', 'omron_controller', 'omron_connection_receiver', 'omron_edges_to_vertices',
        'map_visualisation', 'robot_state_publisher', 'goal_sender')}
    assert '/omron_ld90/rviz' not in nodes, 'without a display RViz must not start'


def test_rviz_starts_where_there_is_a_display(monkeypatch):
    monkeypatch.setenv('DISPLAY', ':7')
    nodes, _ = expand('full_stack.launch')
    assert '/omron_ld90/rviz' in nodes


def test_a_real_robot_gets_no_simulator():
    nodes, parameters = expand('full_stack.launch', 'sim:=false', 'robot_ip:=10.0.0.5')
    assert '/omron_ld90/ld90_sim' not in nodes
    assert parameters['/omron_ld90/omron_controller/robot_ip'] == '10.0.0.5'
    assert parameters['/omron_ld90/omron_controller/password_file'] == ''


def test_both_sides_of_joined_masters_read_one_list_of_what_crosses():
    sides = [expand('full_stack.launch', 'multimaster:=true', 'peer:=10.0.0.9'),
             expand('fleet_manager.launch', 'multimaster:=true', 'peer:=10.0.0.5',
                    f'fleet_file:={ROOT}/maps/lab_fleet.yaml')]
    robot, fleet = (parameters for _, parameters in sides)
    assert robot['/master_sync/sync_topics'] == fleet['/master_sync/sync_topics']
    assert '/*/target_route' in fleet['/master_sync/sync_topics']
    assert robot['/master_discovery/robot_hosts'] == ['10.0.0.9']
    assert fleet['/master_discovery/robot_hosts'] == ['10.0.0.5']


def test_where_masters_are_joined_only_the_fleets_side_has_a_fleet_manager():
    nodes, _ = expand('full_stack.launch', 'fleet_manager:=true', 'multimaster:=true',
                      'peer:=10.0.0.9')
    assert not {'/path_supervisor', '/path_planner', '/graph_server'} & set(nodes)


def test_masters_are_not_joined_with_nobody(capfd):
    with pytest.raises(REFUSALS):
        expand('full_stack.launch', 'multimaster:=true')
    assert 'set peer:=ADDRESS' in capfd.readouterr().err


def test_the_bridge_of_a_real_robot_remembers_its_route_over_a_restart_of_the_computer():
    _, simulated = expand('full_stack.launch')
    assert simulated[f'{BRIDGE}/route_file'] == ''
    _, real = expand('full_stack.launch', 'sim:=false', 'robot_ip:=10.0.0.5', 'robot_name:=r')
    assert real['/r/omron_edges_to_vertices/route_file'] == 'omron_ld90/r_route.json'


LAB = ROOT / 'maps' / 'lab.map'
BRIDGE, ROUTES = '/omron_ld90/omron_edges_to_vertices', '/omron_ld90/route_visualisation'


def graph_and_dock(*given: str):
    """Returns the graph and the dock of the bridge for these arguments.

    The nodes that show the routes must have the same graph and dock.
    """
    _, parameters = expand('full_stack.launch', *given)
    bridge, shown = ((parameters[f'{node}/graph_file'], parameters[f'{node}/dock_vertex'])
                     for node in (BRIDGE, ROUTES))
    assert bridge == shown, 'the route is shown on another graph than it is driven on'
    return bridge


def test_the_lab_map_comes_with_its_graph_and_dock():
    graph, dock = graph_and_dock()
    assert Path(graph).samefile(ROOT / 'maps' / 'lab_graph.yaml')
    assert dock == 16


def test_the_lab_map_is_known_by_its_path_in_the_repository_too():
    assert graph_and_dock(f'map_file:={LAB}') == graph_and_dock()


@pytest.mark.parametrize('site', ['/site/other.map', '/site/maps/lab.map', '/lab.map',
                                  '/site/omron_ld90/maps/lab.map'])
def test_another_map_inherits_neither_graph_nor_dock(site):
    assert graph_and_dock(f'map_file:={site}') == ('', 0)


def test_another_graph_does_not_inherit_the_dock():
    assert graph_and_dock('graph_file:=/site/graph.yaml') == ('/site/graph.yaml', 0)
    site = ['map_file:=/site/other.map', 'graph_file:=/site/maps/lab_graph.yaml']
    assert graph_and_dock(*site) == ('/site/maps/lab_graph.yaml', 0)
    assert graph_and_dock(*site, 'dock_vertex:=7')[1] == 7


def test_the_lab_graph_brings_its_dock_to_a_map_made_from_it():
    graph = ROOT / 'maps' / 'lab_graph.yaml'
    made = [f'base_map:={ROOT}/maps/lab_base.map', 'map_file:=/tmp/out.map', f'graph_file:={graph}']
    assert graph_and_dock(*made) == (str(graph), 16)
    _, parameters = expand('full_stack.launch', *made)
    assert parameters['/omron_ld90/omron_ros_map/dock_vertex'] == 16


def test_two_robots_on_another_map_inherit_neither_graph_nor_dock():
    for given, expected in (([], 16), (['map_file:=/site/other.map'], 0)):
        _, parameters = expand('two_robots.launch', *given)
        for robot in ('robot_a', 'robot_b'):
            for node in ('omron_edges_to_vertices', 'route_visualisation'):
                assert parameters[f'/{robot}/{node}/dock_vertex'] == expected
                assert bool(parameters[f'/{robot}/{node}/graph_file']) is bool(expected)


@pytest.mark.parametrize('name', ['robot.launch', 'visualisation.launch', 'map_converter.launch'])
def test_the_parts_of_the_stack_know_no_dock_of_their_own(name):
    _, parameters = expand(name, 'graph_file:=/site/graph.yaml')
    assert not [key for key, value in parameters.items()
                if key.endswith('/dock_vertex') and value != 0]


def test_a_base_map_brings_the_converter_and_makes_the_others_wait():
    nodes, parameters = expand('full_stack.launch', 'base_map:=/site/base.map',
                               'map_file:=/site/out.map', 'graph_file:=/site/graph.yaml')
    assert '/omron_ld90/omron_ros_map' in nodes
    assert parameters['/omron_ld90/omron_ros_map/output'] == '/site/out.map'
    assert parameters['/omron_ld90/map_visualisation/base_map'] == '/site/base.map'
    simulator = shlex.split(nodes['/omron_ld90/ld90_sim'].args)
    after = simulator.index('--made-from') + 1
    assert simulator[after:after + 2] == ['/site/base.map', '/site/graph.yaml']


def test_a_graph_without_dock_is_said_by_zero():
    name = '/omron_ld90/omron_ros_map/dock_vertex'
    assert expand('map_converter.launch', 'dock_vertex:=7')[1][name] == 7
    assert name not in expand('map_converter.launch', 'dock_vertex:=0')[1]


def test_a_file_name_may_hold_blanks():
    nodes, _ = expand('full_stack.launch', 'map_file:=/my maps/out.map',
                      'base_map:=/my maps/base.map', 'graph_file:=/my maps/graph.yaml',
                      'password_file:=/my maps/secret')
    simulator = shlex.split(nodes['/omron_ld90/ld90_sim'].args)
    for name in ('out.map', 'base.map', 'graph.yaml', 'secret'):
        assert f'/my maps/{name}' in simulator


def test_no_password_is_a_parameter_or_an_argument_of_a_process():
    nodes, parameters = expand('full_stack.launch')
    password = (ROOT / 'src/omron_ld90_sim/config/simulator_password').read_text().strip()
    assert password not in [str(value) for value in parameters.values()]
    assert not [node.name for node in nodes.values() if f' {password}' in node.args]


def test_another_robot_name_moves_every_node():
    nodes, _ = expand('full_stack.launch', 'robot_name:=robot7')
    assert {name.split('/')[1] for name in nodes} == {'robot7'}


#: For each program, those topics of RViz's tools to which it subscribes.
TOOLS = {
    'omron_controller': ('move_base_simple/goal', 'initialpose'), 'goal_sender': ('clicked_point',),
    'route_visualisation': ('move_base_simple/goal',), 'vda5050_vehicle': ('initialpose',),
    'rviz_view': ('clicked_point', 'move_base_simple/goal', 'initialpose')}


def tools_of(name: str, *given: str):
    """Returns the resolved names of the tools' topics, by node."""
    called = {}
    for path, node in expand(name, *given)[0].items():
        namespace = path.rsplit('/', 1)[0]
        renamed = {old if old.startswith('/') else f'{namespace}/{old}':
                   new if new.startswith('/') else f'{namespace}/{new}'
                   for old, new in node.remap_args}
        for topic in TOOLS.get(node.type, ()):
            called.setdefault(path, set()).add(renamed.get(f'{namespace}/{topic}',
                                                           f'{namespace}/{topic}'))
    return called


@pytest.mark.parametrize('file', LAUNCH_FILES, ids=lambda file: file.name)
def test_only_the_full_stack_listens_to_tools_of_everybody(file):
    called = {topic for topics in tools_of(file.name).values() for topic in topics}
    everybodys = {topic for topic in called if topic.lstrip('/') in sum(TOOLS.values(), ())}
    assert everybodys == (called if file.name == 'full_stack.launch' else set())


def test_both_ends_of_each_tool_have_one_name_in_the_full_stack():
    called = tools_of('full_stack.launch', 'vda5050:=true', 'rviz:=true', 'robot_name:=lab')
    assert set(called) == {f'/lab/{name}' for name in (
        'omron_controller', 'goal_sender', 'route_visualisation', 'vda5050_vehicle', 'rviz')}
    assert called['/lab/vda5050_vehicle'] <= called['/lab/omron_controller']
    assert called['/lab/rviz'] == (called['/lab/omron_controller'] | called['/lab/goal_sender'])


def test_rviz_on_another_computer_speaks_to_a_full_stack():
    assert tools_of('rviz.launch', 'tools:=/') == {'/omron_ld90/rviz': {
        '/clicked_point', '/move_base_simple/goal', '/initialpose'}}


BRINGUP = ('full_stack', 'multimaster', 'sim', 'steps', 'two_robots', 'vda5050')


@pytest.mark.parametrize('file', LAUNCH_FILES, ids=lambda file: file.name)
def test_the_package_of_a_launch_file_depends_on_all_that_it_starts(file):
    owner = file.parents[1].name if 'src' in file.parts[-4:] else (
        'ld90_bringup' if file.stem in BRINGUP else 'omron_ld90')
    package = ElementTree.parse(ROOT / 'src' / owner / 'package.xml').getroot()
    depends = {element.text for element in package.iter('exec_depend')} | {owner}
    text = re.sub(r'<!--.*?-->', '', file.read_text(), flags=re.DOTALL)
    started = set(re.findall(r'\$\(find (\w+)\)', text)) | set(re.findall(r'pkg="(\w+)"', text))
    assert {name for name in started if (ROOT / 'src' / name).exists()} <= depends


def test_the_driver_depends_neither_on_simulator_nor_on_adapter():
    package = ElementTree.parse(ROOT / 'src' / 'omron_ld90' / 'package.xml').getroot()
    depends = {element.text for element in package.iter('exec_depend')}
    assert not depends & {'omron_ld90_sim', 'vda5050_vehicle', 'graph_fleet_manager'}
    for file in (ROOT / 'src' / name / 'CMakeLists.txt' for name in ('omron_ld90', 'ld90_bringup')):
        assert f'/({"|".join(BRINGUP)})[.]launch$' in file.read_text()


AWKWARD = "/my robots/l'atelier"
_PATHS = re.compile(r'\$\((?:find [a-z0-9_]+|arg [a-z_]*(?:_file|_map|_config))\)')


@pytest.mark.parametrize('file', LAUNCH_FILES, ids=lambda file: file.name)
def test_a_path_with_a_blank_or_an_apostrophe_stays_one_word(file):
    """roslaunch splits these attributes as a shell does."""
    for element in ElementTree.parse(file).iter():
        lines = [element.get('args', '')]
        if element.tag == 'param':
            lines.append(element.get('command', ''))
        for line in lines:
            told = _PATHS.sub(AWKWARD, line)
            words = [word for word in shlex.split(told) if AWKWARD in word]
            assert len(words) == len(_PATHS.findall(line)), line


@pytest.mark.parametrize('name', ['robot.launch', 'visualisation.launch', 'fleet_manager.launch'])
def test_the_program_that_stands_for_a_fork_may_lie_anywhere(name):
    nodes, _ = expand(name, 'hosted:=true', f'hosted_by:={AWKWARD}/hosted')
    prefixes = [node.launch_prefix for node in nodes.values() if node.launch_prefix]
    assert len(prefixes) >= 3
    assert {tuple(shlex.split(prefix)) for prefix in prefixes} == {(f'{AWKWARD}/hosted',)}


def test_the_program_that_stands_for_a_fork_is_found():
    nodes, _ = expand('robot.launch', 'hosted:=true')
    program, = {shlex.split(node.launch_prefix)[0] for node in nodes.values()
                if node.launch_prefix}
    assert Path(program).is_file()


def test_the_simulator_gets_any_name_of_a_map(tmp_path):
    nodes, _ = expand('sim.launch', f'map_file:={AWKWARD}.map', f'base_map:={AWKWARD}_base.map',
                      f'graph_file:={AWKWARD}.yaml')
    words = shlex.split(nodes['/omron_ld90/ld90_sim'].args)
    assert words[words.index('--map') + 1] == f'{AWKWARD}.map'
    made_from = words.index('--made-from')
    assert words[made_from + 1:made_from + 3] == [f'{AWKWARD}_base.map', f'{AWKWARD}.yaml']
