"""The plan in force: the order in which robots use places, even if they are late."""
from __future__ import annotations

from typing import Dict, Iterable, List, Mapping, NamedTuple, Optional, Set, Tuple

from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.planning.tasks import PlanningOutcome
from fleet_core.supervision.assumptions import Assumptions
from fleet_core.supervision.duties import Errand
from fleet_core.supervision.robot_plan import RobotPlan


class _Turn(NamedTuple):
    """What a drive waits for.

    Robot `first` must have driven the fraction `fraction` of its drive number `before`.
    """

    first: str
    before: int
    fraction: float


class PlanInForce:
    """The plans of all robots, and the order in which they use the places that they share.

    Only the order counts, not the times. A robot's drive is due when each robot that comes before
    it in the order has driven far enough.

    bases   -- by robot, the number that the plan's first drive has in the robot's record
    made_at -- the supervisor's time that is 0 in the plan's times
    assumptions -- the conditions under which the plan is useful
    """

    def __init__(self, outcome: PlanningOutcome, bases: Mapping[str, int], made_at: float,
                 assumptions: Assumptions) -> None:
        self.plans: Dict[str, RobotPlan] = {
            name: RobotPlan(drives, bases[name]) for name, drives in outcome.drives.items()}
        self.unserved: Dict[str, str] = dict(outcome.unserved)
        self.made_at = made_at
        self.assumptions = assumptions
        self.rests: Dict[str, Tuple[object, ...]] = {}
        """For robots without due edges: the state in which nothing is due. It consists of the
        robot's version, whether it is asked to move, the robot for which it waits, and the version
        of that robot."""
        self._turns: Dict[Tuple[str, int], List[_Turn]] = {}
        self._waited_for: Dict[str, List[Tuple[int, str]]] = {}
        for first, before, fraction, then, drive in outcome.precedence:
            self._turns.setdefault((then, drive), []).append(_Turn(first, before, fraction))
            self._waited_for.setdefault(first, []).append((before, then))

    def in_the_way(self, name: str, drive: int, records: Mapping[str, RouteRecord]) -> str:
        """Returns a robot that must drive on before robot `name` may begin its drive; empty: none.

        drive -- number of the drive in the plan
        """
        for turn in self._turns.get((name, drive), ()):
            plan = self.plans.get(turn.first)
            if plan is None:
                return turn.first
            number, fraction = records[turn.first].cleared
            if (number - plan.base, fraction) < (turn.before, turn.fraction):
                return turn.first
        return ''

    def turn_behind(self, name: str, drive: int, first: str) -> Optional[Tuple[int, float]]:
        """Returns how far `first` must have driven before this drive of robot `name` is due.

        The result is the number of an edge in the record of `first`, and a fraction of this edge.
        None: the drive does not wait for `first`.
        """
        plan = self.plans.get(first)
        return None if plan is None else max((
            (turn.before + plan.base, turn.fraction)
            for turn in self._turns.get((name, drive), ()) if turn.first == first), default=None)

    def asked_to_move(self, working: Iterable[str],
                      records: Mapping[str, RouteRecord]) -> Set[str]:
        """Returns the robots that must move because others wait for them.

        A robot must move if a robot of `working`, or another robot that must move, waits for one of
        its drives that is not released yet.

        records -- the route records of all robots
        """
        moving = set(working)
        asked: Set[str] = set()
        grew = True
        while grew:
            grew = False
            for first, waiting in self._waited_for.items():
                plan = self.plans.get(first)
                if plan is None or first in moving:
                    continue
                end = records[first].end
                if any(then in moving and plan.base + before >= end for before, then in waiting):
                    asked.add(first)
                    moving.add(first)
                    grew = True
        return asked

    def is_for(self, name: str, errand: Errand) -> bool:
        """Returns whether the plan was made for this errand of a robot."""
        assumed = self.assumptions.robots.get(name)
        return assumed is not None and assumed.errand == errand.key

    def plan_of(self, name: str) -> Optional[RobotPlan]:
        """Returns the plan of one robot; None: it has none."""
        return self.plans.get(name)
