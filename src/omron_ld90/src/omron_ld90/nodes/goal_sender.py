"""Clicks in RViz drive the robot: to the goal or dock that was meant, on the map that is shown.

A click of the Publish Point tool means the nearest goal or dock within `~click_tolerance`; the
handles of `interactive_goals` mean their own. Both go by the map that `map_visualisation` says it
displays, never by another. While the fleet drives a route, only stop is taken, unless
`~allow_takeover` is true: then the route ends as `taken over`. A command is sent once; what became
of it is told in words, where the person looks: sent, accepted, refused, arrived, failed.

Subscribes
    clicked_point (geometry_msgs/PointStamped), in any frame that TF knows
    map_file (std_msgs/String, latched): path of the displayed map
    execution_route_states (itrci_nav_msgs/ExecutionRouteStates)
    arcl_response (std_msgs/String), command_refused (omron_ld90_msgs/CommandRefused)
    link_state (omron_ld90_msgs/LinkState), pose (geometry_msgs/PoseStamped)
    interactive_goals/feedback (visualization_msgs/InteractiveMarkerFeedback)
Publishes
    send_command (std_msgs/String)
    user_feedback (std_msgs/String): what happened, in a sentence
    feedback_markers (visualization_msgs/MarkerArray): the same as text in RViz
    interactive_goals/update, update_full (visualization_msgs/InteractiveMarker...)
Parameters
    ~click_tolerance  float   0.5 m  a click farther than this from every goal and dock is a miss
    ~allow_takeover   bool    false  true: a click ends a running fleet route
    ~handle_size      float   0.7 m  across the handles on goals; one of its own for each robot
    ~map_frame        string  map
    ~base_frame       string  <namespace>/base_link
"""
from __future__ import annotations

import math
import threading
import time
from typing import List, Optional, Tuple

import rospy
import tf2_geometry_msgs  # noqa: F401  registers PointStamped with tf2
import tf2_ros
from geometry_msgs.msg import PointStamped, PoseStamped
from std_msgs.msg import String

from itrci_nav_msgs.msg import ExecutionRouteStates
from omron_ld90.bridge.route_watch import RouteWatch
from omron_ld90.nodes.rviz.interactive_goals import Action, InteractiveGoals
from omron_ld90.nodes.rviz.user_feedback import UserFeedback
from omron_ld90.nodes.support import shared_parameters, startup
from omron_ld90.nodes.support.poses import yaw_from_quaternion
from omron_ld90.operator.arcl_news import NewsReader, Tone
from omron_ld90.operator.goal_clicks import (
    Target,
    explain_miss,
    extent_in_x,
    resolve_click,
    target_named,
    targets_of,
)
from omron_ld90.units import millimetres
from omron_ld90_msgs.msg import CommandRefused, LinkState
from omron_map import MapDocument, MapError

TRANSFORM_PATIENCE = rospy.Duration(0.3)


class GoalSender:
    """The node: see the module's text."""

    def __init__(self) -> None:
        self._map_frame = startup.parameter('~map_frame', 'map')
        self._tolerance = startup.number('~click_tolerance', 0.5, 0.01, 10.0)
        self._allow_takeover = startup.parameter('~allow_takeover', False, bool)

        self._lock = threading.RLock()
        self._targets: Optional[List[Target]] = None  # None: no map is displayed
        self._routes = RouteWatch()
        self._news = NewsReader()
        self._heading: Optional[float] = None  # degrees

        self._feedback = UserFeedback(self._map_frame)
        self._handles = InteractiveGoals(
            self._map_frame, shared_parameters.base_frame(),
            startup.number('~handle_size', 0.7, 0.3, 3.0), self._on_handle)
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._commands = rospy.Publisher('send_command', String, queue_size=10, tcp_nodelay=True)
        for topic, message, callback in (
                ('map_file', String, self._on_map),
                ('execution_route_states', ExecutionRouteStates, self._on_route),
                ('arcl_response', String, self._on_line),
                ('command_refused', CommandRefused, self._on_refused),
                ('link_state', LinkState, self._on_link),
                ('pose', PoseStamped, self._on_pose),
                ('clicked_point', PointStamped, self._on_click)):
            rospy.Subscriber(topic, message, callback, queue_size=10, tcp_nodelay=True)

    # What is known of the map, the fleet and the robot

    def _on_map(self, message: String) -> None:
        targets = None
        if message.data:
            try:
                document = MapDocument.load(message.data)
                targets = targets_of(document)
                self._feedback.stay_within(*extent_in_x(document))
            except MapError as error:
                rospy.logerr('Clicks do nothing: %s', error)
        with self._lock:
            self._targets = targets
            self._handles.show(targets or ())

    def _on_route(self, message: ExecutionRouteStates) -> None:
        with self._lock:
            self._routes.update(message.route_id, [edge.state for edge in message.edge_states],
                                time.monotonic())

    def _on_pose(self, message: PoseStamped) -> None:
        with self._lock:
            self._heading = math.degrees(yaw_from_quaternion(message.pose.orientation))
            self._feedback.robot = (message.pose.position.x, message.pose.position.y)

    def _on_link(self, message: LinkState) -> None:
        if message.link == LinkState.COMMANDS:
            with self._lock:
                self._handles.show_robot(message.state == LinkState.CONNECTED)

    # What the person wants

    def _on_click(self, message: PointStamped) -> None:
        point = self._in_map(message)
        if point is None:
            return
        with self._lock:
            if self._targets is None:
                self._feedback.say(Tone.BAD, 'No map is displayed yet: the click did nothing.',
                                   point)
                return
            click = resolve_click(self._targets, point[0], point[1], self._tolerance)
            if click.hit:
                self._drive(click.target.command, click.target)
            else:
                self._feedback.say(Tone.NEWS, explain_miss(click, self._tolerance), point)

    def _in_map(self, message: PointStamped) -> Optional[Tuple[float, float]]:
        x, y = message.point.x, message.point.y
        if message.header.frame_id not in ('', self._map_frame):
            try:
                point = self._buffer.transform(message, self._map_frame, TRANSFORM_PATIENCE).point
                x, y = point.x, point.y
            except tf2_ros.TransformException as error:
                self._feedback.say(
                    Tone.BAD, f'The click did nothing: {message.header.frame_id} has no '
                              f'transform to {self._map_frame} ({error}).')
                return None
        if not (math.isfinite(x) and math.isfinite(y)):
            rospy.logwarn('A click without finite coordinates did nothing.')
            return None
        return x, y

    def _on_handle(self, action: Action, target: Optional[Target]) -> None:
        with self._lock:
            if action is Action.STOP:
                self._send('stop', None)
            elif action is Action.GO:
                self._drive(target.command, target)
            elif action is Action.LOCALIZE:
                self._localize(target)
            else:
                self._drive(action.value.lower(), target)

    def _localize(self, target: Target) -> None:
        heading = self._heading if target.heading is None else target.heading
        if heading is None:
            self._feedback.say(
                Tone.BAD, f'Which way does the robot face at {target}? Use 2D Pose Estimate.',
                target.place)
            return
        self._drive(f'localizeToPoint {millimetres(target.x)} {millimetres(target.y)} '
                    f'{round(heading)}', target)

    # What is done about it

    def _drive(self, command: str, target: Optional[Target]) -> None:
        route = self._routes.running(time.monotonic())
        if route is not None and not self._allow_takeover:
            self._feedback.say(
                Tone.BAD, f'Not sent: the fleet drives route {route}. Stop it first.',
                _place(target))
            return
        self._send(command, target)

    def _send(self, command: str, target: Optional[Target]) -> None:
        if self._commands.get_num_connections() == 0:
            self._feedback.say(
                Tone.BAD, f'Not sent: nobody listens on {self._commands.resolved_name}. '
                          'Is omron_controller running?', _place(target))
            return
        self._commands.publish(command)
        self._feedback.say(Tone.NEWS, f'{command} ...', _place(target))

    # What became of it

    def _on_line(self, message: String) -> None:
        with self._lock:
            news = self._news.read(message.data)
            if news is not None:
                target = target_named(news.goal, self._targets or ()) if news.goal else None
                self._feedback.say(news.tone, news.text, _place(target))

    def _on_refused(self, message: CommandRefused) -> None:
        """The controller refused a command, of whomever; it has logged that already."""
        self._feedback.show(Tone.BAD, f'{message.command} refused: {message.reason}')


def _place(target: Optional[Target]) -> Optional[Tuple[float, float]]:
    return target.place if target else None


def main() -> None:
    """Run the node."""
    startup.run('goal_sender', GoalSender)
