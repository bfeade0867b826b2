"""Sends commands to the robot's ARCL server, and publishes the robot's answers.

Topics in:
  send_command (std_msgs/String): one ARCL command, e.g. `goto 12`
  move_base_simple/goal (geometry_msgs/PoseStamped): pose to drive to; becomes a goal of `move_base`
  initialpose (geometry_msgs/PoseWithCovarianceStamped): where the robot is (`localizeToPoint`)
  /fleet_state (itrci_nav_msgs/FleetState), execution_route_states (.../ExecutionRouteStates): show
      whether a fleet drives the robot; if so, the two topics above (clicks in RViz) are refused
Topics out:
  arcl_response (std_msgs/String): every line that the robot sends after the login, byte for byte
  command_refused (omron_ld90_msgs/CommandRefused): a command that came by a topic was refused or
      failed
  motion (omron_ld90_msgs/Motion, latched): the giver that drives the robot, the robot's motion, and
      the owed stop
  link_state (omron_ld90_msgs/LinkState, latched): link `commands`
  /diagnostics
Actions:
  execute_command (omron_ld90_msgs/ExecuteCommand): one command until its completion
  move_base (move_base_msgs/MoveBase): drive to a pose (`gotoPoint`)
Parameters:
  ~robot_ip (required), ~port (7171): address of the robot's ARCL server
  ~password_file (''): file that contains the password of the server and nothing else; '': take the
      environment variable OMRON_LD90_PASSWORD, which roslaunch writes into its own log
  ~map_file (''): `.map` file whose goals are compared with the robot's
  ~base_map (''), ~graph_file (''): if base_map is set, the node first waits for map_file
  ~map_frame (map): frame of incoming poses
  ~allowed_commands ([motion, query]): kinds and names of commands that may be sent; the kinds are
      query, motion, device, configuration, dangerous, unknown
  ~session_log (''): file for all lines of both sides, passwords redacted; an older file is kept as
      <file>.old; ld90_sim --replay can play it back
  ~session_log_size (50.0 MB): a file that has grown to this size becomes <file>.old
  ~motion_file (omron_ld90/<namespace>_motion.json): file that keeps the driver of the robot and an
      owed stop over a restart; relative to ROS_HOME; '': no file
  ~robot_id (''): id of a simulated robot, which changes at each start of the simulator: a stored
      state with another id is not used; '': a real robot
  ~allow_takeover (false): true: the two click topics also move a robot that a fleet drives
  ~stop_on_shutdown (false): true: send `stop` when the node ends, e.g. by Ctrl-C; false: the robot
      drives on to its goal
  ~heartbeat (1.5 s): seconds between two requests to the robot for a sign of life
  ~silence (4.0 s): seconds without a line after which the link counts as dead
  ~reconnect_first (0.5 s), ~reconnect_most (10.0 s), ~reconnect_jitter (0.2): connection attempts
  ~wrong_password_wait (30.0 s): seconds before a refused password is tried again; the file is read
      only at the start, so restart the node after correcting it
"""
from __future__ import annotations

from typing import Any, Callable, List, Optional

import rospy
from geometry_msgs.msg import PoseStamped

from node_lifecycle import ConfigurationError, number, parameter, publish_diagnostics, run
from omron_arcl import (
    ArclError,
    Backoff,
    Client,
    Execution,
    Giver,
    HelpList,
    Link,
    Outcome,
    Received,
    Result,
    SessionLog,
    parse_line,
    printable,
)
from omron_arcl.drives import Drives
from omron_arcl.guard import Guard
from omron_arcl.records import RobotMotion
from omron_arcl.replies import Goal, MapChanged, OneLineStatus
from omron_ld90.nodes.controller_execute_command import ExecuteCommandServer
from omron_ld90.nodes.controller_goals import GoalComparison
from omron_ld90.nodes.controller_help import HelpReport
from omron_ld90.nodes.controller_motion import MotionFile, MotionTopic
from omron_ld90.nodes.controller_move_base import MoveBaseServer
from omron_ld90.nodes.controller_password import read_password
from omron_ld90.nodes.controller_refusals import Refusals
from omron_ld90.nodes.controller_repeats import ObeyedDrive
from omron_ld90.nodes.controller_topics import TopicCommands
from omron_ld90.nodes.support.click_rule import ClickRule
from omron_ld90.nodes.support.link_reports import (
    LinkReporter,
    misconfigured,
    robot_host,
    session_log,
)
from omron_ld90.nodes.support.old_messages import OldMessages, publishers_by_master
from omron_ld90.nodes.support.poses import pose_from_robot
from omron_ld90.nodes.support.publishing import LineMessage
from omron_ld90.nodes.support.robot_health import RobotHealth
from omron_ld90.nodes.support.shared_parameters import map_sources
from omron_ld90_msgs.msg import LinkState

LOOPBACK = ('127.0.0.1', 'localhost', '::1')  # addresses of a simulated robot
STOP_WITHIN = 1.5  # s that a stop may take at shutdown


class Controller:
    """The node; `make_client` makes its client with the given callbacks.

    The class has many attributes because it connects the parts of the node.
    """

    def __init__(self, make_client: Callable[..., Client], guard: Guard, goals: GoalComparison,
                 map_frame: str, log: Optional[SessionLog], stop_on_shutdown: bool) -> None:
        self._guard = guard
        self._goals = goals
        self._map_frame = map_frame
        self._log = log
        self._stop_on_shutdown = stop_on_shutdown
        self._help = HelpReport()
        self._obeyed = ObeyedDrive()
        self._reporter = LinkReporter(LinkState.COMMANDS, log)
        self._health = RobotHealth()
        self._motion = MotionTopic()
        self._responses = rospy.Publisher('arcl_response', LineMessage, queue_size=1000,
                                          tcp_nodelay=True)
        self._client: Client = make_client(on_line=self._on_line, on_link=self._on_link,
                                           on_login=self._on_login,
                                           on_motion=self._on_motion)
        refusals, old = Refusals(), OldMessages(publishers_by_master).start()
        client = self._client
        obeyed = self._obeyed.same_as
        ExecuteCommandServer(self._execute, client.cancel, client.cancel_all, obeyed, old)
        self._move_base = MoveBaseServer(self._execute, client.cancel, client.cancel_all, obeyed,
                                         old, refusals, map_frame)
        TopicCommands(self._execute, obeyed, self._move_base, refusals, old, map_frame,
                      ClickRule.of_this_node().refusal)
        publish_diagnostics(self._client.peer, {'link to the robot': self._reporter.diagnose,
                                                'robot': self._health.diagnose,
                                                'goals': goals.diagnose,
                                                'help list': self._help.diagnose})
        self._client.start()

    def close(self) -> None:
        """Ends the connection."""
        if self._stop_on_shutdown:
            self._stop()
        self._client.close()
        self._goals.close()
        if self._log:
            self._log.close()

    def _stop(self) -> None:
        try:
            result = self._client.execute('stop').wait(STOP_WITHIN)
        except ArclError as error:
            rospy.logwarn('The robot was not stopped at the end of this node: %s', error)
        else:
            if result is None:
                rospy.logwarn('A stop was sent at the end of this node; the robot has not '
                              'confirmed that it stands.')

    def _execute(self, text: str, giver: Giver, **options: Any) -> Execution:
        """Gives a command of `giver` if it is allowed; raises ArclError."""
        execution = self._client.execute(text, giver=giver, check=self._guard.check, **options)
        self._obeyed.given(execution)
        self._help.sent(execution.command)
        return execution

    # --- from the robot ---------------------------------------------------------------------------

    def _on_line(self, line: Received) -> None:
        self._responses.publish(LineMessage(line.raw))
        self._reporter.line()
        self._health.observe(line.reply)
        if isinstance(line.reply, MapChanged):
            self._ask_goals()
        elif (isinstance(line.reply, OneLineStatus) and line.reply.location
                and not line.late):
            location = line.reply.location
            pose = PoseStamped(pose=pose_from_robot(location.x, location.y, location.heading))
            pose.header.stamp = rospy.Time.now()
            pose.header.frame_id = self._map_frame
            self._move_base.feedback(pose)

    def _on_motion(self, motion: RobotMotion) -> None:
        self._guard.motion = motion
        self._motion.publish(motion)

    def _on_link(self, link: Link) -> None:
        if not link.connected:
            self._guard.goals = None
            self._health.forget()
        self._reporter.report(link)

    def _on_login(self, help_list: HelpList) -> None:
        self._help.listed(help_list)
        self._ask_goals()

    def _ask_goals(self) -> None:
        """Queries the goals of the robot. ~allowed_commands does not apply to this query."""
        self._guard.goals = None
        self._client.execute('getGoals', on_end=self._on_goals)

    def _on_goals(self, result: Result) -> None:
        if result.outcome is not Outcome.SUCCEEDED or result.left_out:
            reason = printable(result.words) or result.outcome.value
            rospy.logwarn('The robot did not list all its goals: %s.', reason)
            return
        replies = [parse_line(line) for line in result.lines]
        names = frozenset(reply.name for reply in replies if isinstance(reply, Goal))
        self._guard.list_goals(names)
        self._goals.robot_goals(names)


def _allowed_commands() -> List[str]:
    allowed = rospy.get_param('~allowed_commands', ['motion', 'query'])
    words = allowed.replace(',', ' ').split() if isinstance(allowed, str) else allowed
    if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
        raise ConfigurationError(f'Parameter {rospy.resolve_name("~allowed_commands")} is '
                                 f'{allowed!r}, but must be a list of kinds and command names.')
    return words


def start() -> Controller:
    """Reads the parameters and builds the node."""
    host = robot_host()
    port = int(number('~port', 7171, 1, 65535))
    password = read_password(parameter('~password_file', ''), is_simulated=host in LOOPBACK)
    backoff = Backoff(number('~reconnect_first', 0.5, 0.05, 600.0),
                      number('~reconnect_most', 10.0, 0.05, 600.0),
                      number('~reconnect_jitter', 0.2, 0.0, 1.0),
                      number('~wrong_password_wait', 30.0, 0.05, 3600.0))
    heartbeat = number('~heartbeat', 1.5, 0.1, 60.0)
    silence = number('~silence', 4.0, 0.2, 120.0)
    if silence <= heartbeat:
        raise ConfigurationError(f'Parameter {rospy.resolve_name("~silence")} is {silence}, but '
                                 f'must be longer than ~heartbeat, {heartbeat} s.')
    guard = Guard(_allowed_commands())
    if guard.unknown_words():
        rospy.logwarn('~allowed_commands contains names that are not in the table of commands: %s.',
                      ', '.join(sorted(guard.unknown_words())))
    log = session_log()
    goals = GoalComparison(parameter('~map_file', ''), map_sources())

    namespace = rospy.get_namespace().strip('/').replace('/', '_')
    kept = MotionFile(parameter('~motion_file', f'omron_ld90/{namespace}_motion.json'),
                      parameter('~robot_id', ''))
    kept.hold()
    records = Drives(kept.read(), kept.keep)

    def make_client(**callbacks: Any) -> Client:
        return Client(host, port, password, backoff=backoff, heartbeat=heartbeat, timeout=silence,
                      log=log, records=records, **callbacks)

    return Controller(make_client, guard, goals, parameter('~map_frame', 'map'), log,
                      parameter('~stop_on_shutdown', False, bool))


def main() -> None:
    """Runs the node."""
    run('omron_controller', start, misconfigured(LinkState.COMMANDS), ('omron_arcl',))
