"""Lets clicks in RViz drive the robot to a goal or dock of the displayed map.

- A click with the Publish Point tool selects the nearest goal or dock within `~click_tolerance`; a
  handle of `interactive_goals` selects its own goal or dock.
- Both use only the map that `map_visualisation` reports as displayed.
- A robot in `/fleet_state` is managed: a click on a goal that is a vertex sends the robot a
  mission; any other click is refused.
- A managed robot that waits for a person (`fleet out`, taken over, failed, off the graph) is driven
  directly.
- While a fleet drives a route, only stop is accepted.
- With `~allow_takeover` all clicks drive the robot; a running route then ends as `taken over`.
- While the robot obeys a command, the same command is not given again. The result of a command is
  shown in RViz.

Subscribes
    clicked_point (geometry_msgs/PointStamped), in any frame that TF knows
    map_file (std_msgs/String, latched): path of the displayed map
    execution_route_states (itrci_nav_msgs/ExecutionRouteStates)
    /fleet_state (itrci_nav_msgs/FleetState), /mission_status (itrci_nav_msgs/MissionStatus)
    command_refused (omron_ld90_msgs/CommandRefused)
    link_state (omron_ld90_msgs/LinkState), pose (geometry_msgs/PoseStamped)
    arcl_response (std_msgs/String): contains the score after the robot was localized
    interactive_goals/feedback (visualization_msgs/InteractiveMarkerFeedback)
Client of
    execute_command (omron_ld90_msgs/ExecuteCommand)
    /get_mission_status (itrci_nav_msgs/GetMissionStatus), for missions without recent news
Publishes
    /mission_request (itrci_nav_msgs/MissionRequest)
    user_feedback (std_msgs/String): a sentence about what happened
    feedback_markers (visualization_msgs/MarkerArray): the same as text in RViz
    interactive_goals/update, update_full (visualization_msgs/InteractiveMarker...)
Parameters
    ~click_tolerance  float   0.5 m  a click farther than this from all goals and docks does nothing
    ~allow_takeover   bool    false  true: a click also drives a managed robot
    ~ready_advice     string  command  advice in the log when the robot is ready, besides a click:
                                     command, mission, or nothing (another node gives it)
    ~handle_size      float   0.7 m  diameter of the handles on goals; different for each robot
    ~map_frame        string  map
    ~base_frame       string  <namespace>/base_link
"""
from __future__ import annotations

import math
import threading
import time
from typing import Dict, List, NamedTuple, Optional, Tuple

import rospy
import tf2_geometry_msgs  # noqa: F401  registers PointStamped with tf2
import tf2_ros
from geometry_msgs.msg import PointStamped, PoseStamped
from std_msgs.msg import String

from fleet_requests import SILENCE
from node_lifecycle import choice, number, parameter, run
from node_lifecycle.headings import yaw_from_quaternion
from node_lifecycle.periodic import Periodic
from node_lifecycle.ready_line import announce_ready
from omron_arcl import InvalidCommand, parse_line, replies
from omron_ld90.nodes.rviz.interactive_goals import HandleAction, InteractiveGoals
from omron_ld90.nodes.rviz.user_feedback import UserFeedback
from omron_ld90.nodes.support import shared_parameters
from omron_ld90.nodes.support.click_rule import ClickRule
from omron_ld90.nodes.support.command_client import CommandClient
from omron_ld90.nodes.support.displayed_map import DisplayedMap
from omron_ld90.nodes.support.fleet_missions import FleetMissions
from omron_ld90.nodes.support.old_messages import OldMessages, publishers_by_master
from omron_ld90.nodes.support.transforms import wait_for_transform
from omron_ld90.operator.goal_clicks import (
    Target,
    explain_miss,
    extent_in_x,
    resolve_click,
    targets_of,
)
from omron_ld90.operator.localizing import ASKED_FOR, Judged, LocalizeQuestion, LocalizingWatch
from omron_ld90.operator.notices import NoticeSeverity, OperatorNotice
from omron_ld90.operator.ready_notice import Advice, ReadyNotice
from omron_ld90.units import millimetres
from omron_ld90_msgs.msg import CommandRefused, ExecuteCommandResult, LinkState
from omron_map import MapDocument

TRANSFORM_TIMEOUT = 0.3  # s
CHECK_PERIOD = 0.5  # s

# The commands of those menu entries that do not depend on the goal.
COMMANDS = {HandleAction.DOCK: 'dock', HandleAction.UNDOCK: 'undock', HandleAction.STOP: 'stop'}

LOCALIZE = 'localizeToPoint'

# The messages for the end of a command. If the robot gave no words, {words} is the command.
ENDINGS: Dict[int, Tuple[NoticeSeverity, str]] = {
    ExecuteCommandResult.SUCCEEDED: (NoticeSeverity.GOOD, '{words}'),
    ExecuteCommandResult.FAILED: (NoticeSeverity.BAD, '{command} failed: {words}'),
    ExecuteCommandResult.INTERRUPTED: (NoticeSeverity.INFO, '{command} was interrupted: {words}'),
    ExecuteCommandResult.LOST: (NoticeSeverity.BAD, '{command} was lost: {words}'),
    ExecuteCommandResult.TIMED_OUT: (NoticeSeverity.BAD, '{command} timed out: {words}'),
    ExecuteCommandResult.REFUSED: (NoticeSeverity.BAD, '{command} refused: {words}'),
    ExecuteCommandResult.CANCELLED: (NoticeSeverity.INFO, '{command} was cancelled'),
    ExecuteCommandResult.EMERGENCY_STOPPED: (NoticeSeverity.BAD, '{command}: emergency stop'),
    ExecuteCommandResult.NEVER_SENT: (NoticeSeverity.BAD, '{command} was not sent: {words}'),
    ExecuteCommandResult.OVERRULED: (NoticeSeverity.INFO, '{command} was not sent: {words}'),
}


class Given(NamedTuple):
    """A command that was given, and the place (m, in the map) at which its result is shown."""

    command: str
    place: Optional[Tuple[float, float]]


class GoalSender:
    """The node: see the module's text.

    The class has many attributes because it connects the parts of the node.
    """

    def __init__(self) -> None:
        self._map_frame = parameter('~map_frame', 'map')
        self._tolerance = number('~click_tolerance', 0.5, 0.01, 10.0)
        self._rule = ClickRule.of_this_node()

        self._lock = threading.RLock()
        self._targets: Optional[List[Target]] = None  # None: no map is displayed
        self._given: Dict[int, Given] = {}  # commands under way, by number
        self._localizing, self._question = LocalizingWatch(), LocalizeQuestion()
        self._count = 0
        self._heading: Optional[float] = None  # degrees
        self._is_connected, self._ready = False, ReadyNotice(
            rospy.get_namespace().strip('/'), Advice(choice(
                '~ready_advice', Advice.COMMAND.value, tuple(one.value for one in Advice))))

        self._feedback = UserFeedback(self._map_frame)
        self._handles = InteractiveGoals(
            self._map_frame, shared_parameters.base_frame(),
            number('~handle_size', 0.7, 0.3, 3.0), self._on_handle)
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._commands = CommandClient(self._on_end, self._on_line)
        self._missions = FleetMissions(self._rule.robot, self._on_mission)
        self._old = OldMessages(publishers_by_master).start()
        self._old.watch('clicked_point')
        for topic, message, callback in (
                ('command_refused', CommandRefused, self._on_refused),
                ('link_state', LinkState, self._on_link),
                ('pose', PoseStamped, self._on_pose),
                ('arcl_response', String, self._on_response),
                ('clicked_point', PointStamped, self._on_click)):
            rospy.Subscriber(topic, message, callback, queue_size=10, tcp_nodelay=True)
        DisplayedMap(self._on_map, without='Clicks do nothing').subscribe()
        Periodic('commands', CHECK_PERIOD, self._check)
        Periodic('missions', SILENCE / 2, self._missions.ask)

    def close(self) -> None:
        """Ends the threads."""
        self._commands.close()

    def _check(self) -> None:
        self._commands.check()
        with self._lock:
            self._say_judged(self._localizing.check(time.monotonic()))

    # The state of the map, the fleet and the robot

    def _on_map(self, document: Optional[MapDocument], path: str) -> None:
        with self._lock:
            self._targets = None if document is None else targets_of(document)
            if document is not None:
                self._feedback.stay_within(*extent_in_x(document))
            self._handles.show(self._targets or ())
            self._say_ready()

    def _on_pose(self, message: PoseStamped) -> None:
        with self._lock:
            self._heading = math.degrees(yaw_from_quaternion(message.pose.orientation))
            self._feedback.robot = (message.pose.position.x, message.pose.position.y)

    def _on_link(self, message: LinkState) -> None:
        if message.link == LinkState.COMMANDS:
            with self._lock:
                self._is_connected = message.state == LinkState.CONNECTED
                self._handles.show_robot(self._is_connected)
                self._say_ready()

    def _say_ready(self) -> None:
        words = self._ready.words(self._targets, self._is_connected)
        if words:
            announce_ready(words)

    def _on_response(self, message: String) -> None:
        """Takes the robot's localization score, which comes with each status."""
        reply = parse_line(message.data)
        with self._lock:
            self._say_judged(self._localizing.observe(reply))

    # What the person requests

    def _on_click(self, message: PointStamped) -> None:
        point = self._in_map(message)
        if point is None:
            return
        old = self._old.reason(message, 'clicked_point')
        if old:
            self._feedback.say(NoticeSeverity.BAD, f'The click did nothing. {old}', point)
            return
        with self._lock:
            if self._targets is None:
                self._feedback.say(NoticeSeverity.BAD,
                                   'No map is displayed yet: the click did nothing.', point)
                return
            click = resolve_click(self._targets, point[0], point[1], self._tolerance)
            if click.hit and click.target:
                self._drive_to(click.target)
            else:
                self._feedback.say(NoticeSeverity.INFO, explain_miss(click, self._tolerance), point)

    def _in_map(self, message: PointStamped) -> Optional[Tuple[float, float]]:
        x, y = message.point.x, message.point.y
        if message.header.frame_id not in ('', self._map_frame):
            try:
                point = wait_for_transform(
                    TRANSFORM_TIMEOUT, lambda: self._buffer.transform(message, self._map_frame)
                ).point
                x, y = point.x, point.y
            except tf2_ros.TransformException as error:
                self._feedback.say(
                    NoticeSeverity.BAD, f'The click did nothing: {message.header.frame_id} has no '
                              f'transform to {self._map_frame} ({error}).')
                return None
        if not (math.isfinite(x) and math.isfinite(y)):
            rospy.logwarn('A click without finite coordinates did nothing.')
            return None
        return x, y

    def _on_handle(self, action: HandleAction, target: Optional[Target]) -> None:
        with self._lock:
            if action is HandleAction.LOCALIZE and target:
                self._localize(target)
                return
            self._question.forget()
            if action is HandleAction.GO and target:
                self._drive_to(target)
            elif action is HandleAction.STOP:
                self._give(COMMANDS[action], None)
            else:
                self._drive(COMMANDS[action], target)

    def _localize(self, target: Target) -> None:
        heading = self._heading if target.heading is None else target.heading
        if heading is None:
            self._feedback.say(
                NoticeSeverity.BAD,
                f'Which way does the robot face at {target}? Use 2D Pose Estimate.', target.place)
            return
        if not self._rule.refusal() and not self._question.is_confirmed(
                target.place, time.monotonic()):
            self._feedback.say(
                NoticeSeverity.INFO, f'Does the robot stand at {target}? If it does, choose "'
                f'{HandleAction.LOCALIZE.value}" once more within {ASKED_FOR:.0f} s.', target.place)
            return
        self._drive(f'{LOCALIZE} {millimetres(target.x)} {millimetres(target.y)} '
                    f'{round(heading)}', target)

    # Commands

    def _drive_to(self, target: Target) -> None:
        try:
            self._drive(target.command, target)
        except InvalidCommand as error:
            self._feedback.say(NoticeSeverity.BAD, str(error), target.place)

    def _drive(self, command: str, target: Optional[Target]) -> None:
        refusal = self._rule.refusal()
        if self._rule.asks_for_missions and target and _is_vertex(target, command):
            notice = self._missions.send(target)
            self._feedback.say(notice.severity, notice.text, _place(target))
        elif refusal:
            self._feedback.say(NoticeSeverity.BAD, refusal, _place(target))
        elif any(given.command == command for given in self._given.values()):
            notice = OperatorNotice(NoticeSeverity.INFO, f'{command}: already under way.')
            self._feedback.show(notice, _place(target))
        else:
            self._give(command, target)

    def _give(self, command: str, target: Optional[Target]) -> None:
        self._count += 1
        self._given[self._count] = Given(command, _place(target))
        self._feedback.say(NoticeSeverity.INFO, f'{command} ...', _place(target))
        self._commands.give(self._count, command)

    # Results

    def _on_line(self, number: int, line: str) -> None:
        """Shows the line with which the robot sets out."""
        with self._lock:
            given = self._given.get(number)
            if given and isinstance(parse_line(line), (replies.GoingTo, replies.GoingToPoint)):
                self._feedback.show(OperatorNotice(NoticeSeverity.INFO, line), given.place)

    def _on_end(self, number: int, result: ExecuteCommandResult) -> None:
        with self._lock:
            given = self._given.pop(number)
            if result.outcome == ExecuteCommandResult.SUCCEEDED and given.command.startswith(
                    LOCALIZE):
                self._localizing.begin(result.message or given.command, given.place,
                                       time.monotonic())
                return
            severity, text = ENDINGS.get(result.outcome, ENDINGS[ExecuteCommandResult.FAILED])
            self._feedback.say(severity, text.format(
                command=given.command, words=result.message or given.command), given.place)

    def _say_judged(self, judged: Optional[Judged]) -> None:
        if judged is not None:
            self._feedback.say(judged.notice.severity, judged.notice.text, judged.place)

    def _on_mission(self, notice: OperatorNotice, target: Optional[Target]) -> None:
        with self._lock:
            self._feedback.say(notice.severity, notice.text, _place(target))

    def _on_refused(self, message: CommandRefused) -> None:
        """Shows a refusal of the controller, which has already logged it."""
        self._feedback.show(OperatorNotice(
            NoticeSeverity.BAD, f'{message.command} refused: {message.reason}'))


def _is_vertex(target: Target, command: str) -> bool:
    """Returns whether a command drives the robot to a vertex of the graph."""
    return target.name.isdigit() and command.split()[0] in ('goto', 'dock')


def _place(target: Optional[Target]) -> Optional[Tuple[float, float]]:
    return target.place if target else None


def main() -> None:
    """Runs the node."""
    run('goal_sender', GoalSender)
