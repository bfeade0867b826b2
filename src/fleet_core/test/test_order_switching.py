"""Order switching reverses only whole groups that no robot has used, makes no ring, and saves time.
"""
from __future__ import annotations

import time
from dataclasses import dataclass
from random import Random
from typing import Dict, List, Sequence, Tuple

import pytest
from fleet_builders import AGV, as_files, corridor, graph_of
from fleet_cases import Case
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from plan_checker import Order, World, faults, held_faults
from plan_replay import replay, replay_faults
from proofs import is_whole

from fleet_core.planning.edge_groups import EdgeGroup, RobotProgress, edge_groups
from fleet_core.planning.order_switching import GAIN, RemainingDrives, switch_order
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.plans import Drive
from fleet_core.planning.precedence import Constraint
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.tasks import PlannedDrive, PlanningOutcome, Task
from trajectory_graph import Graph, GraphError

ANY_SEED = given(seed=st.integers(0, 2 ** 32 - 1))
WHOLE = is_whole(__file__)
MANY = settings(max_examples=max(1, settings.default.max_examples // (4 if WHOLE else 12)),
                suppress_health_check=list(HealthCheck))


@dataclass
class Moment:
    """A fleet that drives according to a plan; some robots are late."""

    network: RoadNetwork
    clearance: float
    outcome: PlanningOutcome
    kinds: Dict[str, object]
    now: float
    late: Dict[str, float]

    @property
    def progress(self) -> Dict[str, RobotProgress]:
        """The progress if all robots had kept the times of the plan until now."""
        found = {}
        for name, planned in self.outcome.drives.items():
            plan = [Drive(self.network.drive(d.edge), d.start, d.end) for d in planned]
            begun = sum(drive.start < self.now for drive in plan)
            done = sum(drive.end <= self.now for drive in plan)
            share = 0.0
            if done < begun:
                share = (self.now - plan[done].start) / (plan[done].end - plan[done].start)
            found[name] = RobotProgress(self.kinds[name], plan, begun, (done, share))
        return found

    @property
    def courses(self) -> Dict[str, RemainingDrives]:
        """The remaining drives, with the driving times of the plan and the delays."""
        found = {}
        for name, one in self.progress.items():
            done = one.cleared[0]
            left = one.plan[done:]
            begins = (left[0].start - self.now if done < one.released else 0.0) if left else 0.0
            late, pauses = self.late.get(name, 0.0), [0.0] * len(left)
            if done == one.released:
                begins += late
            elif len(left) > 1:
                pauses[1] = late  # the robot drives to the end of its drive, and waits there
            found[name] = RemainingDrives(
                done, begins, tuple(d.end - d.start for d in left), tuple(pauses),
                tuple(d.start - self.now for d in left), len(one.plan))
        return found

    @property
    def groups(self) -> List[EdgeGroup]:
        """The edge groups of the remaining drives."""
        return edge_groups(self.network, self.clearance, self.progress)

    def plan(self, order: Sequence[Constraint], starts: Dict[str, Tuple[float, ...]]) -> dict:
        """The plan as the checker reads it: past drives in the old order, later ones in `order`."""
        progress = self.progress
        robots = {}
        for name, planned in self.outcome.drives.items():
            done = progress[name].cleared[0]
            new = [{'edge': d.edge, 'start': start + self.now,
                    'end': start + self.now + (d.end - d.start)}
                   for d, start in zip(planned[done:], starts.get(name, ()))]
            robots[name] = [d._asdict() for d in planned[:done]] + new
        ends = [drives[-1]['end'] if drives else 0.0 for drives in robots.values()]
        begun = [one for one in self.outcome.precedence if one.drive < progress[one.then].released]
        for name, one in progress.items():  # constraints for places that this robot has left by now
            done, share = one.cleared if one.cleared[1] else (one.cleared[0] - 1, 1.0)
            begun += [Constraint(name, done, share, other, two.released)
                      for other, two in progress.items()
                      if other != name and done >= 0 and two.released < len(two.plan)]
        return {'robots': robots, 'sum_of_costs': sum(ends), 'makespan': max(ends),
                'lower_bound': 0.0, 'precedence': [list(one) for one in (*begun, *order)]}


def moment(case: Case, random: Random) -> Moment:
    """A random moment of the fleet's plan; there must be a plan."""
    plan = case.plan(rounds=0)
    assume(plan is not None)
    drives = {name: tuple([PlannedDrive(**d) for d in robot])
              for name, robot in plan['robots'].items()}
    ends = [d[-1].end for d in drives.values() if d]
    assume(ends)
    outcome = PlanningOutcome(drives, tuple(Constraint(*one) for one in plan['precedence']))
    now = random.choice((0.0, random.uniform(0.0, max(ends))))
    late = {name: random.choice((0.0, random.uniform(0.0, 60.0))) for name in drives}
    return Moment(case.network, case.clearance, outcome,
                  {name: task.type for name, task in case.robots.items()}, now, late)


def a_case(seed: int) -> Case:
    """A random case with a valid graph."""
    try:
        return Case(Random(seed))
    except GraphError:
        assume(False)
        raise


def ends(courses: Dict[str, RemainingDrives], order: Sequence[Constraint]) -> Dict[str, float]:
    """Returns the end times of all robots, by repeated passes until nothing changes.

    `order` must have no ring.
    """
    starts = {(name, course.first + k): course.begins if k == 0 else 0.0
              for name, course in courses.items() for k in range(len(course.seconds))}
    for _ in range(len(starts) + 1):
        before = dict(starts)
        for name, course in courses.items():
            for k in range(1, len(course.seconds)):
                node, last = (name, course.first + k), (name, course.first + k - 1)
                starts[node] = max(starts[node], starts[last] + course.seconds[k - 1]
                                   + course.pauses[k])
        for a, i, f, b, j in order:
            if (a, i) in starts and (b, j) in starts:
                lag = f * courses[a].seconds[i - courses[a].first]
                starts[b, j] = max(starts[b, j], starts[a, i] + lag)
        if before == starts:
            return {name: starts[name, c.first + len(c.seconds) - 1] + c.seconds[-1]
                    for name, c in courses.items() if c.seconds}
    raise AssertionError('there is a ring')


# -- any fleet ------------------------------------------------------------------------------------

@MANY
@ANY_SEED
def test_groups_keep_a_plan_safe_and_each_that_can_be_reversed_does_so_the_other_way_round(seed):
    case = a_case(seed)
    at = moment(case, Random(seed))
    found, progress = at.groups, at.progress
    starts = {name: course.planned for name, course in at.courses.items()}
    order = [one for group in found for one in group.constraints]
    assert faults(case.world, at.plan(order, starts)) == []
    for number, turned in enumerate(found):
        for one in turned.reverse:
            assert one.before >= progress[one.first].released
            assert one.drive >= progress[one.then].released
        order = [one for k, group in enumerate(found)
                 for one in (turned.reverse if k == number else group.constraints)]
        if turned.reverse and not has_ring(at.courses, order):
            plan = at.plan(order, starts)
            assert held_faults(case.world, plan, Order(plan)) == []


def grid(random: Random) -> Tuple[Moment, World]:
    """Robots that cross a grid of roads, some of them late."""
    places = {10 * row + column: (2.0 * column, 2.0 * row)
              for row in range(1, 5) for column in range(5)}
    pairs = [(one, other) for one in places for other in (one + 1, one + 10) if other in places]
    graph = graph_of(places, dict(enumerate(pairs, 1)))
    count = random.randint(4, 8)
    begins, goals = (random.sample(sorted(places), count) for _ in range(2))
    at = planned(graph, **{f'r{k}': trip for k, trip in enumerate(zip(begins, goals))})
    at.now = random.choice((0.0, random.uniform(0.0, 15.0)))
    at.late = {name: random.choice((0.0, random.uniform(0.0, 60.0))) for name in at.kinds}
    return at, World(*as_files(graph, [AGV], {f'r{k}': (AGV.name, begin)
                                              for k, begin in enumerate(begins)},
                               {f'r{k}': (goal,) for k, goal in enumerate(goals)}, 0.1))


@settings(MANY, max_examples=settings.default.max_examples * (3 if WHOLE else 1))
@ANY_SEED
def test_a_switched_order_is_safe_without_rings_and_better_by_what_is_told(seed):
    random = Random(seed)
    at, world = grid(random)
    found, courses = at.groups, at.courses
    switched = switch_order(courses, found, gain=0.01)
    if switched is not None:
        plan = at.plan(switched.order(found), switched.starts)
        assert faults(world, plan) == []
        assert replay_faults(world, plan, replay(world, plan, random)) == []
        before = sum(ends(courses, [one for c in found for one in c.constraints]).values())
        after = sum(ends(courses, switched.order(found)).values())
        assert before - after == pytest.approx(switched.gain, rel=0.01, abs=0.01)
        assert after <= before - 0.005
    at.late = {}
    assert switch_order(at.courses, found, gain=0.0) is None  # no robot is late


def test_one_grid_in_ten_is_switched():
    grids = [grid(Random(seed))[0] for seed in range(40)]
    assert sum(switch_order(at.courses, at.groups) is not None for at in grids) >= 4


def has_ring(courses, order):
    """Returns whether robots wait for each other in a ring."""
    try:
        ends(courses, order)
    except AssertionError:
        return True
    return False


# -- single scenarios -----------------------------------------------------------------------------

def crossing() -> Graph:
    """Two roads of four edges each, vertices 1 to 4 and 11 to 14, that cross at vertex 3."""
    return graph_of({1: (-4.0, 0.0), 2: (-2.0, 0.0), 3: (0.0, 0.0), 4: (2.0, 0.0), 5: (4.0, 0.0),
                     11: (0.0, -4.0), 12: (0.0, -2.0), 14: (0.0, 2.0), 15: (0.0, 4.0)},
                    {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 5),
                     11: (11, 12), 12: (12, 3), 13: (3, 14), 14: (14, 15)})


def planned(graph: Graph, now: float = 0.0, late=None, **trips: Tuple[int, int]) -> Moment:
    """Robots that drive from one vertex to another."""
    network = RoadNetwork(graph)
    tasks = [Task(name, AGV, begin, destinations=(end,), stays=True)
             for name, (begin, end) in trips.items()]
    outcome = FleetPlanner(network, 0.1, [AGV]).plan(tasks, (), time.monotonic() + 60.0, rounds=0)
    assert not outcome.unserved
    return Moment(network, 0.1, outcome, dict.fromkeys(trips, AGV), now, late or {})


def first_through(at: Moment) -> str:
    """Returns the robot that passes first the only place where two robots meet."""
    (only,) = at.groups
    return only.first


def test_a_late_robot_lets_the_other_one_go_first():
    at = planned(crossing(), a=(1, 5), b=(11, 15))
    early = first_through(at)
    at.late = {early: 30.0}
    switched = switch_order(at.courses, at.groups)
    assert switched is not None and switched.reversed == {0}
    assert switched.gain > 20.0


def test_a_robot_that_was_let_into_the_crossing_goes_first_however_late():
    at = planned(crossing(), a=(1, 5), b=(11, 15))
    early = first_through(at)
    at.now = next(d.start for d in at.outcome.drives[early][1:]) + 0.1
    at.late = {early: 30.0}
    assert switch_order(at.courses, at.groups) is None


def test_a_gain_below_the_threshold_changes_nothing():
    at = planned(crossing(), a=(1, 5), b=(11, 15))
    at.late = {first_through(at): 30.0}
    gain = switch_order(at.courses, at.groups).gain
    assert switch_order(at.courses, at.groups, gain=gain + GAIN) is None



def test_who_stands_on_the_way_of_the_other_is_not_overtaken():
    at = planned(corridor(9), a=(3, 9), b=(1, 7))
    at.late = {'a': 60.0}
    assert [one.reverse for one in at.groups] == [()]
    assert switch_order(at.courses, at.groups) is None


def test_no_more_orders_are_tried_than_allowed_and_none_after_the_deadline():
    """Of fifty robots, half are late; the plan lets each late robot go first at some place."""
    courses, found = {}, []
    for k in range(25):
        late, other = f'late{k}', f'other{k}'
        for name, begins in ((late, 40.0 + k), (other, 0.0)):
            courses[name] = RemainingDrives(0, begins, (3.0,) * 20, (0.0,) * 20,
                                            tuple(3.0 * n for n in range(20)), 20)
        found.append(EdgeGroup(late, other, (Constraint(late, 9, 1.0, other, 10),),
                              (Constraint(other, 10, 1.0, late, 9),)))
    all_of_them = switch_order(courses, found)
    assert all_of_them.reversed == set(range(25))
    some = switch_order(courses, found, trials=11)
    assert len(some.reversed) == 10 and 24 in some.reversed  # one trial is the present order
    assert switch_order(courses, found, deadline=time.monotonic() - 1.0) is None
