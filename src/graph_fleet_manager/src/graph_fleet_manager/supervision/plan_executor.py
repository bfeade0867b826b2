"""Drives by plan: asks the planner when the plan does not serve any more, and releases routes."""
from __future__ import annotations

from math import inf
from typing import Dict, Mapping, Optional, Set, Tuple

from graph_fleet_manager.planning.road_network import RoadNetwork
from graph_fleet_manager.planning.tasks import Obstacle, Outcome
from graph_fleet_manager.supervision.actions import AskPlanner
from graph_fleet_manager.supervision.errands import (
    Duty,
    Errand,
    Snapshot,
    goes_until,
    have_moved,
    snapshot,
)
from graph_fleet_manager.supervision.outbox import Outbox
from graph_fleet_manager.supervision.plan_in_force import PlanInForce
from graph_fleet_manager.supervision.release import released
from graph_fleet_manager.supervision.robots import ManagedRobot

PLANNER_PATIENCE = 10.0  # s after which an answer of the planner is no longer waited for
AGAIN = 2.0              # s between two plans while somebody has none that serves it
_PLANNING = '/planning'  # what is told of it; no robot has such a name


class PlanExecutor:
    """The plan in force, the question to the planner that is open, and what robots may drive."""

    def __init__(self, robots: Mapping[str, ManagedRobot], outbox: Outbox) -> None:
        self.plan: Optional[PlanInForce] = None
        self.waits_for: Dict[str, str] = {}
        """What holds up each robot, in words; empty: nothing."""
        self.trouble = ''
        """Why there is no new plan though one was asked for, in words; empty: there is."""
        self._robots = robots
        self._outbox = outbox
        self._new_id = outbox.new_id
        self._asked: Optional[Tuple[int, float, Snapshot]] = None
        self._number = 0
        self._replan = True
        self._displaced = False         # somebody stands where no plan in force has it
        self._displaced_since = False   # nor the one that was asked for
        self._obstacles: Tuple[Obstacle, ...] = ()  # of the last question
        self._failed = False
        self._planned = -inf
        self._renew: Set[str] = set()   # robots whose next edges are another mission's

    @property
    def is_planning(self) -> bool:
        """Is an answer of the planner due? Until it is there nothing is released."""
        return self._asked is not None

    # -- what changes the plan --------------------------------------------------------------------

    def replan(self) -> None:
        """The plan may not serve any more what is to be done."""
        self._replan = True

    def forget_plan_of(self, name: str) -> None:
        """A robot does not stand any more where its plan has it."""
        if self.plan is not None:
            self.plan.drop(name)
        self._outbox.robot_changed(name)
        self._replan = self._displaced = self._displaced_since = True

    def plan_made(self, number: int, outcome: Outcome) -> bool:
        """Takes the planner's answer; tells whether it was waited for.

        One that does not fit what is released by now is left out.
        """
        if self._asked is None or self._asked[0] != number:
            return False
        _, asked_at, question = self._asked
        self._asked = None
        self._tell('')
        if question.fits(self._robots):
            self.plan = question.plan(outcome, asked_at)
            self._displaced = self._displaced_since
        else:
            self._replan = True
        return True

    def plan_failed(self, number: int, reason: str) -> None:
        """The planner could not answer; the plan in force stays."""
        if self._asked is not None and self._asked[0] == number:
            self._asked = None
            self._failed = True
            self._tell(f'the planner gave none: {reason}')

    # -- robots whose mission changed -------------------------------------------------------------

    def begin_mission(self, name: str) -> None:
        """A robot has another mission: its next edges go out under a new route id.

        One whose last mission was cancelled comes to rest first.
        """
        self._renew.add(name)
        self._replan = True

    def bring_to_rest(self, name: str) -> None:
        """A robot's mission is cancelled or paused: it stops as soon as it can."""
        self._robots[name].comes_to_rest = True
        self._outbox.robot_changed(name)

    def let_go_on(self, name: str) -> None:
        """Its mission goes on, before it has come to rest."""
        self._robots[name].comes_to_rest = False
        self._outbox.robot_changed(name)

    # -- what goes on -----------------------------------------------------------------------------

    def give_up_waiting(self, now: float) -> None:
        """A planner that does not answer is asked again."""
        if self._asked is not None and now - self._asked[1] > PLANNER_PATIENCE:
            self._asked = None
            self._replan = True
            self._tell('the planner does not answer')

    def _tell(self, trouble: str) -> None:
        self.trouble = trouble
        self._outbox.note_state(_PLANNING, trouble and f'There is no plan: {trouble}. It is asked '
                                'again and again.', 'The planner answers again.')

    def go_on(self, errands: Mapping[str, Errand], network: RoadNetwork, now: float) -> None:
        """Shortens and releases routes, and asks for another plan where one is wanted."""
        self.shorten()
        if self._asked is None:
            moved = have_moved(self._robots, self._obstacles)
            if moved and now - self._planned >= AGAIN:
                self._replan = self._displaced = True
            if not (moved or self._displaced):
                self._release(errands, network)
            self._ask(errands, network, now)

    def shorten(self) -> None:
        """Who is to come to rest gets no farther than the end of its edge."""
        for name, robot in self._robots.items():
            if not robot.comes_to_rest or not (robot.works or robot.client.order):
                continue  # an order that was not heard yet must not be heard as it was
            if not robot.client.shorten(self._new_id):
                robot.comes_to_rest = False
                self._replan = True
            self._outbox.robot_changed(name)

    def _release(self, errands: Mapping[str, Errand], network: RoadNetwork) -> None:
        """Gives every robot the edges that it may have now."""
        plan = self.plan
        if plan is None:
            return
        records = {name: robot.record for name, robot in self._robots.items()}
        working = [name for name, errand in errands.items()
                   if errand.duty in (Duty.MISSION, Duty.CHARGE) and name not in plan.unserved]
        asked = plan.asked_to_move(working, {name: record.end for name, record in records.items()})
        for name, own in plan.plans.items():
            if self._replan and name in self._renew:
                continue  # the plan leads to what was to be done before
            robot = self._robots[name]
            self.waits_for[name] = '' if robot.client.is_ready else 'a new location of its own'
            if not robot.works or robot.comes_to_rest or not robot.client.is_ready:
                continue
            until = goes_until(robot, errands[name], own, name in asked)
            given = released(name, plan, records, until, robot.settings.release_ahead,
                             network.closed)
            self.waits_for[name] = given.waits_for
            if given.edges:
                robot.client.extend(given.edges, self._new_id, name in self._renew)
                self._renew.discard(name)
                self._outbox.robot_changed(name)

    def _ask(self, errands: Mapping[str, Errand], network: RoadNetwork, now: float) -> None:
        """Asks for another plan where this one does not serve what is to be done now."""
        again = self._failed or bool(self.plan and self.plan.unserved)
        if not self._replan and not (again and now - self._planned >= AGAIN):
            return
        question = snapshot(self._robots, errands, self.plan, now)
        self._obstacles = question.obstacles
        self._replan = self._failed = self._displaced_since = False
        self._planned = now
        if not question.tasks:
            self.trouble = ''
            return
        self._number += 1
        self._asked = (self._number, now, question)
        self._outbox.put(AskPlanner(self._number, question.tasks, question.obstacles,
                                    network.closed, network.learned))
