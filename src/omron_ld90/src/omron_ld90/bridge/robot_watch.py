"""The robot's side of a route: what the robot, its links and others do, and what that means for it.

An event that ends the running route raises RouteFailed, or TakenOver where the robot obeys
somebody else already.
"""
from __future__ import annotations

from typing import Callable, Dict, Iterable, Optional

from omron_ld90.bridge import route_protocol as p
from omron_ld90.bridge.robot_errand import DOCK, RobotErrand
from omron_ld90.bridge.robot_links import RobotLinks
from omron_ld90.bridge.robot_place import RobotPlace
from omron_ld90.bridge.route_run import RouteFailed, RouteRun, TakenOver
from omron_ld90.bridge.route_settings import Settings

PATIENCE = 0.5  # s for the robot to say why its motion was interrupted


class RobotWatch:
    """What is known of the robot, and what it was told."""

    def __init__(self, settings: Settings, links: Iterable[str] = ()) -> None:
        """`links` are those that must have been heard of before the robot can be driven."""
        self.seen = RobotPlace()
        self.errand = RobotErrand()
        self._settings = settings
        self._links = RobotLinks(links)
        self._emergency = False
        self._owes_stop = False  # a stop could not reach the robot
        self._interrupted_at: Optional[float] = None
        self._strange_goals = 0  # status texts in a row that name a goal we do not know
        self._handlers: Dict[type, Callable[..., None]] = {
            p.GoalStarted: self._on_goal_started, p.GoalReached: self._on_goal_reached,
            p.GoalShown: self._on_goal_shown, p.MotionInterrupted: self._on_interrupted,
            p.RobotFailed: self._on_robot_failed, p.CommandRejected: self._on_rejected,
            p.EmergencyStop: self._on_emergency_stop, p.Docking: self._on_docking,
            p.ForeignCommand: self._on_foreign_command, p.CommandRefused: self._on_refused,
            p.LinkChanged: self._on_link,
        }

    def why_unknown(self) -> str:
        """What must be known before anybody can say whether the robot can drive, and is not."""
        return ('the robot has not told where it is' if self.seen.last is None
                else self._links.why_unknown())

    def why_unable(self) -> str:
        """Why the robot cannot drive now; empty when it can."""
        return 'emergency stop' if self._emergency else self._links.why_down()

    def stop(self) -> None:
        """Stops the robot, as soon as it can be reached."""
        self._owes_stop = not self._links.all_stand
        self.errand.stop()

    def begin(self) -> None:
        """A new route begins: what happened before does not count any more."""
        self._owes_stop = False
        self._interrupted_at = None
        self._strange_goals = 0

    def handle(self, event: p.Event, route: Optional[RouteRun], now: float) -> None:
        """Takes any event but a location or an order; `route` is the one that runs, if any."""
        self._handlers[type(event)](event, route, now)

    def check_clock(self, now: float) -> None:
        """Looks at what has been amiss for too long while a route runs."""
        lost = self._links.why_down_since(now - self._settings.link_timeout)
        if lost:
            raise RouteFailed(lost)
        if now - self.seen.heard > self._settings.location_timeout:
            raise RouteFailed('the robot has not told where it is for '
                              f'{self._settings.location_timeout:.0f} s')
        if self._interrupted_at is not None and now - self._interrupted_at > PATIENCE:
            raise TakenOver('The motion was interrupted.')

    # --- what the robot does and says -------------------------------------------------------------

    def _on_goal_started(self, event: p.GoalStarted, route: Optional[RouteRun], _: float) -> None:
        if route and not self.errand.started(event.goal):
            raise _going_elsewhere(event.goal)

    def _on_goal_reached(self, event: p.GoalReached, route: Optional[RouteRun],
                         now: float) -> None:
        if route and self.errand.arrived(event.goal):
            route.arrive(now)

    def _on_goal_shown(self, event: p.GoalShown, route: Optional[RouteRun], _: float) -> None:
        """The status text may lag, so a strange goal counts when it is shown twice."""
        strange = route is not None and not self.errand.shown(event.goal)
        self._strange_goals = self._strange_goals + 1 if strange else 0
        if self._strange_goals > 1:
            raise _going_elsewhere(event.goal)

    def _on_interrupted(self, event: p.MotionInterrupted, route: Optional[RouteRun],
                        now: float) -> None:
        if route and not self.errand.interrupted(event.text):
            self._interrupted_at = now  # an emergency stop or an error may follow at once

    def _on_robot_failed(self, event: p.RobotFailed, route: Optional[RouteRun], _: float) -> None:
        if route:
            raise RouteFailed(event.text)

    def _on_rejected(self, event: p.CommandRejected, route: Optional[RouteRun], _: float) -> None:
        if route and self.errand.is_ours(event.command):
            raise RouteFailed(event.text)

    def _on_emergency_stop(self, event: p.EmergencyStop, route: Optional[RouteRun],
                           _: float) -> None:
        self._emergency = event.active
        if route and event.active:
            raise RouteFailed('emergency stop')

    def _on_docking(self, state: p.Docking, route: Optional[RouteRun], now: float) -> None:
        before, was_reached = self.errand.docking, self.errand.reached
        asked = self.errand.docking_changed(state)
        if not route:
            return
        if not asked:
            raise TakenOver('The robot is docking.')
        if state is not before:
            route.count_as_progress(now)
        if self.errand.goal == DOCK and self.errand.reached and not was_reached:
            route.arrive(now)

    # --- what others do ---------------------------------------------------------------------------

    def _on_foreign_command(self, event: p.ForeignCommand, route: Optional[RouteRun],
                            _: float) -> None:
        self._owes_stop = False
        if route:
            raise TakenOver(f'{event.caller} sent {event.command!r}.')

    def _on_refused(self, event: p.CommandRefused, route: Optional[RouteRun], _: float) -> None:
        if route:
            raise RouteFailed(self.why_unable() or event.reason)

    def _on_link(self, event: p.LinkChanged, _: Optional[RouteRun], now: float) -> None:
        self._links.update(event, now)
        if self._owes_stop and self._links.all_stand:
            self.stop()


def _going_elsewhere(goal: str) -> TakenOver:
    return TakenOver(f'The robot is going to {goal or "another place"}.')
