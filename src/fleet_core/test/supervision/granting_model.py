"""Grants while the planner works: a search through every sequence of events of a small fleet.

The robots, the planner and the interlocking are models. The real code decides which edges are due
(`due_edges`), which edges are foreseen (`foreseen_edges`), and whether an answer of the planner
fits (`Question.plan`).

The model is a fleet whose robots drive whole edges. Two edges exclude each other if they share a
vertex. The planner may answer with any plan that is right for the question: any choice of short
paths, and any order in which all robots reach their goals. A forgetful planner may leave out one
constraint of the order. The steps are: a robot drives its next edge; a robot is granted the next
edge that is due; the planner is asked; an answer comes.

What must hold:

POSSIBLE   no two edges of two robots that the planner counts as released exclude each other
ANSWERABLE for each question that is asked while a right plan is in force, a right plan exists
FITS       at least one of two consecutive answers is used
PLANNED    the plan in force has each edge that a robot holds
IN_TURN    if the plan is right, each edge that a robot holds is in its turn
LIVE       if the plan in force is right, all robots come to their goals
"""
from __future__ import annotations

from enum import Enum
from functools import lru_cache
from itertools import product
from typing import (
    Any,
    Collection,
    Dict,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Set,
    Tuple,
)

from fleet_builders import AGV, complete, grant

from fleet_core.interlocking.reports import GraphPosition
from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.planning.precedence import Constraint
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.tasks import PlannedDrive, PlanningOutcome, Task
from fleet_core.supervision import questions, release
from fleet_core.supervision.assumptions import Assumption, Assumptions, PlanRole, World
from fleet_core.supervision.duties import Duty
from fleet_core.supervision.plan_in_force import PlanInForce
from fleet_core.supervision.release import GrantGoal
from trajectory_graph import Graph

_NOWHERE = (frozenset(), frozenset(), frozenset())
_TO_THE_END = 10 ** 6
_AHEAD = 0.5  # m that are granted ahead of a robot; each edge has 1 m or more


class Flaw(Enum):
    """A violation of what must hold."""

    POSSIBLE = 'a question counts edges of two robots as released that exclude each other'
    ANSWERABLE = 'no right plan exists for a question'
    FITS = 'two answers in a row are not used'
    PLANNED = 'a robot holds an edge that the plan in force does not have'
    IN_TURN = 'a robot holds an edge before its turn'
    LIVE = 'robots wait for each other for ever'


class Guard(Enum):
    """A rule that the model can leave out."""

    DUE = 'only edges that are due are foreseen'
    FREE = 'only edges that the robots may have now, at once, are foreseen'
    LIMIT = 'after a useless answer, only foreseen edges are granted'
    PREFIX = 'an answer fits only if it begins with what was granted meanwhile'
    TURN = 'an answer fits only if what was granted meanwhile is in its turn'


class Plan(NamedTuple):
    """A plan: for each robot the number of its first drive, and its edges; and the order of use."""

    bases: Tuple[int, ...]
    drives: Tuple[Tuple[int, ...], ...]
    order: Tuple[Constraint, ...]
    is_right: bool = True


class Asked(NamedTuple):
    """An open question. It has for each robot: the base, the edges that count as released, and the
    number of the first edge that was not granted at that time. `is_limited`: only foreseen edges
    are granted.
    """

    bases: Tuple[int, ...]
    released: Tuple[Tuple[int, ...], ...]
    ends: Tuple[int, ...]
    is_limited: bool


class State(NamedTuple):
    """The state of the fleet.

    granted -- for each robot all edges that it was ever granted
    done    -- for each robot the number of these edges that it has driven
    useless -- number of consecutive answers that did not fit
    """

    granted: Tuple[Tuple[int, ...], ...]
    done: Tuple[int, ...]
    plan: Optional[Plan] = None
    asked: Optional[Asked] = None
    useless: int = 0
    questions: int = 0


class Found(NamedTuple):
    """The result of a search. `unused` counts the answers that did not fit."""

    states: int
    unused: int
    flaw: Optional[Flaw] = None
    way: Tuple[State, ...] = ()


class Fleet:
    """A fleet on a graph; `robots` has the start and the goal (vertex ids) of each robot.

    further   -- distance (m) ahead of each robot for which a question foresees edges
    forgetful -- the planner may leave out one constraint
    without   -- the rule that is left out
    """

    def __init__(self, graph: Graph, robots: Mapping[str, Tuple[int, int]], further: float,
                 forgetful: bool = False, without: Optional[Guard] = None) -> None:
        self.graph, self.names = graph, tuple(robots)
        self.network = RoadNetwork(graph)
        self._starts = [start for start, _ in robots.values()]
        self._goals = [goal for _, goal in robots.values()]
        self._further, self._without, self._forgetful = further, without, forgetful
        self._records: Dict[Tuple[int, Tuple[int, ...], int], RouteRecord] = {}
        self.plan_in_force = lru_cache(None)(self._plan_in_force)
        self._answers = lru_cache(None)(self._find_answers)

    # -- the search -------------------------------------------------------------------------------

    def search(self, questions: int, sought: Collection[Flaw] = tuple(Flaw)) -> Found:
        """Visits each state that can be reached with at most `questions` questions to the planner.

        sought -- the flaws that end the search
        """
        first = self._ask(State(tuple(() for _ in self.names), tuple(0 for _ in self.names)))
        before: Dict[State, Optional[State]] = {first: None}
        waiting, unused = [first], 0
        for state in waiting:  # the list grows in the loop
            flaw = next((flaw for flaw in self._flaws(state) if flaw in sought), None)
            if flaw is not None:
                return Found(len(before), unused, flaw, _way(state, before))
            for later in self._steps(state, questions):
                unused += later.useless > state.useless
                if later not in before:
                    before[later] = state
                    waiting.append(later)
        return Found(len(before), unused)

    def _steps(self, state: State, questions: int) -> Iterator[State]:
        for k in range(len(self.names)):
            if state.done[k] < len(state.granted[k]):
                yield state._replace(done=_with(state.done, k, state.done[k] + 1))
            edge = self._next(state, k)
            if edge is not None and self._is_free(state, k, edge):
                yield state._replace(granted=_with(state.granted, k, (*state.granted[k], edge)))
        if state.asked is None and state.questions < questions:
            yield self._ask(state)
        if state.asked is not None:
            for answer in self._answers(state.asked, self._places(state, state.asked)):
                yield self._answered(state, state.asked, answer)

    def _flaws(self, state: State) -> Iterator[Flaw]:
        asked, plan = state.asked, state.plan
        if state.useless > 1:
            yield Flaw.FITS
        if asked is not None and any(
                _meet(self.graph, one, other) for k, edges in enumerate(asked.released)
                for more in asked.released[:k] for one in edges for other in more):
            yield Flaw.POSSIBLE
        elif asked is not None and (plan is None or plan.is_right) and not any(
                answer.is_right for answer in self._answers(asked, self._places(state, asked))):
            yield Flaw.ANSWERABLE
        if plan is None:
            return
        held = [granted[base:] for granted, base in zip(state.granted, plan.bases)]
        if any(edges != own[:len(edges)] for edges, own in zip(held, plan.drives)):
            yield Flaw.PLANNED
        elif plan.is_right and not self._is_in_turn(state, plan):
            yield Flaw.IN_TURN
        if plan.is_right and asked is None and not self._comes_home(state):
            yield Flaw.LIVE

    def _is_in_turn(self, state: State, plan: Plan) -> bool:
        in_force, records = self.plan_in_force(plan), self._all_records(state)
        return not any(in_force.in_the_way(name, number - base, records)
                       for name, base, done, granted in zip(self.names, plan.bases, state.done,
                                                            state.granted)
                       for number in range(max(done, base), len(granted)))

    def _comes_home(self, state: State) -> bool:
        """Returns whether all robots come to their goals with the plan in force.

        The order of steps does not matter.
        """
        moves = True
        while moves:
            moves = False
            for k in range(len(self.names)):
                if state.done[k] < len(state.granted[k]):
                    state = state._replace(done=_with(state.done, k, len(state.granted[k])))
                    moves = True
                edge = self._next(state, k)
                if edge is not None and self._is_free(state, k, edge):
                    state = state._replace(
                        granted=_with(state.granted, k, (*state.granted[k], edge)))
                    moves = True
        return all(self._at(state, k) == goal for k, goal in enumerate(self._goals))

    # -- the decisions of the program -------------------------------------------------------------

    def _next(self, state: State, k: int) -> Optional[int]:
        """The next edge that is due for a robot."""
        if state.plan is None:
            return None
        until = _TO_THE_END
        if state.asked is not None and state.asked.is_limited:
            until = state.asked.bases[k] + len(state.asked.released[k])
        due = release.due_edges(self.names[k], self.plan_in_force(state.plan),
                                self._all_records(state), GrantGoal(until, _AHEAD))
        return due.edges[0] if due.edges else None

    def _ask(self, state: State) -> State:
        records = self._all_records(state)
        foreseen: Mapping[str, Sequence[int]] = {}
        if state.plan is not None:
            plan = self.plan_in_force(state.plan)
            goals = {name: GrantGoal(_TO_THE_END, self._further) for name in self.names}
            if self._without is Guard.DUE:
                plan = self.plan_in_force(state.plan._replace(order=()))
            foreseen = release.foreseen_edges(
                goals, plan, records, lambda wanted: self._may_have(state, wanted))
        released = tuple((*state.granted[k][state.done[k]:], *foreseen.get(name, ()))
                         for k, name in enumerate(self.names))
        is_limited = state.useless > 0 and self._without is not Guard.LIMIT
        return state._replace(
            asked=Asked(state.done, released, tuple(map(len, state.granted)), is_limited),
            questions=state.questions + 1)

    def _answered(self, state: State, asked: Asked, answer: Plan) -> State:
        """The state after an answer, which is used if it fits."""
        robots = {name: Assumption(PlanRole.STANDING, 0, asked.bases[k], asked.ends[k], AGV,
                                   _NOWHERE, (Duty.MISSION, 0, 0, 0))
                  for k, name in enumerate(self.names)}
        question = questions.Question(
            tuple(Task(name, AGV) for name in self.names), (),
            Assumptions(robots, frozenset(), 0), 0.0, {})
        robots_then: Any = {name: _Robot(record)
                            for name, record in self._all_records(state).items()}
        world = World(robots_then, {}, self.network, {})
        fits = question.plan(self._outcome(answer), world) is not None
        if not fits and self._without in (Guard.PREFIX, Guard.TURN):
            fits = self._fits_but_for(question, answer, state, asked, world)
        if not fits:
            return state._replace(asked=None, useless=state.useless + 1)
        return state._replace(plan=answer, asked=None, useless=0)

    def _fits_but_for(self, question: questions.Question, answer: Plan, state: State, asked: Asked,
                      world: World) -> bool:
        begins = all(
            state.granted[k][asked.ends[k]:] == answer.drives[k][
                asked.ends[k] - asked.bases[k]:len(state.granted[k]) - asked.bases[k]]
            for k in range(len(self.names)))
        turns = question._is_in_turn(self.plan_in_force(answer), world)
        return turns if self._without is Guard.PREFIX else begins

    # -- the model of the interlocking ------------------------------------------------------------

    def _is_free(self, state: State, k: int, edge: int) -> bool:
        return not any(self._touches(edge, state, other)
                       for other in range(len(self.names)) if other != k)

    def _touches(self, edge: int, state: State, other: int) -> bool:
        held = state.granted[other][state.done[other]:]
        return any(_meet(self.graph, edge, one) for one in held) or (
            self._at(state, other) in _ends(self.graph, edge))

    def _may_have(self, state: State,
                  wanted: Mapping[str, Sequence[int]]) -> Dict[str, Tuple[int, ...]]:
        if self._without is Guard.FREE:
            return {name: tuple(edges) for name, edges in wanted.items()}
        found: Dict[str, Tuple[int, ...]] = {}
        for name, edges in wanted.items():
            k, free = self.names.index(name), []
            for edge in edges:
                if not self._is_free(state, k, edge) or any(
                        _meet(self.graph, edge, one) for more in found.values() for one in more):
                    break
                free.append(edge)
            found[name] = tuple(free)
        return found

    # -- the model of the planner -----------------------------------------------------------------

    def _places(self, state: State, asked: Asked) -> Tuple[int, ...]:
        """The vertices at which the plans of the robots begin, according to the question."""
        return tuple(self._vertex(k, state.granted[k][:asked.bases[k]])
                     for k in range(len(self.names)))

    def _find_answers(self, asked: Asked, places: Tuple[int, ...]) -> Tuple[Plan, ...]:
        ends = [self._end(places[k], asked.released[k]) for k in range(len(self.names))]
        found: Dict[Plan, None] = {}
        for ways in product(*(self._ways(ends[k], goal) for k, goal in enumerate(self._goals))):
            drives = tuple((*asked.released[k], *way) for k, way in enumerate(ways))
            for row in self._rows(tuple(map(len, asked.released)), drives, places):
                order = self._order(row, drives, asked.released)
                found[Plan(asked.bases, drives, order)] = None
                if self._forgetful:
                    found.update((Plan(asked.bases, drives, (*order[:k], *order[k + 1:]), False),
                                  None) for k in range(len(order)))
        return tuple(found)

    def _ways(self, start: int, goal: int) -> List[Tuple[int, ...]]:
        """The paths that have at most one edge more than the shortest path, and no vertex twice."""
        found: List[Tuple[int, ...]] = []
        waiting: List[Tuple[Tuple[int, ...], Tuple[int, ...]]] = [((start,), ())]
        for vertices, edges in waiting:  # the list grows in the loop
            if vertices[-1] == goal:
                found.append(edges)
                continue
            if found and len(edges) > len(found[0]):
                continue
            for edge in self.graph.edges_from(vertices[-1]):
                end = self.graph.end_vertex(edge).id
                if end not in vertices:
                    waiting.append(((*vertices, end), (*edges, edge)))
        return [edges for edges in found if len(edges) <= len(found[0]) + 1]

    def _rows(self, released: Tuple[int, ...], drives: Tuple[Tuple[int, ...], ...],
              places: Tuple[int, ...]) -> Iterator[Tuple[Tuple[int, int], ...]]:
        """Yields each sequence in which robots can make all drives after the released ones, one by
        one.
        """
        def at(k: int, count: int) -> int:
            return self._end(places[k], drives[k][:count])

        waiting: List[Tuple[Tuple[int, ...], Tuple[Tuple[int, int], ...]]] = [(released, ())]
        for counts, row in waiting:  # the list grows in the loop
            if all(count == len(own) for count, own in zip(counts, drives)):
                yield row
            for k, count in enumerate(counts):
                if count < len(drives[k]) and not any(
                        at(other, counts[other]) in _ends(self.graph, drives[k][count])
                        for other in range(len(drives)) if other != k):
                    waiting.append((_with(counts, k, count + 1), (*row, (k, count))))

    def _order(self, row: Sequence[Tuple[int, int]], drives: Tuple[Tuple[int, ...], ...],
               released: Tuple[Tuple[int, ...], ...]) -> Tuple[Constraint, ...]:
        """Returns the constraints that keep the sequence `row` of drives.

        Each drive waits for the last earlier drive of each other robot that is in its way.
        """
        whole = [*((k, number) for k, edges in enumerate(released)
                   for number in range(len(edges))), *row]
        found: Set[Constraint] = set()
        for place in range(len(whole) - len(row), len(whole)):
            k, number = whole[place]
            for other in range(len(drives)):
                before = [n for j, n in whole[:place] if j == other != k and _meet(
                    self.graph, drives[k][number], drives[j][n])]
                if before:
                    found.add(Constraint(self.names[other], before[-1], 1.0, self.names[k], number))
        return tuple(sorted(found))

    # -- values of the program --------------------------------------------------------------------

    def _outcome(self, plan: Plan) -> PlanningOutcome:
        return PlanningOutcome({name: tuple(PlannedDrive(edge, n, n + 1.0)
                                            for n, edge in enumerate(plan.drives[k]))
                                for k, name in enumerate(self.names)}, plan.order)

    def _plan_in_force(self, plan: Plan) -> PlanInForce:
        return PlanInForce(self._outcome(plan), dict(zip(self.names, plan.bases)), 0.0,
                           Assumptions({}, frozenset(), 0))

    def _all_records(self, state: State) -> Dict[str, RouteRecord]:
        return {name: self._record(k, state.granted[k], state.done[k])
                for k, name in enumerate(self.names)}

    def _record(self, k: int, granted: Tuple[int, ...], done: int) -> RouteRecord:
        key = k, granted, done
        if key not in self._records:
            record = self._records[key] = RouteRecord(self.graph, AGV)
            record.position = GraphPosition(vertex=self._starts[k])
            if granted:
                grant(record, granted)
            complete(record, done)
            record.cleared = done, 0.0
        return self._records[key]

    def _at(self, state: State, k: int) -> int:
        return self._vertex(k, state.granted[k][:state.done[k]])

    def _vertex(self, k: int, driven: Sequence[int]) -> int:
        return self._end(self._starts[k], driven)

    def _end(self, start: int, edges: Sequence[int]) -> int:
        return self.graph.end_vertex(edges[-1]).id if edges else start


class _Robot(NamedTuple):
    record: RouteRecord


def _way(state: Optional[State], before: Mapping[State, Optional[State]]) -> Tuple[State, ...]:
    way: List[State] = []
    while state is not None:
        way.insert(0, state)
        state = before[state]
    return tuple(way)


def _with(values: Tuple, k: int, value: object) -> Tuple:
    return (*values[:k], value, *values[k + 1:])


def _ends(graph: Graph, edge: int) -> Tuple[int, int]:
    return graph.start_vertex(edge).id, graph.end_vertex(edge).id


def _meet(graph: Graph, one: int, other: int) -> bool:
    return bool(set(_ends(graph, one)) & set(_ends(graph, other)))
