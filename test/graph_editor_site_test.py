#!/usr/bin/env python3
"""From a map without a graph to a robot that drives: a graph is made, edited in RViz, and used."""
from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Callable, List, Sequence, Tuple

import numpy as np
import rospy
from route_robot import FleetManager, state_list
from rviz_support import RvizWindow, Screen, close_to, missing_programs
from std_msgs.msg import String

from graph_editor.editor.actions import EDGE_MENU, VERTEX_MENU, Action
from graph_editor.nodes.view import fitted
from graph_editor.site import SiteOptions, load_site
from itrci_nav_msgs.msg import EdgeState
from itrci_nav_msgs.msg import Graph as GraphMessage
from omron_map import MapDocument
from system_support import Launched, Recorder, run_cases, wait_until
from trajectory_graph import Graph, load_graph
from trajectory_graph.messages import graph_from_message
from trajectory_graph.shortest_paths import shortest_route

ROOT = Path(__file__).resolve().parents[1]
STATION_SIDE = '--dock=-13.2,-7.0,180'  # position of the laboratory's charger
SPEED = 12
LONG = bool(os.environ.get('LD90_LONG_TESTS'))
FAR = 5 if LONG else 2  # vertices to drive to, in addition to the new vertex and the dock
MIDDLE = (640, 466)  # pixel of the middle of the 3D view
NEW_PLACE = (1.2, 6.2)  # m; a place where the made graph has no vertex
IN_THE_WALL = (1.9, 1.26)
RED = (230, 13, 13)


class NewSite(unittest.TestCase):
    """Three steps of one story, in this order. The second step needs --long."""

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('graph_editor_site_test')
        cls.folder = tempfile.TemporaryDirectory()
        cls.map_file = Path(cls.folder.name) / 'site.map'
        cls.graph_file = Path(cls.folder.name) / 'site_graph.yaml'
        shutil.copy(ROOT / 'maps' / 'lab_base.map', cls.map_file)
        cls.new_vertex = None

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    def new_site(self) -> str:
        """Returns the output of scripts/new_site.sh for the site."""
        made = subprocess.run(
            [str(ROOT / 'scripts' / 'new_site.sh'), str(self.map_file), STATION_SIDE, '--no-start'],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120, check=False, text=True)
        self.assertEqual(made.returncode, 0, made.stdout)
        return made.stdout

    def test_1_a_map_becomes_a_graph_and_a_map_with_fences(self) -> None:
        printed = self.new_site()
        for command in ('make_graph --map', 'omron_ros_map --graph', 'run.sh map_file:='):
            self.assertIn(command, printed)
        self.check_fences()
        load_graph(self.graph_file)

    def check_fences(self) -> None:
        fences = [area for area in MapDocument.load(f'{self.folder.name}/site_fleet.map'
                                                    ).forbidden_areas if area.description]
        self.assertGreater(len(fences), 20, 'the map has the fences of the graph')

    @unittest.skipUnless(LONG, 'of the tests in RViz only rviz runs without --long')
    def test_2_the_graph_is_edited_in_rviz_by_mouse(self) -> None:
        missing = missing_programs()
        if missing:
            self.skipTest(f'not installed: {", ".join(missing)}')
        before = self.graph_file.read_text().splitlines()
        with Editor(self.map_file, self.graph_file) as editor:
            vertex, edge = editor.add_a_vertex_and_connect_it()
            editor.drag_it_into_a_wall_and_undo(vertex)
            editor.drag(vertex)
            editor.delete_an_edge_and_undo(edge)
            editor.save()
            editor.drag_and_load_again(vertex)
        graph = load_graph(self.graph_file)
        self.assertIn(vertex, graph.vertices)
        self.assertIn(edge, graph.edges)
        after = self.graph_file.read_text().splitlines()
        self.assertEqual([line for line in after if line in before], before,
                         'every line that was there is there')
        self.assertEqual(len(after), len(before) + 2)
        type(self).new_vertex = vertex

    def test_3_the_robot_visits_far_vertices_and_docks(self) -> None:
        if self.new_vertex is not None:
            self.assertIn('was edited and is used as it is', self.new_site())
            self.check_fences()
        drive_to_far_vertices(self, Path(self.folder.name) / 'site_fleet.map', self.graph_file,
                              [self.new_vertex] if self.new_vertex is not None else [])


class RealSite(unittest.TestCase):
    """The same steps on the maps of real robots, if there are any; only with --long."""

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('graph_editor_site_test')

    def test_a_robot_drives_on_the_graphs_of_real_maps(self) -> None:
        maps = sorted(Path(os.environ.get('LD90_REAL_MAPS') or '/nowhere').glob('*.map'))
        if not maps or not LONG:
            self.skipTest('maps of real robots are driven on with --long and LD90_REAL_MAPS')
        for map_file in maps:
            with self.subTest(map=map_file.name), tempfile.TemporaryDirectory() as folder:
                copy = Path(folder) / 'site.map'
                shutil.copy(map_file, copy)
                subprocess.run([str(ROOT / 'scripts' / 'new_site.sh'), str(copy), '--no-start'],
                               check=True, timeout=200, stdout=subprocess.DEVNULL)
                drive_to_far_vertices(self, Path(folder) / 'site_fleet.map',
                                      Path(folder) / 'site_graph.yaml')


def drive_to_far_vertices(case: unittest.TestCase, map_file: Path, graph_file: Path,
                          more: Sequence[int] = ()) -> None:
    """Drives to far vertices and to `more`, and back into the dock if there is one."""
    graph = load_graph(graph_file)
    docks = [vertex.id for vertex in graph.vertices.values() if vertex.dock]
    start = docks[0] if docks else None
    with Launched('full_stack.launch', map_file=map_file, graph_file=graph_file,
                  dock_vertex=start or 0, sim_speed=SPEED, rviz='false',
                  arcl_port=os.environ['LD90_ARCL_PORT'],
                  outgoing_port=os.environ['LD90_OUTGOING_PORT']):
        fleet = FleetManager()
        if start is None:  # the fleet manager gets the place from the simulated robot
            wait_until(lambda: fleet.status.messages, 60, 'a status of the robot')
            place = fleet.status.messages[-1].pose.position
            start = min(graph.vertices, key=lambda id: math.dist(graph.vertices[id].position,
                                                                 (place.x, place.y)))
        far = far_vertices(graph, start, min(FAR, len(graph.vertices) - 1))
        here = start
        for there in [*far, *more, start]:
            if here == there:
                continue
            route = list(shortest_route(graph, (here, there)))
            done = fleet.end_of(fleet.order(route))
            case.assertEqual(state_list(done), [EdgeState.COMPLETE] * len(route),
                             f'{here} to {there}: {done.reason}')
            here = there
        if docks:
            wait_until(lambda: fleet.status.messages[-1].docking_state == 'Docked', 20,
                       'a status of the docked robot')
        places = [status.pose.position for status in fleet.status.messages]
    farthest = max(graph.nearest_edge(place.x, place.y)[1].distance for place in places)
    case.assertLess(farthest, 0.45, 'the robot stays in the corridors')


class Editor:
    """The editor on a screen of its own, which the mouse operates."""

    def __init__(self, map_file: Path, graph_file: Path) -> None:
        self._files = {'map_file': map_file, 'graph_file': graph_file}
        artefacts = os.environ.get('SYSTEM_TEST_ARTEFACTS', '/tmp')
        self._graphs = Recorder('/graph_editor/graph', GraphMessage)
        self._words = Recorder('/graph_editor/words', String)
        self._node = Launched('edit.launch', package='graph_editor', rviz='false', window='false',
                              **self._files)
        self._screen = Screen()
        configuration = fitted((ROOT / 'src/graph_editor/rviz/graph_editor.rviz').read_text(),
                               load_site(str(map_file), SiteOptions()).floor)
        scale, x, y = (float(re.search(rf'(?m)^      {name}: (\S+)$', configuration)[1])
                       for name in ('Scale', 'X', 'Y'))
        self._window = RvizWindow(self._screen, artefacts, scale, 'graph_editor',
                                  'editor_rviz.launch', f'map_file:={map_file}')
        nothing = (0.8, -2.6)  # m: a place without handles
        self._window.calibrate((round(MIDDLE[0] + (nothing[0] - x) * scale),
                                round(MIDDLE[1] - (nothing[1] - y) * scale)), nothing)

    def __enter__(self) -> Editor:
        self.graph()
        return self

    def __exit__(self, *_: object) -> None:
        self._window.close()
        self._screen.close()
        self._node.__exit__()

    def graph(self) -> Graph:
        """Returns the last graph on graph_editor/graph."""
        self._graphs.wait_for(lambda message: True, 60.0, 'graph')
        return graph_from_message(self._graphs.messages[-1])

    def add_a_vertex_and_connect_it(self) -> Tuple[int, int]:
        """Clicks on the floor, then in a menu, then on a vertex. Returns the ids of the new vertex
        and edge.
        """
        graph = self.graph()
        near = min(graph.vertices.values(),
                   key=lambda vertex: math.dist(vertex.position, NEW_PLACE))
        self._window.tool('c')
        self._window.click(self._window.pixel(*NEW_PLACE))
        self._heard('Add vertex')
        vertex = max(graph.vertices) + 1
        self._window.wait_for_picture('graph_editor_unconnected', self._red_near(*NEW_PLACE))
        self._choose(NEW_PLACE, VERTEX_MENU, Action.CONNECT)
        self._heard('Click the vertex to connect')
        self._window.click_handle(self._window.pixel(*near.position))
        graph = self._graph_with(lambda graph: vertex in graph.vertices, 'the new vertex')
        edge, = graph.edges_at(vertex)
        assert {graph.edges[edge].origin, graph.edges[edge].destination} == {vertex, near.id}
        return vertex, edge

    def drag_it_into_a_wall_and_undo(self, vertex: int) -> None:
        self._window.drag_handle(self._window.pixel(*NEW_PLACE), self._window.pixel(*IN_THE_WALL))
        self._graph_with(lambda graph: math.dist(graph.vertices[vertex].position, IN_THE_WALL)
                         < 0.15, 'the vertex in the wall')
        self._window.wait_for_picture('graph_editor_wrong', self._red_near(*IN_THE_WALL))
        self._choose(IN_THE_WALL, VERTEX_MENU, Action.UNDO)
        self._graph_with(lambda graph: math.dist(graph.vertices[vertex].position, NEW_PLACE)
                         < 0.05, 'the vertex back in its place')

    def drag(self, vertex: int) -> None:
        x, y = NEW_PLACE
        self._window.drag_handle(self._window.pixel(x, y), self._window.pixel(x + 0.4, y - 0.3))
        self._graph_with(lambda graph: math.dist(graph.vertices[vertex].position,
                                                 (x + 0.4, y - 0.3)) < 0.1, 'the moved vertex')

    def delete_an_edge_and_undo(self, edge: int) -> None:
        graph = self.graph()
        middle = graph.curve(edge).point_at(graph.curve(edge).length / 2.0)
        self._choose(middle, EDGE_MENU, Action.DELETE_EDGE)
        self._heard('Delete this edge')
        vertex = graph.edges[edge].destination
        vertex = max(vertex, graph.edges[edge].origin)
        self._choose(graph.vertices[vertex].position, VERTEX_MENU, Action.UNDO)
        self._heard('Undone: delete this edge')

    def save(self) -> None:
        graph = self.graph()
        vertex = graph.vertices[max(graph.vertices)]
        self._window.wait_for_picture('graph_editor', lambda picture: (
            [] if self._red_near(*vertex.position)(picture) else ['a vertex that is not red']))
        self._choose(vertex.position, VERTEX_MENU, Action.SAVE)
        self._heard('Saved')

    def drag_and_load_again(self, vertex: int) -> None:
        """Drags a vertex, and loads the saved graph again."""
        saved = self.graph().vertices[vertex].position
        there = saved[0], saved[1] + 0.6
        self._window.drag_handle(self._window.pixel(*saved), self._window.pixel(*there))
        self._graph_with(lambda graph: math.dist(graph.vertices[vertex].position, there) < 0.1,
                         'the vertex that is not saved')
        self._choose(there, VERTEX_MENU, Action.LOAD)  # where the mouse released the handle
        self._graph_with(lambda graph: graph.vertices[vertex].position == saved,
                         'the vertex as it was saved')

    def _choose(self, place: Tuple[float, float], menu: tuple, action: Action) -> None:
        titles = [entry.title for entry in menu]
        self._window.choose_from_menu(self._window.pixel(*place), titles, action.value)

    def _heard(self, words: str) -> None:
        self._words.wait_for(lambda message: message.data.startswith(words), 20.0, f'"{words}"')

    def _graph_with(self, condition: Callable[[Graph], bool], what: str) -> Graph:
        try:
            wait_until(lambda: condition(self.graph()), 20.0, f'{what} on graph_editor/graph')
        except AssertionError as error:
            self._window.picture('graph_editor_failed')
            raise AssertionError(f'{error}; last words: {self._words.messages[-1].data}') from None
        return self.graph()

    def _red_near(self, x: float, y: float):
        """Returns a function that checks a picture: it returns a text if no red mark is at x, y."""
        def missing(picture) -> List[str]:
            left, top = self._window.pixel(x, y)
            around = picture.crop((left - 15, top - 15, left + 16, top + 16))
            red = close_to(np.asarray(around), RED, 60.0).sum()
            return [] if red > 20 else [f'red at {x} {y}: {red} pixels']
        return missing


def far_vertices(graph: Graph, start: int, count: int) -> List[int]:
    """Returns `count` vertices, each as far as possible from the start and from the others."""
    chosen = [start]
    while len(chosen) <= count:
        chosen.append(max(graph.vertices, key=lambda id: (min(
            math.dist(graph.vertices[id].position, graph.vertices[other].position)
            for other in chosen), -id)))
    return chosen[1:]


if __name__ == '__main__':
    run_cases(__file__)
