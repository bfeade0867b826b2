"""A number or a fleet file becomes launch and RViz files; needs a ROS workspace."""
from __future__ import annotations

import shlex
import socket
import warnings
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml
from bringup_builders import fleet_file
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

pytest.importorskip('rospkg')

from fleet_bringup.command import laboratory_folder, main, prepare  # noqa: E402
from fleet_bringup.errors import CannotStart  # noqa: E402
from fleet_bringup.options import parse  # noqa: E402
from fleet_bringup.ports import check_ports, is_taken  # noqa: E402
from fleet_core.files.errors import FileError  # noqa: E402
from fleet_core.files.fleet_file import load_fleet  # noqa: E402
from fleet_core.files.work_file import load_work  # noqa: E402
from trajectory_graph import load_graph  # noqa: E402


@pytest.fixture(scope='module')
def made(tmp_path_factory):
    folder = str(tmp_path_factory.mktemp('fleet'))
    with warnings.catch_warnings():
        # a user would see such a warning and would not understand it
        warnings.simplefilter('error', RuntimeWarning)
        return prepare(parse(['fleet:=2', 'longest_edge:=1.5', 'rviz:=true', 'demo:=true']),
                       folder, check=False)


def test_a_number_makes_so_many_of_both_kinds_on_places_of_their_own(made):
    fleet = load_fleet(made['fleet'])
    assert [robot.name for robot in fleet.robots] == ['ld90_1', 'ld90_2', 'agv_1', 'agv_2']
    assert len({robot.vertex for robot in fleet.robots}) == 4
    graph = load_graph(Path(made['fleet']).with_name('graph.yaml'))
    assert all(graph.vertices[robot.vertex].parking is not False for robot in fleet.robots)


def test_the_graph_is_cut_for_all_alike(made):
    graph_file = str(Path(made['fleet']).with_name('graph.yaml'))
    graph = load_graph(graph_file)
    assert max(graph.curve(id).length for id in graph.edges) <= 1.5 + 1e-6
    values = [one.get('value') for one in ET.parse(made['launch']).iter()
              if one.get('name') == 'graph_file']
    assert set(values) == {graph_file}
    assert len(values) == 4  # two bridges, the AGVs, the fleet manager


def test_every_ld90_has_its_stack_and_its_place(made):
    root = ET.parse(made['launch']).getroot()
    names = [one.get('value') for include in root.findall('include')
             if include.get('file').endswith('robot.launch')
             for one in include.findall('arg') if one.get('name') == 'robot_name']
    assert names == ['ld90_1', 'ld90_2']
    simulated = yaml.safe_load(Path(made['robots']).read_text())['robots']
    assert [one['outgoing'] for one in simulated] == ['127.0.0.1:7179', '127.0.0.1:7189']
    graph = load_graph(Path(made['fleet']).with_name('graph.yaml'))
    for robot, row in zip(load_fleet(made['fleet']).robots, simulated):
        assert row['start'][:2] == pytest.approx(graph.vertices[robot.vertex].position, abs=0.001)


def test_no_controller_remembers_what_a_simulated_robot_did_at_an_earlier_start(made):
    def ids():
        config = ROSLaunchConfig()
        XmlLoader().load(made['launch'], config, argv=[], verbose=False)
        return [config.params[f'/{name}/omron_controller/robot_id'].value
                for name in ('ld90_1', 'ld90_2')]
    assert not set(ids()) & set(ids())


def test_every_line_on_the_screen_tells_which_robot_says_it(made, monkeypatch):
    monkeypatch.delenv('ROSCONSOLE_FORMAT', raising=False)
    config = ROSLaunchConfig()
    XmlLoader().load(made['launch'], config, argv=[], verbose=False)
    forms = {node.namespace + node.name: dict(node.env_args).get('ROSCONSOLE_FORMAT')
             for node in config.nodes}
    assert '/ld90_1/omron_controller' in forms and '/rviz' in forms
    assert set(forms.values()) == {'[${severity}] [${time}] ${node}: ${message}'}


def test_no_password_stands_in_the_launch_file(made):
    word = Path(made['simulator_password']).read_text().strip()
    assert f'"{word}"' not in Path(made['launch']).read_text()


def test_a_fleet_of_agvs_needs_nothing_of_the_ld90(tmp_path):
    path = fleet_file(tmp_path, 'name: a, type: agv, vertex: 6, driver: agv')
    files = prepare(parse([f'fleet:={path}', 'rviz:=true']), str(tmp_path), check=False)
    assert 'omron_ld90_sim' not in Path(files['launch']).read_text()
    assert 'robots' not in files


def nodes_of(launch: str) -> dict:
    return {node.get('name'): {one.get('name'): one.get('value') for one in node.iter('param')}
            for node in ET.parse(launch).getroot().iter('node')}


@pytest.mark.parametrize('more', [[], ['longest_edge:=1.5']])
def test_the_work_of_the_laboratory_comes_with_its_doors_and_a_plc(tmp_path, more):
    files = prepare(parse(['fleet:=4', 'work:=true', 'sim_speed:=2', 'rviz:=false', *more]),
                    str(tmp_path), check=False)
    nodes = nodes_of(files['launch'])
    assert nodes['plc_sim']['seconds'] == nodes['fleet_devices']['simulated_travel'] == '1.5'
    assert nodes['fleet_devices']['graph_file'] == str(tmp_path / 'graph.yaml')
    assert nodes['fleet_devices']['memory_file'] == files['device_memory']
    assert nodes['fleet_devices']['steps_file'] == files['device_steps']
    work = nodes['fleet_devices']['work_file']
    assert f'name="work_file" value="{work}"' in Path(files['launch']).read_text()
    found = load_work(work, load_graph(tmp_path / 'graph.yaml'))
    assert (len(found.devices), len(found.stations)) == (2, 3)


def test_a_work_file_starts_its_devices_but_no_plc(tmp_path):
    work, path = tmp_path / 'work.yaml', fleet_file(tmp_path, 'name: a, type: agv, vertex: 6, '
                                                    'driver: agv')
    work.write_text('stations:\n- {name: press, places: [18]}\n')
    words = [f'fleet:={path}', f'work_file:={work}', 'rviz:=false']
    assert 'fleet_devices' not in nodes_of(prepare(parse(words), str(tmp_path), False)['launch'])
    work.write_text('devices:\n- {name: a, kind: door, edges: [17], timeout: 5, '
                    'driver: simulated}\n')
    nodes = nodes_of(prepare(parse(words), str(tmp_path), False)['launch'])
    assert 'fleet_devices' in nodes and 'plc_sim' not in nodes
    work.write_text('devices:\n- {name: a, kind: door, edges: [17]}\n')
    with pytest.raises(FileError, match='line 2'):
        prepare(parse(words), str(tmp_path), check=False)


@pytest.mark.parametrize(('options', 'says'), [
    ([], None), (['page:=false'], 'true'), (['page:=false', 'fleet_manager:=false'], 'false')])
def test_one_node_says_what_is_ready_the_page_or_else_the_node_of_rviz(tmp_path, options, says):
    files = prepare(parse(['fleet:=1', 'rviz:=false', *options]), str(tmp_path), check=False)
    nodes = nodes_of(files['launch'])
    assert ('fleet_page' in nodes) is (says is None)
    assert nodes['fleet_visualisation'].get('says_ready') == says


@pytest.mark.parametrize('other', ['work_file:=work.yaml', 'graph_file:=graph.yaml'])
def test_the_work_of_the_laboratory_is_for_the_laboratory(other):
    with pytest.raises(CannotStart, match='work:=true is the work of the laboratory'):
        parse(['fleet:=4', 'work:=true', other])


def test_more_robots_than_the_graph_can_park_are_told(tmp_path, capsys):
    assert main(['fleet:=9']) == 1
    sentence = capsys.readouterr().err.strip()
    assert 'fleet:=9 gives 18 robots, but the graph has places for' in sentence
    assert len(sentence.splitlines()) == 1


def test_a_vertex_that_the_graph_lacks_is_told(tmp_path):
    path = fleet_file(tmp_path, 'name: a, type: agv, vertex: 999, driver: agv')
    with pytest.raises(CannotStart, match='robot a stands on vertex 999'):
        prepare(parse([f'fleet:={path}']), str(tmp_path), check=False)


def test_a_graph_of_ones_own_needs_a_map_of_ones_own(tmp_path):
    path = fleet_file(tmp_path, 'name: a, type: ld90, vertex: 6, driver: ld90')
    graph = Path(__file__).parents[4] / 'maps' / 'lab_graph.yaml'
    with pytest.raises(CannotStart, match='base_map:='):
        prepare(parse([f'fleet:={path}', f'graph_file:={graph}']), str(tmp_path), check=False)


def test_a_port_that_is_taken_is_told():
    with socket.socket() as other:
        other.bind(('127.0.0.1', 0))
        other.listen(1)
        port = other.getsockname()[1]
        assert is_taken(port)
        with pytest.raises(CannotStart, match=f'TCP port {port} .* is in use'):
            check_ports([(port, 'arcl_port of ld90_1')])


def test_one_port_for_two_is_told():
    with pytest.raises(CannotStart, match='each needs its own'):
        check_ports([(17999, 'arcl_port of a'), (17999, 'outgoing_port of a')])


@pytest.mark.parametrize(('folder', 'expected'), [
    ('share/omron_ld90', 'share/omron_ld90/maps'), ('src/omron_ld90', 'src/omron_ld90/../../maps')])
def test_the_laboratory_is_found_among_sources_and_where_it_is_installed(
        tmp_path, folder, expected):
    (tmp_path / 'maps').mkdir()
    (tmp_path / 'share/omron_ld90/maps').mkdir(parents=True)
    found = laboratory_folder(str(tmp_path / folder))
    assert found == str(tmp_path) + '/' + expected


def test_paths_with_blanks_and_apostrophes_stay_words_of_the_generated_launch_file(tmp_path):
    folder = tmp_path / "my robots" / "l'atelier"
    folder.mkdir(parents=True)
    launch = prepare(parse(['fleet:=2', 'rviz:=true']), str(folder), check=False)
    told = {Path(word).name for node in ET.parse(launch['launch']).iter('node')
            for word in shlex.split(node.get('args', '')) if word.startswith(str(folder))}
    assert {'robots.yaml', 'fleet.rviz'} <= told
    prefixes = {node.get('launch-prefix') for node in ET.parse(launch['launch']).iter('node')}
    for prefix in prefixes - {None}:
        assert shlex.split(prefix.replace('$(arg hosted_by)', str(folder))) == [str(folder)]


@pytest.mark.parametrize('what', ['host: "$(eval 1 + 1)"', 'password_file: "a$(find roslaunch)"'])
def test_no_text_of_a_file_is_evaluated_by_roslaunch(tmp_path, what):
    (tmp_path / 'a$(find roslaunch)').write_text('adept')
    (tmp_path / 'password').write_text('adept')
    more = 'password_file: password' if what.startswith('host') else 'host: 10.0.0.5'
    path = fleet_file(tmp_path, f'name: a, type: ld90, vertex: 18, driver: ld90, {what}, {more}')
    with pytest.raises(CannotStart, match='roslaunch would evaluate'):
        prepare(parse([f'fleet:={path}', 'rviz:=false']), str(tmp_path), check=False)


def test_a_name_with_blanks_and_quotes_is_one_word(tmp_path):
    folder = tmp_path / "it's a \"site\""
    folder.mkdir()
    launch = prepare(parse(['fleet:=1', 'rviz:=true']), str(folder), check=False)['launch']
    nodes = {node.get('name'): node for node in ET.parse(launch).getroot().iter('node')}
    for name, file in (('ld90_sim', 'robots.yaml'), ('rviz', 'fleet.rviz')):
        assert str(folder / file) in shlex.split(nodes[name].get('args'))
