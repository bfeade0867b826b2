"""Measures the making of graphs from maps, and the editor with a large graph.

It uses the laboratory, and the maps of real LD robots in the folder LD90_REAL_MAPS if it exists.
"""
from __future__ import annotations

import argparse
import gc
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Callable, Dict, Iterator, List, NamedTuple, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import Pose
from measuring.ros_master import own_ros_master
from measuring.tables import print_row, print_table
from PIL import Image
from rviz_support import Screen, missing_programs
from scipy import ndimage
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerUpdate

from graph_editor.checking.checker import Checker
from graph_editor.checking.findings import Severity
from graph_editor.checking.rules import CheckRules
from graph_editor.floor import EVERY_NEIGHBOUR
from graph_editor.making.coverage import Coverage
from graph_editor.making.maker import make_graph
from graph_editor.making.options import MakingOptions
from graph_editor.nodes.handles import VERTICES, vertex_group
from graph_editor.nodes.view import fitted, rendering_arguments
from graph_editor.site import MappedSite, SiteOptions, load_site
from rviz import frames_in
from trajectory_graph import Edge, Graph, Vertex, load_graph, save_graph
from trajectory_graph.editing import Draft

ROOT = Path(__file__).resolve().parents[2]
LAB = ROOT / 'maps' / 'lab_base.map'
REAL = sorted(Path(os.environ.get('LD90_REAL_MAPS') or '/nowhere').glob('*.map'))
RUNS = 3
OPTIONS = MakingOptions()
# clearance, m: only the middle of the laboratory's rooms and halls has so much, and no door
ROOM = 1.1
ROWS, COLUMNS, PITCH, EDGES = 20, 25, 3.0, 1000
# position of the vertex that is dragged, m
MIDDLE = ((COLUMNS // 2) * PITCH, (ROWS // 2 + 1) * PITCH)
DRAGS, RATE = 300, 30.0  # s-1
SETTLE, MEASURE = 8.0, 6.0  # s
IMPORTS = ('import numpy, networkx, scipy.ndimage, scipy.spatial, shapely.geometry, '
           'skimage.graph, skimage.morphology, PIL.Image, yaml')
ECHO = '''
import rospy
from visualization_msgs.msg import (InteractiveMarker, InteractiveMarkerFeedback,
                                    InteractiveMarkerUpdate)
rospy.init_node('echo')
answer = InteractiveMarkerUpdate(markers=[InteractiveMarker(name='edges 0')])
publisher = rospy.Publisher('graph_editor/update', InteractiveMarkerUpdate, queue_size=100)
rospy.Subscriber('graph_editor/feedback', InteractiveMarkerFeedback,
                 lambda feedback: publisher.publish(answer), tcp_nodelay=True)
rospy.spin()
'''


class Times(NamedTuple):
    """The times of one program (s)."""

    wall: float
    cpu: float


def timed(*command: object) -> Times:
    """Returns the median times of several runs of a command."""
    walls, cpus = [], []
    for _ in range(RUNS):
        begun, before = time.perf_counter(), os.times()
        subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        after = os.times()
        walls.append(time.perf_counter() - begun)
        cpus.append(after.children_user + after.children_system
                    - before.children_user - before.children_system)
    return Times(statistics.median(walls), statistics.median(cpus))


# Making


def making() -> None:
    """Measures time, covered floor and errors of the graphs of all maps."""
    floor = timed(sys.executable, '-c', IMPORTS)
    print_table([], ('map', 'vertices, edges, m', 'make_graph', 'imports alone', 'aim',
                     'floor within 2 m of an edge, by the way to drive', 'aim', 'errors'))
    with tempfile.TemporaryDirectory() as folder:
        for path in (LAB, *REAL):
            output = f'{folder}/{path.stem}.yaml'
            needed = timed(sys.executable, ROOT / 'src/graph_editor/nodes/make_graph', '--map',
                           path, '--output', output)
            site, graph = load_site(str(path), SiteOptions()), load_graph(output)
            print_row((path.name,
                       f'{len(graph.vertices)}, {len(graph.edges)}, {length(graph):.0f}',
                       f'{needed.wall:.2f} s ({needed.cpu:.2f} s of CPU)', f'{floor.wall:.2f} s',
                       '< 5 s', f'{100.0 * share_served(site, graph):.1f} %', '>= 95 %',
                       str(errors(site, graph))))


def length(graph: Graph) -> float:
    """Returns the length of all edges, in m."""
    return sum(graph.curve(id).length for id in graph.edges)


def robot_floor(site: MappedSite, graph: Graph) -> np.ndarray:
    """Returns the mask of the floor that is connected to the graph and at least half a robot's
    width away from walls.
    """
    return site.floor.reachable(OPTIONS.robot_width / 2.0,
                                [vertex.position for vertex in graph.vertices.values()])


def share_served(site: MappedSite, graph: Graph) -> float:
    """Returns the share of the reachable floor from which a robot drives at most 2 m to an edge.
    """
    coverage = Coverage(site.floor, robot_floor(site, graph), 2.0)
    served = np.zeros(coverage.mask.size, bool)
    for id in graph.edges:
        served[coverage.covered_by(graph.curve(id).sample(0.05))] = True
    return float(served[coverage.mask.ravel()].mean())


def errors(site: MappedSite, graph: Graph) -> int:
    """Returns the number of errors that check_graph finds, such as edges in walls or vertices that
    cannot be reached.
    """
    findings = Checker(CheckRules(), site).all(Draft.of(graph))
    return sum(finding.severity is Severity.ERROR for finding in findings)


def compare_with_hand() -> None:
    """Compares the graph made for the laboratory with the graph that a person drew."""
    site = load_site(str(LAB), SiteOptions())
    graphs = {'made': make_graph(site, OPTIONS).graph,
              'maps/lab_graph.yaml': load_graph(ROOT / 'maps' / 'lab_graph.yaml')}
    rooms, count = ndimage.label(robot_floor(site, graphs['made'])
                                 & (site.floor.clearance >= ROOM), EVERY_NEIGHBOUR)
    print()
    print_table([], ('laboratory', 'm', 'vertices, edges', 'rooms with an edge in their middle',
                     'floor within 2 m of an edge'))
    for name, graph in graphs.items():
        cells = site.floor.cells_of(np.vstack([graph.curve(id).sample(0.05)
                                               for id in graph.edges]))
        reached = set(rooms[cells].tolist()) - {0}
        print_row((name, f'{length(graph):.0f}', f'{len(graph.vertices)}, {len(graph.edges)}',
                   f'{len(reached)} of {count}', f'{100.0 * share_served(site, graph):.1f} %'))
    ratio = length(graphs['made']) / length(graphs['maps/lab_graph.yaml'])
    print(f'\nLength of the made graph over that of the drawn one: {ratio:.2f} (aim: at most 1.3).')


# Editing


def large_site(folder: str) -> Tuple[str, str, int]:
    """Returns a hall as a ROS map, a graph with 500 vertices and 1,000 edges, and a vertex in the
    middle of the graph.
    """
    width, height = (COLUMNS + 1) * PITCH, (ROWS + 1) * PITCH
    grey = np.full((int(height / 0.05), int(width / 0.05)), 254, np.uint8)
    grey[(0, -1), :] = grey[:, (0, -1)] = 0
    Image.fromarray(grey).save(f'{folder}/hall.pgm')
    Path(f'{folder}/hall.yaml').write_text(
        'image: hall.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n'
        'occupied_thresh: 0.65\nfree_thresh: 0.196\n')
    vertices = [Vertex(row * COLUMNS + column + 1, (column + 1) * PITCH, (row + 1) * PITCH, 0.0,
                       label='pass') for row in range(ROWS) for column in range(COLUMNS)]
    pairs = [(vertex.id, vertex.id + 1) for vertex in vertices if vertex.id % COLUMNS]
    pairs += [(vertex.id, vertex.id + COLUMNS) for vertex in vertices[:-COLUMNS]]
    diagonals = [(vertex.id, vertex.id + COLUMNS + 1) for vertex in vertices[:-COLUMNS]
                 if vertex.id % COLUMNS]
    pairs += diagonals[:EDGES - len(pairs)]
    save_graph(Graph(vertices, [Edge(id, *pair, velocity_forward=1.0, velocity_backwards=1.0)
                                for id, pair in enumerate(pairs, 1)]), f'{folder}/graph.yaml')
    return f'{folder}/hall.yaml', f'{folder}/graph.yaml', (ROWS // 2) * COLUMNS + COLUMNS // 2


class Mouse:
    """Drags a vertex with the same messages as RViz, and waits for the update of its edges."""

    def __init__(self, vertex: int) -> None:
        self._name = f'{VERTICES} {vertex_group(vertex)}'
        self._answered = threading.Event()
        self._publisher = rospy.Publisher('graph_editor/feedback', InteractiveMarkerFeedback,
                                          queue_size=100, tcp_nodelay=True)
        self._subscriber = rospy.Subscriber('graph_editor/update', InteractiveMarkerUpdate,
                                            self._on_update, tcp_nodelay=True)

    def drag(self, x: float, y: float) -> float:
        """Drags the vertex. Returns the time (s) from the feedback to the update of its edges."""
        self._answered.clear()
        begun = time.perf_counter()
        self._publish_feedback(InteractiveMarkerFeedback.POSE_UPDATE, x, y)
        if not self._answered.wait(10.0):
            raise RuntimeError('a drag was not answered within 10 s')
        return time.perf_counter() - begun

    def wait_for_editor(self) -> None:
        """Waits until the editor answers. While it starts, feedback is lost, and its first update
        is not an answer.
        """
        answers = 0
        for x, y in list(circle(60))[1:]:  # the editor does not answer a drag to the same position
            self._answered.clear()
            self._publish_feedback(InteractiveMarkerFeedback.MOUSE_DOWN, 0.0, 0.0)
            self._publish_feedback(InteractiveMarkerFeedback.POSE_UPDATE, x, y)
            answers = answers + 1 if self._answered.wait(1.0) else 0
            if answers == 3:
                return
        raise RuntimeError('the editor did not start within 60 s')

    def close(self) -> None:
        """Releases the mouse button."""
        self._publish_feedback(InteractiveMarkerFeedback.MOUSE_UP, 0.0, 0.0)
        self._publisher.unregister()
        self._subscriber.unregister()

    def _publish_feedback(self, event: int, x: float, y: float) -> None:
        feedback = InteractiveMarkerFeedback(client_id='bench', marker_name=self._name,
                                             event_type=event, pose=Pose())
        feedback.header.frame_id = 'map'
        feedback.pose.position.x, feedback.pose.position.y = x, y
        feedback.mouse_point.x, feedback.mouse_point.y = MIDDLE
        feedback.pose.orientation.w = 1.0
        self._publisher.publish(feedback)

    def _on_update(self, update: InteractiveMarkerUpdate) -> None:
        if any(marker.name.startswith('edge') for marker in update.markers):
            self._answered.set()


def drags(mouse: Mouse, count: int) -> List[float]:
    """Returns the delays (s) of `count` drags along a circle, at the rate of a mouse."""
    seconds = []
    for x, y in circle(count):
        begun = time.monotonic()
        seconds.append(mouse.drag(x, y))
        time.sleep(max(0.0, 1.0 / RATE - (time.monotonic() - begun)))
    return seconds


def circle(count: int) -> Iterator[Tuple[float, float]]:
    """Yields displacements (x, y) of the mouse from the first place of the vertex, in m."""
    for angle in np.linspace(0.0, 4.0 * np.pi, count, endpoint=False):
        yield np.cos(angle), np.sin(angle)


def editing() -> None:
    """Measures the delay of a drag, and RViz's frames per second during drags."""
    # Python's garbage collector would stop this process for 60 ms, which would count as time of
    # the editor. RViz, in whose place this process drags, has no collector.
    gc.freeze()
    with own_ros_master(), tempfile.TemporaryDirectory() as folder:
        map_file, graph_file, vertex = large_site(folder)
        rospy.init_node('bench_graph', disable_signals=True)
        floor = in_process([sys.executable, '-c', ECHO], vertex)
        figures: Dict[str, List[float]] = {}
        measured = in_process(
            [sys.executable, '-m', 'graph_editor.nodes.editor', '__name:=graph_editor',
             f'_map_file:={map_file}', f'_graph_file:={graph_file}', '_window:=false'],
            vertex, lambda mouse: figures.update(frames(mouse, map_file)))
    print()
    print_table([], ('500 vertices, 1,000 edges', 'measured', 'floor', 'aim'))
    for name, share, aim in (('median', 50, ''), ('p95', 95, 'p95 < 50 ms')):
        print_row((f'feedback of a drag to the update with its edges, {name} of {DRAGS}',
                   f'{1e3 * np.percentile(measured, share):.1f} ms',
                   f'an echo by a bare rospy node: {1e3 * np.percentile(floor, share):.1f} ms',
                   aim))
    if figures:
        rows = [statistics.median(figures[name]) for name in ('dragged', 'at rest', 'empty')]
        for name, figure in zip(('RViz in software rendering, frames a second while it is dragged',
                                 'the same at rest'), rows):
            print_row((name, f'{figure:.1f}', f'without displays: {rows[2]:.1f}', '>= 10'))


def in_process(command: List[str], vertex: int, more: Callable[[Mouse], object] = lambda mouse: None
               ) -> List[float]:
    """Measures the delays of drags that a node answers, then calls `more` with the mouse."""
    node = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    mouse = Mouse(vertex)
    try:
        mouse.wait_for_editor()
        drags(mouse, 30)
        seconds = drags(mouse, DRAGS)
        more(mouse)
        return seconds
    finally:
        mouse.close()
        node.send_signal(signal.SIGINT)
        node.wait(20)


def frames(mouse: Mouse, map_file: str) -> Dict[str, List[float]]:
    """Returns RViz's frames per second while a vertex is dragged, at rest, and without displays."""
    if missing_programs():
        return {}
    text = (ROOT / 'src/graph_editor/rviz/graph_editor.rviz').read_text()
    text = fitted(text, load_site(map_file, SiteOptions()).floor)
    head, _, tail = text.partition('  Displays:\n')
    empty = head + '  Displays: ~\n' + tail[tail.index('  Enabled: true\n'):]
    screen = Screen()
    try:
        dragged, rest = measured_frames(screen, text, mouse)
        return {'dragged': dragged, 'at rest': rest,
                'empty': measured_frames(screen, empty, mouse)[1]}
    finally:
        screen.close()


def measured_frames(screen: Screen, text: str, mouse: Mouse) -> Tuple[List[float], List[float]]:
    """Returns the frames per second of RViz with a configuration, during drags and at rest."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'bench.rviz'
        path.write_text(text)
        environment = {**screen.environment, 'GALLIUM_HUD': 'fps', 'GALLIUM_HUD_PERIOD': '1',
                       'GALLIUM_HUD_VISIBLE': 'false', 'GALLIUM_HUD_DUMP_DIR': folder}
        rviz = subprocess.Popen(['rviz', '-d', str(path), *rendering_arguments()],
                                env=environment, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL)
        try:
            time.sleep(SETTLE)
            begun = len(frames_in(folder))
            drags(mouse, int(MEASURE * RATE))
            dragged = frames_in(folder)[begun:]
            time.sleep(MEASURE)
            return dragged, frames_in(folder)[begun + len(dragged):]
        finally:
            rviz.send_signal(signal.SIGINT)
            rviz.wait(20)


def main() -> None:
    """Prints the tables; with --only editing, prints only the last table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument('--only', choices=('making', 'editing'), help='a part of it')
    only = options.parse_args().only
    if only != 'editing':
        making()
        compare_with_hand()
    if only != 'making':
        editing()


if __name__ == '__main__':
    main()
