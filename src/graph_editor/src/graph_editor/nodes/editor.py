"""Node `graph_editor`: edits a trajectory graph in RViz on its map.

Publishes
  graph_editor/update, /update_full  handles of vertices and edges (interactive markers)
  graph_editor/graph  itrci_nav_msgs/Graph, latched: the edited graph, whenever it is valid
  /graph              itrci_nav_msgs/Graph, latched: the graph that was taken over, if no fleet
                      manager runs; otherwise "take over" calls /reload_graph (std_srvs/Trigger)
  graph_editor/map    nav_msgs/OccupancyGrid, latched: the map; cells outside the used part are
                      unknown
  graph_editor/findings  visualization_msgs/MarkerArray, latched: the findings and the last message
  graph_editor/words  std_msgs/String, latched: the last action, or the reason why it was not done
  TF map -> graph_editor, so that RViz knows the frame
Subscribes
  graph_editor/clicked_point  geometry_msgs/PointStamped: RViz's Publish Point adds a
                      vertex or cuts an edge
Parameters
  ~map_file           .map of a robot, .yaml of a ROS map, or topic:NAME (required)
  ~graph_file         graph to edit; if it does not exist, it is made from the map (required)
  ~area               '' or x1,y1,x2,y2: the part of the map that is used
  ~grid               pitch of the grid to which vertices snap, m (0: no grid)
  ~corridor           m (0.9)
  ~robot_width, ~robot_length  m (0.5, 0.7)
  ~window             true: a window for texts, numbers and findings (true)
"""
from __future__ import annotations

import gc
import os
import sys
import threading
import time
from typing import Dict, List, Optional, Tuple

import rospy
import tf2_ros
from geometry_msgs.msg import PointStamped, TransformStamped
from nav_msgs.msg import OccupancyGrid
from std_msgs.msg import String
from visualization_msgs.msg import Marker, MarkerArray

from graph_editor.checking.checker import Checker
from graph_editor.checking.findings import Finding, Severity
from graph_editor.checking.rules import CheckRules
from graph_editor.editor.session import EditingSession
from graph_editor.errors import SiteError
from graph_editor.make_cli import area_of
from graph_editor.making.maker import make_graph
from graph_editor.making.options import MakingOptions
from graph_editor.nodes.board import NAMESPACE, Board, Key
from graph_editor.nodes.finding_words import finding_markers
from graph_editor.nodes.graph_topic import GraphTopic
from graph_editor.nodes.handles import BLACK
from graph_editor.nodes.live_map import load_map
from graph_editor.nodes.take_over import TakeOver
from graph_editor.site import MappedSite, SiteOptions
from node_lifecycle import ConfigurationError, init_node, number, parameter
from omron_map import MapError
from rviz_drawing import drawing
from rviz_drawing.drawing import FRAME
from trajectory_graph import TrajectoryGraphError
from trajectory_graph.editing import Draft
from trajectory_graph.yaml_editing import GraphFile
from trajectory_graph.yaml_file import dump_graph

TICK = 0.1  # s; time between two periodic steps
REST = 0.5  # s; after this time without a change, the whole graph is checked again
GRAPH_PERIOD = 0.25  # s; the shortest time between two messages that contain drafts


class EditorNode:
    """Connects a session to RViz, to the subscribers of its graph, and to the window.

    The class has many attributes, because it connects all parts of the node.
    """

    def __init__(self, session: EditingSession, site: MappedSite, rules: CheckRules) -> None:
        self.session = session
        self.lock = threading.RLock()
        self.findings: List[Finding] = []
        self._checker = Checker(rules, site)
        self._site = site
        self._checked_version = self._published_version = -1
        self._changed_at = self._published_at = 0.0
        self._last_draft = session.draft
        self._own: Dict[Key, Optional[Severity]] = {}
        self._board = Board(session, self.lock, self.show)
        self._graphs = GraphTopic(f'{NAMESPACE}/graph')
        self._taking_over = TakeOver()
        self._maps = rospy.Publisher(f'{NAMESPACE}/map', OccupancyGrid, queue_size=1, latch=True)
        self._markers = rospy.Publisher(f'{NAMESPACE}/findings', MarkerArray, queue_size=1,
                                        latch=True)
        self._words = rospy.Publisher(f'{NAMESPACE}/words', String, queue_size=1, latch=True)
        self._frames = tf2_ros.StaticTransformBroadcaster()
        self._maps.publish(_grid_message(site))
        self._frames.sendTransform(_frame())
        self.show()
        gc.freeze()
        self._subscriber = rospy.Subscriber(f'{NAMESPACE}/clicked_point', PointStamped,
                                            self._on_click)
        session.on_take_over = self._take_over
        self._timer = threading.Thread(target=self._watch, daemon=True)
        self._timer.start()

    def show(self) -> None:
        """Updates RViz after a change. The texts of the findings are updated a little later."""
        with self.lock:
            draft = self.session.draft
            if draft is not self._last_draft:
                self._own.update(self._severities_of_changed())
                self._last_draft, self._changed_at = draft, time.monotonic()
            self._board.show(self._own)
            self._words.publish(self.session.said)

    def _severities_of_changed(self) -> Dict[Key, Optional[Severity]]:
        """Checks each changed element on its own. Returns the highest severity of its findings;
        None: no finding.
        """
        draft, before = self.session.draft, self._last_draft
        vertices = {id for id, vertex in draft.vertices.items()
                    if before.vertices.get(id) is not vertex}
        edges = {id for id, edge in draft.edges.items() if before.edges.get(id) is not edge
                 or edge.origin in vertices or edge.destination in vertices}
        found = {('vertex', id): self._checker.of_vertex(draft, id) for id in vertices}
        found.update({('edge', id): self._checker.of_edge(draft, id) for id in edges})
        return {key: min((finding.severity for finding in findings),
                         key=lambda severity: severity is Severity.WARNING, default=None)
                for key, findings in found.items()}

    def _on_click(self, click: PointStamped) -> None:
        if click.header.frame_id.lstrip('/') == FRAME:
            with self.lock:
                self.session.click_floor(click.point.x, click.point.y)
                self.show()

    def _take_over(self, draft: Draft) -> None:
        """Puts a draft in force; uses a thread, because the fleet manager's answer may take
        seconds.
        """
        threading.Thread(target=self._put_in_force, args=(draft,), name='take over',
                         daemon=True).start()

    def _put_in_force(self, draft: Draft) -> None:
        words = self._taking_over.put_in_force(draft, self.session.path)
        with self.lock:
            self.session.say(words)
            self.show()

    def _watch(self) -> None:
        while not rospy.is_shutdown():
            rospy.rostime.wallsleep(TICK)
            with self.lock:
                draft, version = self.session.draft, self.session.history.version
                now, resting = time.monotonic(), not self._board.is_dragging
            if version != self._published_version and now - self._published_at > GRAPH_PERIOD:
                self._graphs.publish(draft)
                self._published_version, self._published_at = version, now
            if version != self._checked_version and resting and now - self._changed_at > REST:
                findings = self._checker.all(draft)
                with self.lock:
                    self._checked_version = version
                    if self.session.draft is draft:
                        self.findings = findings
                        self._own = {}
                        self._board.mark(findings)
                        self._board.show(self._own)
                _keep_the_collector_short()
            self._publish_findings()

    def _publish_findings(self) -> None:
        with self.lock:
            findings = tuple(zip(self.findings, self._board.finding_places))
        shown = findings, self.session.said, self.session.is_saved
        if shown == getattr(self, '_shown_findings', None):
            return
        self._shown_findings = shown
        array = MarkerArray([Marker(action=Marker.DELETEALL), *finding_markers(findings)])
        floor = self._site.floor
        top = floor.origin[1] + floor.occupied.shape[0] * floor.resolution
        middle = floor.origin[0] + floor.occupied.shape[1] * floor.resolution / 2.0
        array.markers.append(
            drawing.text('', 0, self._summary(), (middle, top + 0.8), 0.45, BLACK, 0.3))
        for id, marker in enumerate(array.markers):
            marker.header.frame_id, marker.ns, marker.id = FRAME, 'findings', id
        self._markers.publish(array)

    def _summary(self) -> str:
        errors = sum(finding.severity is Severity.ERROR for finding in self.findings)
        state = 'saved' if self.session.is_saved else 'not saved'
        return (f'{self.session.said}\n{_counted(errors, "error")}, '
                f'{_counted(len(self.findings) - errors, "warning")}, {state}')


def _keep_the_collector_short() -> None:
    """Excludes the present objects from later passes of the garbage collector.

    A pass over the drawings of a thousand edges takes 80 ms. During this time the editor does not
    react to a drag. Almost all drawings are freed without the collector, because they are not in
    reference cycles.
    """
    gc.collect()
    gc.freeze()


def _counted(number: int, thing: str) -> str:
    return f'{number} {thing}' if number == 1 else f'{number} {thing}s'


def _grid_message(site: MappedSite) -> OccupancyGrid:
    floor = site.floor
    message = OccupancyGrid()
    message.header.frame_id = FRAME
    message.header.stamp = rospy.Time.now()
    message.info.map_load_time = message.header.stamp
    message.info.resolution = floor.resolution
    message.info.height, message.info.width = floor.occupied.shape
    message.info.origin = drawing.pose_at(floor.origin)
    cells = (floor.occupied * 100).astype('int8')
    cells[~floor.inside & ~floor.occupied] = -1
    message.data = cells.ravel().tolist()
    return message


def _frame() -> TransformStamped:
    transform = TransformStamped()
    transform.header.frame_id, transform.child_frame_id = FRAME, NAMESPACE
    transform.header.stamp = rospy.Time.now()
    transform.transform.rotation.w = 1.0
    return transform


def _start() -> Tuple[EditorNode, bool]:
    """Returns the node, and whether to open a window.

    Raises ConfigurationError, SiteError and the errors of the files.
    """
    map_file, graph_file = parameter('~map_file'), parameter('~graph_file')
    rules = CheckRules(robot_width=number('~robot_width', 0.5, 0.0),
                       robot_length=number('~robot_length', 0.7, 0.0),
                       corridor=number('~corridor', 0.9, 0.0))
    area, with_window = parameter('~area', ''), parameter('~window', True, bool)
    grid = number('~grid', 0.0, 0.0)
    site = load_map(map_file, SiteOptions(area_of(area, '~area') if area else None))
    is_new = not os.path.exists(graph_file)
    if is_new:
        made = make_graph(site, MakingOptions(
            robot_width=rules.robot_width, robot_length=rules.robot_length,
            corridor=rules.corridor))
        file = GraphFile(dump_graph(made.graph), graph_file)
        rospy.loginfo('%s does not exist, so a graph was made from %s. Save it to keep it.',
                      graph_file, map_file)
    else:
        file = GraphFile.load(graph_file)
    session = EditingSession(file, graph_file, is_new)
    session.set_grid(grid)
    session.said = f'{len(file.draft.vertices)} vertices and {len(file.draft.edges)} edges'
    return EditorNode(session, site, rules), with_window


def main() -> int:
    """Runs the node until it is shut down or its window is closed."""
    init_node('graph_editor')
    try:
        node, with_window = _start()
    except (ConfigurationError, SiteError, MapError, TrajectoryGraphError, ValueError) as error:
        rospy.logerr('%s', error)
        return 1
    if with_window:
        from graph_editor.nodes.window import run_window  # not every computer has Qt
        run_window(node)
        rospy.signal_shutdown('the window was closed')
    else:
        rospy.spin()
    return 0


if __name__ == '__main__':
    sys.exit(main())
