"""The RViz configurations and the URDF are complete and correct."""
from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import yaml

REPOSITORY = Path(__file__).resolve().parents[4]
URDF = REPOSITORY / 'src/omron_ld90/urdf/ld90.urdf'


def configuration(name: str) -> dict:
    return yaml.safe_load((REPOSITORY / 'rviz' / name).read_text())['Visualization Manager']


def topics(node) -> list:
    """Returns all topics and parameters that displays and tools name, at any depth."""
    if isinstance(node, list):
        return [topic for item in node for topic in topics(item)]
    if not isinstance(node, dict):
        return []
    named = [node[key] for key in ('Topic', 'Marker Topic', 'Update Topic', 'Robot Description')
             if isinstance(node.get(key), str)]
    return named + [topic for value in node.values() for topic in topics(value)]


def test_every_topic_is_relative_so_that_the_namespace_chooses_the_robot():
    one = configuration('omron_ld90.rviz')
    absolute = [topic for topic in topics(one) if topic.startswith('/')]
    assert topics(one)
    assert absolute == []


def test_the_displays_of_the_contract_are_there():
    shown = set(topics(configuration('omron_ld90.rviz')))
    assert shown >= {
        'map', 'map_markers/points', 'map_markers/lines', 'map_markers/goals', 'map_markers/docks',
        'map_markers/goal_names', 'map_markers/goal_headings', 'map_markers/forbidden_areas',
        'map_markers/sectors', 'laser_markers', 'graph_markers', 'route_markers', 'status_markers',
        'driven_path', 'feedback_markers', 'interactive_goals/update', 'robot_description',
        'clicked_point', 'move_base_simple/goal', 'initialpose'}


def test_no_tool_of_two_robots_is_shared():
    tools = topics(configuration('two_robots.rviz')['Tools'])
    assert len(tools) == len(set(tools)) == 6
    assert {topic.split('/')[1] for topic in tools} == {'robot_a', 'robot_b'}


def test_of_two_robots_each_shows_what_one_robot_alone_shows():
    shown = topics(configuration('two_robots.rviz'))
    for robot in ('robot_a', 'robot_b'):
        own = {topic.split('/', 2)[2] for topic in shown if topic.startswith(f'/{robot}/')}
        alone = set(topics(configuration('omron_ld90.rviz')))
        missing = {topic for topic in alone - own
                   if topic != 'map' and topic != 'graph_markers' and 'map_markers' not in topic}
        assert missing == set(), robot


def test_the_view_opens_top_down_and_draws_ten_times_a_second():
    one = configuration('omron_ld90.rviz')
    assert one['Views']['Current']['Class'] == 'rviz/TopDownOrtho'
    assert one['Global Options']['Frame Rate'] == 10


def test_links_carry_the_robots_name_and_hang_together():
    robot = ElementTree.parse(URDF).getroot()
    links = {link.get('name') for link in robot.iter('link')}
    children = {joint.find('child').get('link') for joint in robot.iter('joint')}
    assert all(name.startswith('omron_ld90/') for name in links)
    assert links - children == {'omron_ld90/base_link'}
