"""The bridge's core, the controller's core and a robot that speaks ARCL, with delays between them.

There is no ROS and no socket. Everything happens on one clock, nothing is random, and each line and
message takes a given time. A person may stop the robot at any moment.
"""
from __future__ import annotations

from functools import partial
from typing import Callable, List, Optional, Sequence, Tuple, Union

from bridge_builders import (
    BRIDGE,
    DOCK_VERTEX,
    ENDINGS,
    NANOSECONDS,
    GraphRobot,
    told_of,
)
from modelled_controller import Delays, ModelledController
from simulated_robot import SimulatedRobot
from speaking_robot import SpeakingRobot
from timeline import Timeline

from omron_arcl import (
    ArclError,
    Execution,
    Giver,
    NotConnected,
    Outcome,
    read_activity,
)
from omron_arcl.drives import Overruled
from omron_arcl.records import MotionCause, RobotMotion
from omron_arcl.replies import DockingState, DockingStatus
from omron_ld90.bridge import events as p
from omron_ld90.bridge.route_follower import RouteFollower
from omron_ld90.bridge.route_strategies import STRATEGIES, RouteSettings
from route_protocol.values import RouteOrder, RouteReport
from trajectory_graph import Graph

PERSON = Giver('/rviz', 'process 1')
TICK = 0.1
AnyRobot = Union[SpeakingRobot, SimulatedRobot]


class DelayedDrive:
    """A route on which a person may stop the robot.

    passed -- drives of the route that passed a person's stop: the bridge gave them, or the
        controller let them through, although it knew of the stop
    crossed -- whether a drive that was on its way reached the robot after a person's stop with
        another client; no program could hold the drive back
    """

    def __init__(self, graph: Graph, vertex: int, strategy: str, delays: Delays,
                 interruption: str, braking: float) -> None:
        self._time = Timeline(100.0)
        self.later, self.run = self._time.later, self._time.run
        self._graph = graph
        self._edges: Tuple[int, ...] = ()  # edges of the route
        self.delays = delays
        self.up = dict.fromkeys(p.RobotLink, True)
        self.stopped_at: Optional[float] = None  # time of the person's last stop
        self.bridge_knows = self.controller_knows = False
        self.crossed = self._stopped_at_robot = False
        self.spared = False  # True: no more links or nodes fail
        self.passed: List[str] = []
        self.trace: List[str] = []
        self.watchers: List[Callable[[str], None]] = []  # called at each moment of the drive
        self._generation = 0  # number of the bridge's process
        self._last_number = 0  # number of the bridge's last command
        self._drives: List[Execution] = []  # drives of the route that the controller let through
        self.bridge: Optional[RouteFollower] = None
        self._told: Optional[RobotMotion] = None  # latched message of the controller
        self._motion_connection = 0  # counts the breaks and repairs of `motion`; odd: it is broken
        self._controller = self.make_controller(delays)
        self.robot = self.make_robot(vertex, interruption, braking)
        self.bridge = RouteFollower(
            RouteSettings(dock_vertex=DOCK_VERTEX, strategy=STRATEGIES[strategy]), graph,
            tuple(p.RobotLink))
        self._time.every(TICK, self._tick)
        self._time.every(1.0, self._report_links)
        self._time.every(GraphRobot.STATUS_PERIOD, self._show_status)
        self._hear_latched()
        self.run(1.5)

    def make_controller(self, delays: Delays) -> ModelledController:
        """Makes the controller that drives the robot."""
        return ModelledController(self._time, delays, self._reach_robot, self._on_motion)

    def make_robot(self, vertex: int, interruption: str, braking: float) -> AnyRobot:
        """Makes the robot."""
        return SpeakingRobot(self._graph, vertex, self._say, self.later, interruption, braking)

    # --- time -------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """The time in s."""
        return self._time.now

    @property
    def is_well(self) -> bool:
        """Whether the links are connected and the bridge runs."""
        return self.bridge is not None and all(self.up.values())

    @property
    def has_ended(self) -> bool:
        """Whether the bridge knows that its route has ended."""
        return self.bridge is not None and not self.bridge.running

    def _tick(self) -> None:
        goal = self.robot.move(self.now)
        if goal is not None:
            self._note('arrival')
        self._controller.turn()
        if self.bridge:
            self._act(self.bridge.tick(self.now))

    def _note(self, moment: str) -> None:
        self.trace.append(f'{self.now:.3f} {moment}')
        for watch in list(self.watchers):
            watch(moment)

    # --- acts of people and the fleet manager -----------------------------------------------------

    def order(self, route_id: int, *edges: int) -> None:
        """Sends a route of a fleet manager that knows of everything that has happened."""
        stamp = int(self.now * NANOSECONDS)
        self.stopped_at = None
        self.bridge_knows = self.controller_knows = self._stopped_at_robot = False
        self._edges = edges
        self._note('order')
        self._tell(RouteOrder(route_id, edges, stamp, stamp))

    def stop_by_topic(self) -> None:
        """Lets a person stop the robot in RViz, by `send_command` or by `execute_command`."""
        self._begin_stop('topic')
        self.later(self.delays.to_controller, partial(self._give_for_person, 'stop'))

    def stop_by_cancelling(self) -> None:
        """Lets a person cancel the goals of `execute_command`."""
        self._begin_stop('cancellation')
        self.later(self.delays.to_controller, self._take_cancellation)

    def _take_cancellation(self) -> None:
        self.controller_knows = True
        self._controller.cancel([execution for execution in self._drives
                                 if execution.result is None], PERSON)

    def send_elsewhere(self) -> None:
        """Lets a person send the robot, by `send_command`, to a vertex that is not on its route."""
        self._begin_stop('another drive')
        self.later(self.delays.to_controller, self._take_drive)

    def _take_drive(self) -> None:
        ends = {self._graph.end_vertex(edge).id for edge in self._edges}
        self._give_for_person(f'goto {min({4, 6} - ends)}')

    def _give_for_person(self, command: str) -> None:
        """Sends a person's command. Without a link, a drive fails, and a stop becomes owed."""
        try:
            self._controller.give(command, PERSON, 0, lambda result: None)
        except NotConnected:
            self.controller_knows = command == 'stop'
        else:
            self.controller_knows = True

    def stop_at_robot(self) -> None:
        """Lets a person stop the robot in MobilePlanner, or with another client of the robot."""
        self._begin_stop('another client')
        self._stopped_at_robot = True
        self.robot.hear_another('stop')

    def _begin_stop(self, how: str) -> None:
        self.stopped_at = self.now
        self._note(f'stop by {how}')

    def cut(self, link: p.RobotLink, seconds: float) -> None:
        """Breaks a link for some seconds."""
        if self.spared:
            return
        self.up[link] = False
        self._note(f'{link.value} down')
        if link is p.RobotLink.COMMANDS:
            self._controller.lose_link()
        self._report_links()

        def mend() -> None:
            self.up[link] = True
            if link is p.RobotLink.COMMANDS and not self._controller.connected:
                self._controller.connect()
            self._report_links()
            self._note(f'{link.value} up')
        self.later(seconds, mend)

    def restart_bridge(self, seconds: float) -> None:
        """Kills the bridge, and starts it after some seconds with its stored memory."""
        if self.bridge is None or self.spared:
            return
        dead, record = self.bridge, self.bridge.record
        self.bridge = None
        self._generation += 1
        self._note('bridge dies')

        def start() -> None:
            self.bridge = RouteFollower(dead.settings, dead.graph, tuple(p.RobotLink))
            if record:
                self.bridge.restore(record, True, self.now)
            self._report_links()
            self._hear_latched()
            self._note('bridge is back')
        self.later(seconds, start)

    def restart_controller(self) -> None:
        """Kills the controller, and starts it at once with its stored memory."""
        if self.spared or not self._controller.connected:
            return
        self._note('controller dies')
        self._controller.lose_link()
        self._controller.start()
        self.cut(p.RobotLink.COMMANDS, 2.0)

    # --- the bridge -------------------------------------------------------------------------------

    def _tell(self, event: p.Event) -> None:
        if self.bridge:
            self._judge(event)
            self._act(self.bridge.handle(event, self.now))

    def _judge(self, event: p.Event) -> None:
        """Notes whether the bridge can know of the person's stop from this event."""
        self.bridge_knows = self.bridge_knows or (self.stopped_at is not None and (
            isinstance(event, p.CommandEnded) and event.number == self._last_number
            and event.ending in (Outcome.INTERRUPTED, Outcome.CANCELLED, Outcome.OVERRULED)))

    def _act(self, actions: Sequence[p.Action]) -> None:
        for action in actions:
            if isinstance(action, p.Give):
                self._give(action)
            elif isinstance(action, RouteReport) and action.reason:
                self.trace.append(f'{self.now:.3f} route failed: {action.reason.text}')

    def _give(self, give: p.Give) -> None:
        generation, drives = self._generation, give.command != 'stop'
        self._last_number = give.number
        if drives and self.bridge_knows:
            self.passed.append(f'{self.now:.3f} given: {give.command}')

        def end(ending: Outcome, words: str) -> None:
            def tell() -> None:
                if generation == self._generation:
                    self.trace.append(f'{self.now:.3f} ended {give} {ending.value}: {words}')
                    self._tell(p.CommandEnded(give.number, ending, words))
            self.later(self.delays.ends, tell)

        self.later(self.delays.commands, lambda: self._take_from_bridge(
            give, Giver(BRIDGE, str(generation)), end))
        self._note(f'give {give.command}')

    def _report_links(self) -> None:
        for link, up in self.up.items():
            self._tell(p.LinkReported(link, up, '' if up else 'connection refused'))

    # --- the controller ---------------------------------------------------------------------------

    def _take_from_bridge(self, give: p.Give, giver: Giver,
                          end: Callable[[Outcome, str], None]) -> None:
        command = give.command
        try:
            execution = self._controller.give(
                command, giver, give.known_epoch,
                lambda result: end(ENDINGS[result.outcome], result.words), give.number)
        except Overruled as overruled:
            end(Outcome.OVERRULED, str(overruled))
        except ArclError as error:
            end(Outcome.NEVER_SENT, str(error))
        else:
            if execution.command.spec.drives:
                self._drives.append(execution)
                self._note(f'let through: {command}')
                if self.controller_knows:
                    self.passed.append(f'{self.now:.3f} let through: {command}')
        self._controller.call_back()

    def _reach_robot(self, line: str) -> None:
        if self._stopped_at_robot and line not in ('stop', 'oneLineStatus') and not self.passed:
            self.crossed = True
            self._note(f'crossed: {line}')
        self.robot.receive(line)

    def _say(self, line: str) -> None:
        if not line.startswith('Status'):
            self.trace.append(f'{self.now:.3f} robot: {line}')
        self._controller.say(line)

    def _on_motion(self, motion: RobotMotion) -> None:
        """Publishes the motion of the controller, also to a bridge that starts later."""
        self._told = motion
        if motion.memory.cause is MotionCause.OTHER_CLIENT and self.stopped_at is not None:
            self.controller_knows = True
        generation, connection = self._generation, self._motion_connection
        if self.hears_motions:
            self.later(self.delays.motions, lambda: self._motion_connection == connection
                       and self._hear_motion(motion, generation))

    @property
    def hears_motions(self) -> bool:
        """Whether messages of `motion` reach the bridge."""
        return self._motion_connection % 2 == 0

    def lose_motions(self, seconds: float) -> None:
        """Loses all messages of `motion` for some seconds. After that the newest message comes,
        because it is latched.
        """
        def mend() -> None:
            self._motion_connection += 1
            self._note('motion is heard again')
            self._hear_latched()
        if self.hears_motions and not self.spared:
            self._motion_connection += 1
            self._note('motion is not heard')
            self.later(seconds, mend)

    def _hear_latched(self) -> None:
        if self._told is not None:
            self._hear_motion(self._told, self._generation)

    def _hear_motion(self, motion: RobotMotion, generation: int) -> None:
        if generation == self._generation and self.bridge:
            self._tell(told_of(motion))

    # --- the receiver -----------------------------------------------------------------------------

    def _show_status(self) -> None:
        if not self.up[p.RobotLink.OUTGOING]:
            return
        activity = read_activity(self.robot.status)
        docking = (DockingState(activity.reply.docking.value)
                   if isinstance(activity.reply, DockingStatus) else DockingState.UNDOCKED)
        seen = p.RobotSeen(int(self.now * NANOSECONDS), activity.kind, docking,
                           self.robot.position)
        self.later(self.delays.statuses, lambda: self._tell(seen))
