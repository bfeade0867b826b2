"""The plan executor: asks the planner for plans, and requests grants of the edges that are due."""
from __future__ import annotations

from collections import deque
from math import inf
from typing import AbstractSet, Deque, Dict, FrozenSet, Mapping, NamedTuple, Optional, Tuple

from fleet_core.fleet import RobotType
from fleet_core.interlocking.interlocking import Gate, Interlocking, Refusal
from fleet_core.interlocking.resources import Resource
from fleet_core.planning.tasks import PlanningOutcome
from fleet_core.supervision.actions import AskPlanner
from fleet_core.supervision.assumptions import World
from fleet_core.supervision.duties import goes_until
from fleet_core.supervision.outbox import Outbox
from fleet_core.supervision.plan_in_force import PlanInForce
from fleet_core.supervision.questions import Question, question_of
from fleet_core.supervision.release import Due, GrantGoal, due_edges, foreseen_edges, has_enough
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.switching import OrderSwitching
from trajectory_graph import Graph
from trajectory_graph.drawn_names import edge_name

PLANNER_PATIENCE = 10.0  # s without an answer after which the planner is asked again
AGAIN = 2.0              # s between two plans while the plan does not serve all robots
HOLD = 2.0               # maximum number of s for which grants are limited while an answer is due
HELD_UP = 5.0            # s: if a due edge is refused longer than this, the plan counts as useless
USELESS = 3              # number of consecutive useless plans after which a person is called
_OPEN = 3                # number of open questions whose answers are still accepted
_TIMED = 5               # number of last answers to remember; the slowest one predicts the next
_PLANNING = '/planning'  # key of the planner's state in `note_state`; no robot has such a name
_HELD_UP = '/held_up'


class _Delay(NamedTuple):
    """Since when the interlocking refuses a due edge to a robot, and why."""

    since: float
    refusal: Refusal


class RoomForLoads(NamedTuple):
    """What must be free before robots that stand at their stops can take their loads.

    robots   -- robots that must leave
    vertices -- vertices at which no robot may park
    """

    robots: FrozenSet[str] = frozenset()
    vertices: FrozenSet[int] = frozenset()


class PlanExecutor:
    """The plan in force, the open questions to the planner, and what each robot waits for.

    `advance` runs one step. It asks the interlocking for the edges that are due in the order of the
    plan. It asks the planner for a new plan if the present one is not useful any more.

    Grants go on while the planner works, and may make the planner's answer useless. Then, until
    the next answer, only edges are granted that the planner already counts as released.

    switching -- looks for a better order while robots are late; None: the order stays
    rate      -- the factor by which robots are faster than the clock
    reserved  -- places of stations and queues
    laden     -- types of robots with loads, in addition to the types of the fleet

    Its attributes are the plan, the open questions and the results of the last questions. Each step
    needs all of them.
    """

    def __init__(self, robots: Mapping[str, ManagedRobot], interlocking: Interlocking,
                 outbox: Outbox, switching: Optional[OrderSwitching] = None,
                 rate: float = 1.0, reserved: FrozenSet[int] = frozenset(),
                 laden: Tuple[RobotType, ...] = ()) -> None:
        self.plan: Optional[PlanInForce] = None
        self.waits_for: Dict[str, str] = {}
        """By robot, what it waits for, in words; empty: nothing."""
        self.lacks: Dict[str, Resource] = {}
        """By robot, the resource for which it waits."""
        self.trouble = ''
        """Why the planner has not given the requested plan, in words; empty: it has given it."""
        self._robots, self._interlocking, self._outbox = robots, interlocking, outbox
        self._records = {name: robot.record for name, robot in robots.items()}
        self._switching, self._rate, self._laden = switching, rate, laden
        self._reserved = reserved
        self._room = RoomForLoads()
        self._open: Dict[int, Question] = {}
        self._number = 0
        self._asked_at = -inf
        self._was_useless = False
        """Whether grants during planning made the last answer useless."""
        self._took: Deque[float] = deque([HOLD], _TIMED)
        """s that the last answers took, at most HOLD."""
        self._is_anew = False
        # number of consecutive questions that failed or left robots unserved; also the next seed
        self._failures = 0
        self._delays: Dict[str, _Delay] = {}
        # number of consecutive plans with which a robot was held up
        self._useless = 0
        # by robot, the serial of the mission for which its route was given
        self._missions: Dict[str, int] = {}

    @property
    def is_planning(self) -> bool:
        """Whether an answer of the planner is due."""
        return bool(self._open)

    def plan_anew(self) -> None:
        """Notes that the next plan is to be made without keeping anything of the present one."""
        self._is_anew = True

    def make_room(self, room: RoomForLoads) -> None:
        """Notes what must be free before robots can take their loads."""
        if room != self._room:
            self._room = room
            self.plan_anew()

    # -- answers of the planner -------------------------------------------------------------------

    def plan_made(self, number: int, outcome: PlanningOutcome, world: World, now: float) -> bool:
        """Uses an answer of the planner if it fits, even if it is late.

        Returns whether the answer was expected.
        """
        question = self._open.pop(number, None)
        if question is None:
            return False
        fault = question.fault_of(outcome, world.network.graph)
        if fault:
            self._failures += 1
            self.plan_anew()  # the plan that the planner was to keep may be the cause
            self._note_trouble(f'the planner sent a plan that {fault}')
            return True
        self._note_trouble('')
        self._took.append(min(now - question.asked_at, HOLD))
        plan = question.plan(outcome, world)
        self._was_useless = plan is None
        if plan is not None:
            self.plan = plan
            self._open = {later: one for later, one in self._open.items() if later > number}
            self._failures = self._failures + 1 if plan.unserved else 0
            self._delays.clear()
        return True

    def plan_failed(self, number: int, reason: str) -> None:
        """Notes that the planner could not answer. The plan in force stays."""
        if self._open.pop(number, None) is not None:
            self._failures += 1
            self.plan_anew()  # the plan that the planner was to keep may be the cause
            self._note_trouble(f'the planner found none: {reason}')

    def _note_trouble(self, trouble: str) -> None:
        self.trouble = trouble
        self._outbox.note_state(_PLANNING, trouble and f'There is no plan: {trouble}. The planner '
                                'is asked again until it gives one.', 'The planner answers again.')

    # -- execution --------------------------------------------------------------------------------

    def advance(self, world: World, now: float) -> None:
        """Requests grants of due edges, and a new plan if the present one is not useful any more.
        """
        is_useful = self._is_useful(world, now)
        if self._switching is not None and self.plan is not None and is_useful and not self._open:
            self.plan = self._switching.better(self.plan, world, now) or self.plan
        if self.plan is not None and (is_useful or self._open or self.trouble):
            self._release(self.plan, world, now)
        if self._open and now - self._asked_at > PLANNER_PATIENCE:
            self._note_trouble('the planner does not answer')
        self._ask(world, is_useful, now)

    def _ends(self, now: float) -> Optional[Mapping[str, int]]:
        """Returns, by robot, the number of the edge before which grants end at present.

        None: grants are not limited.
        """
        is_limited = self._was_useless or self._useless
        if not (self._open and is_limited and now - self._asked_at < HOLD):
            return None
        return self._open[max(self._open)].ends

    def _is_useful(self, world: World, now: float) -> bool:
        """Returns whether the plan in force is still useful."""
        if self.plan is None or self.plan.assumptions.misfits(world) or (
                self.plan.assumptions.closed != world.network.closed):
            return False
        late = [name for name, delay in self._delays.items() if now - delay.since > HELD_UP]
        if not late:
            return True
        self._useless += 1
        if self._useless >= USELESS:
            told = ', '.join(
                f'{name} waits for '
                f'{_words(self._delays[name].refusal, self._robots[name].record.graph)}'
                for name in late)
            self._outbox.note_state(_HELD_UP, f'{self._useless} plans in a row could not be '
                                    f'carried out: {told}. Look at these robots.', '')
        return False

    def _release(self, plan: PlanInForce, world: World, now: float) -> None:
        """Requests grants of the edges that are due.

        A robot gets no edges if the plan's assumption about it does not hold.
        """
        asked, misfits = self._asked(plan, world), plan.assumptions.misfits(world)
        ends, versions, claims = self._ends(now), world.versions, self._interlocking.claims
        for name in claims.robots - plan.plans.keys():
            claims.want(name, ())
        for name in plan.plans:
            waits_for = self.waits_for.get(name, '')
            rest = versions[name], name in asked, waits_for, versions.get(waits_for)
            if plan.rests.get(name) == rest:
                continue
            plan.rests.pop(name, None)
            robot, errand = self._robots[name], world.errands[name]
            if not self._follows(robot, misfits):
                self._delays.pop(name, None)
                claims.want(name, ())
                continue
            due = Due([])
            if not has_enough(robot.record, robot.settings.release_ahead):
                goal = self._goal(name, plan, world, asked)
                if ends is not None:
                    goal = goal._replace(until=min(goal.until, ends.get(name, 0)))
                due = due_edges(name, plan, self._records, goal)
            self.waits_for[name] = due.waits_for
            self.lacks.pop(name, None)
            if not due.edges:
                self._delays.pop(name, None)
                if ends is None:
                    claims.want(name, ())
                    plan.rests[name] = (versions[name], name in asked, due.waits_for,
                                        versions.get(due.waits_for))
                continue
            serial = errand.mission.serial if errand.mission is not None else 0
            renews = bool(serial) and self._missions.get(name, serial) != serial
            given = self._interlocking.grant(robot, due.edges, renews)
            if given.edges:
                self._missions[name] = serial or self._missions.get(name, 0)
                self._outbox.robot_changed(name)
            self._note_refusal(name, given.refusal, now)

    def _asked(self, plan: PlanInForce, world: World) -> AbstractSet[str]:
        """Returns the robots that must leave a station, or make room for robots with an errand."""
        leave = {name for name, errand in world.errands.items()
                 if errand.limit.leaves or name in self._room.robots}
        return leave | plan.asked_to_move(
            [name for name, errand in world.errands.items()
             if errand.is_to_drive and name not in plan.unserved],
            self._records)

    @staticmethod
    def _follows(robot: ManagedRobot, misfits: AbstractSet[str]) -> bool:
        """Returns whether a robot may be granted more of its plan."""
        return robot.works and not robot.comes_to_rest and robot.name not in misfits

    def _goal(self, name: str, plan: PlanInForce, world: World,
              asked: AbstractSet[str]) -> GrantGoal:
        robot = self._robots[name]
        until = goes_until(robot, world.errands[name], plan.plans[name], name in asked,
                           plan.assumptions.robots[name].reach)
        return GrantGoal(until, robot.settings.release_ahead)

    def _foreseen(self, plan: PlanInForce, world: World) -> Mapping[str, Tuple[int, ...]]:
        """Returns the edges that robots may have now and that will be due before the planner
        answers.
        """
        asked, misfits = self._asked(plan, world), plan.assumptions.misfits(world)
        goals: Dict[str, GrantGoal] = {}
        for name in plan.plans:
            robot = self._robots[name]
            if self._follows(robot, misfits):
                goal = self._goal(name, plan, world, asked)
                distance = robot.type.speed * self._rate * max(self._took)
                goals[name] = goal._replace(ahead=goal.ahead + distance)
        return foreseen_edges(goals, plan, self._records, self._interlocking.would_grant)

    def _note_refusal(self, name: str, refusal: Optional[Refusal], now: float) -> None:
        if refusal is not None:
            self.waits_for[name] = _words(refusal, self._robots[name].record.graph)
            if refusal.resource is not None:
                self.lacks[name] = refusal.resource
        if refusal is None or refusal.gate not in _DELAYS:
            if self._delays.pop(name, None) is not None or refusal is None:
                self._useless = 0 if not self._delays else self._useless
                if not self._delays:
                    self._outbox.note_state(_HELD_UP, '', 'The plan is carried out again.')
        elif name not in self._delays:
            self._delays[name] = _Delay(now, refusal)

    def _ask(self, world: World, is_useful: bool, now: float) -> None:
        """Asks the planner for another plan if one is due."""
        if not self._is_to_ask(is_useful, now - self._asked_at):
            return
        # If the present plan cannot be carried out, the planner is not to keep it.
        kept = None if self._useless or self._is_anew else self.plan
        self._is_anew = False
        question = question_of(world, kept, self._failures, now,
                               {} if kept is None else self._foreseen(kept, world))
        self._asked_at = now
        self._number += 1
        if not question.tasks:
            self._open.clear()
            self.plan = question.plan(PlanningOutcome({}, ()), world)
            self._note_trouble('')
            return
        self._open = {number: one for number, one in self._open.items()
                      if number > self._number - _OPEN}
        self._open[self._number] = question
        self._outbox.put(AskPlanner(self._number, question.tasks, question.obstacles,
                                    world.network.closed, world.network.learned,
                                    world.network.geometry.alone,
                                    self._reserved | self._room.vertices,
                                    question.assumptions.seed, self._laden))

    def _is_to_ask(self, is_useful: bool, since: float) -> bool:
        """Returns whether another plan is due, `since` s after the last question."""
        again = bool(self._failures or (self.plan and self.plan.unserved))
        if is_useful and not self._is_anew and not (again and since >= AGAIN):
            return False
        if self._open and since <= PLANNER_PATIENCE:
            return False
        return not self._failures or since >= AGAIN


_DELAYS = (Gate.OCCUPIED, Gate.CLOSED_TO_LOAD, Gate.TOO_NEAR, Gate.NOT_CONNECTED)
"""The gates whose refusals last as long as the plan."""


def _words(refusal: Refusal, graph: Graph) -> str:
    """Returns what a robot waits for after a refusal, in words."""
    if refusal.gate is Gate.CLOSED_EDGE:
        return f'{edge_name(graph, abs(refusal.edge))}, which is closed'
    if refusal.gate is Gate.CLOSED_TO_LOAD:
        return f'{edge_name(graph, abs(refusal.edge))}, which is closed to its load'
    if refusal.gate is Gate.CLAIM:
        return str(refusal.resource) + f', which {refusal.other} claims' * bool(refusal.other)
    if refusal.gate is Gate.NOT_READY:
        return refusal.other or 'a new location of its own'
    if refusal.gate is Gate.UNKNOWN_ROBOT:
        return (f'{refusal.other}, which has never reported: switch it on, or '
                f'`fleet absent {refusal.other}`')
    return refusal.other or refusal.gate.value
