#!/usr/bin/env python3
"""A map without a graph becomes a driving robot: graph and fences made, five far places visited."""
from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Dict, List

import networkx as nx
import rospy
import rostest
from route_robot import FleetManager, state_list

from itrci_nav_msgs.msg import EdgeState
from omron_map import MapDocument
from system_support import Launched, wait_until
from trajectory_graph import Graph, load_graph

ROOT = Path(__file__).resolve().parents[1]
STATION_SIDE = '--dock=-13.2,-7.0,180'  # where the laboratory's charger stands
SPEED = 20


class NewSite(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('graph_editor_site_test')
        cls.folder = tempfile.TemporaryDirectory()
        shutil.copy(ROOT / 'maps' / 'lab_base.map', Path(cls.folder.name) / 'site.map')
        cls.printed = cls.new_site()

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    @classmethod
    def new_site(cls) -> str:
        """What scripts/new_site.sh prints for the site."""
        made = subprocess.run(
            [str(ROOT / 'scripts' / 'new_site.sh'), f'{cls.folder.name}/site.map', STATION_SIDE,
             '--no-start'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120,
            check=False, text=True)
        if made.returncode != 0:
            raise AssertionError(f'new_site.sh failed:\n{made.stdout}')
        return made.stdout

    def test_1_a_map_becomes_a_robot_that_visits_five_far_vertices_and_docks(self) -> None:
        for command in ('make_graph --map', 'omron_ros_map --graph', 'run.sh map_file:='):
            self.assertIn(command, self.printed)
        graph_file = f'{self.folder.name}/site_graph.yaml'
        map_file = f'{self.folder.name}/site_fleet.map'
        graph = load_graph(graph_file)
        dock, = (vertex.id for vertex in graph.vertices.values() if vertex.dock)
        fences = [area for area in MapDocument.load(map_file).forbidden_areas
                  if area.description]
        self.assertGreater(len(fences), 20, 'the map has the fences of the graph')

        with Launched('full_stack.launch', map_file=map_file, graph_file=graph_file,
                      dock_vertex=dock, sim_speed=SPEED, rviz='false',
                      arcl_port=os.environ['LD90_ARCL_PORT'],
                      outgoing_port=os.environ['LD90_OUTGOING_PORT']):
            fleet = FleetManager()
            here = dock
            for there in [*far_vertices(graph, dock, 5), dock]:
                route = shortest_route(graph, here, there)
                done = fleet.end_of(fleet.order(route))
                self.assertEqual(state_list(done), [EdgeState.COMPLETE] * len(route),
                                 f'{here} to {there}: {done.reason}')
                here = there
            wait_until(lambda: fleet.status.messages[-1].docking_state == 'Docked', 20,
                       'a status of the docked robot')
            places = [status.pose.position for status in fleet.status.messages]
        farthest = max(graph.nearest_edge(place.x, place.y)[1].distance for place in places)
        self.assertLess(farthest, 0.45, 'the robot stays in the corridors')

    def test_2_an_edited_graph_is_kept(self) -> None:
        graph_file = Path(self.folder.name) / 'site_graph.yaml'
        edited = graph_file.read_text().replace('Label: pass', 'Label: gate', 1)
        graph_file.write_text(edited)
        self.assertIn('was edited and is used as it is', self.new_site())
        self.assertEqual(graph_file.read_text(), edited)


def far_vertices(graph: Graph, start: int, count: int) -> List[int]:
    """So many vertices, each as far as can be from the start and all before."""
    chosen = [start]
    while len(chosen) <= count:
        chosen.append(max(graph.vertices, key=lambda id: (min(
            math.dist(graph.vertices[id].position, graph.vertices[other].position)
            for other in chosen), -id)))
    return chosen[1:]


def shortest_route(graph: Graph, start: int, end: int) -> List[int]:
    """Signed edges from one vertex to another."""
    ways = nx.DiGraph()
    by_ends: Dict[tuple, int] = {}
    for id in graph.edges:
        for signed in (id, -id):
            ends = graph.start_vertex(signed).id, graph.end_vertex(signed).id
            ways.add_edge(*ends, weight=graph.curve(id).length)
            by_ends[ends] = signed
    path = nx.dijkstra_path(ways, start, end)
    return [by_ends[ends] for ends in zip(path, path[1:])]


if __name__ == '__main__':
    rostest.rosrun('omron_ld90', 'graph_editor_site', NewSite, sys.argv)
