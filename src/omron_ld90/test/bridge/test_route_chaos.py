"""Whatever the events, the follower survives, and no report contradicts an earlier one."""
from __future__ import annotations

from typing import Sequence, Tuple

from bridge_builders import DOCK_VERTEX, Bench, graph_of, yard
from hypothesis import given, settings
from hypothesis import strategies as st

from omron_arcl import ActivityKind, Outcome
from omron_arcl.records import MotionState
from omron_arcl.replies import DockingState
from omron_ld90.bridge import events as p
from omron_ld90.bridge.route_strategies import STRATEGIES
from route_protocol.values import EdgeState, RouteReport
from trajectory_graph import Graph

PART_OF_THE_YARD = graph_of({1: (0, 0), 2: (4, 0), 5: (8, 0), DOCK_VERTEX: (0, -4)},
                            {1: (1, 2), 5: (2, 5), 9: (1, DOCK_VERTEX)})
# for each vertex, the index of the edge to drive next
TURNS = st.lists(st.integers(0, 3), min_size=1, max_size=4)

DISTURBANCES = st.one_of(
    st.builds(p.RobotSeen, st.integers(0, 10**12), st.sampled_from(list(ActivityKind)),
              st.one_of(st.none(), st.sampled_from(list(DockingState)))),
    st.builds(p.CommandEnded, st.integers(0, 12), st.sampled_from(list(Outcome)),
              st.just('words')),
    st.builds(p.MotionTold, st.integers(1, 4), st.integers(0, 4), st.booleans(), st.booleans(),
              state=st.sampled_from(MotionState), emergency_stop=st.booleans()),
    st.builds(p.LinkReported, st.sampled_from(list(p.RobotLink)), st.booleans(), st.just('why')))
HAPPENINGS = st.one_of(
    st.tuples(st.just('drive'), st.integers(1, 80)),
    st.tuples(st.just('drive'), st.integers(1, 80)),
    st.tuples(st.just('order'), st.integers(1, 3), TURNS),
    st.tuples(st.just('extend'), TURNS),
    st.tuples(st.just('push'), st.floats(-0.6, 0.6)),
    st.tuples(st.just('tell'), DISTURBANCES),
    st.tuples(st.just('stop')),
    st.tuples(st.just('restart'), st.sampled_from([0.0, 3.0, 25.0])),
    st.tuples(st.just('cut'), st.sampled_from(list(p.RobotLink))),
    st.tuples(st.just('mend')),
    st.tuples(st.just('deafen'), st.booleans()),
    st.tuples(st.just('silence'), st.sampled_from([1.0, 40.0])),
    st.tuples(st.just('graph'), st.sampled_from([yard(), PART_OF_THE_YARD])))


class WildBench(Bench):
    """A robot and its follower, with random events."""

    def __init__(self, *arguments) -> None:
        self.deaf = False
        super().__init__(*arguments, links=tuple(p.RobotLink))

    def give(self, give: p.Give) -> None:
        if self.deaf:
            self.tell(p.CommandEnded(give.number, Outcome.NEVER_SENT, 'never sent'))
        else:
            super().give(give)

    def drive(self, steps: int) -> None:
        for _ in range(steps):
            self.step()

    def deafen(self, deaf: bool) -> None:
        self.deaf = deaf

    def cut(self, link: p.RobotLink) -> None:
        self.link_is_up[link] = False

    def mend(self) -> None:
        self.link_is_up = dict.fromkeys(p.RobotLink, True)

    def push(self, aside: float) -> None:
        x, y = self.robot.position
        self.robot.position = (x, y + aside)

    def silence(self, seconds: float) -> None:
        self.wait(seconds)

    def order(self, route_id: int, turns: Sequence[int]) -> None:
        edge, projection = yard().nearest_edge(*self.robot.position)
        first = edge if projection.fraction < 0.5 or turns[0] % 2 else -edge
        self._order(route_id, (first,), turns)

    def extend(self, turns: Sequence[int]) -> None:
        report = self.follower.report()
        if report.edges:
            self._order(report.route_id, report.edges, turns)

    def stop(self) -> None:
        super().order(9)

    def graph(self, graph: Graph) -> None:
        self._act(self.follower.use_graph(graph, self.now))

    def _order(self, route_id: int, begin: Tuple[int, ...], turns: Sequence[int]) -> None:
        edges = list(begin)
        for turn in turns:
            ways_on = yard().edges_from(yard().end_vertex(edges[-1]).id)
            edges.append(ways_on[turn % len(ways_on)])
        super().order(route_id, *edges)


@settings(max_examples=settings.default.max_examples * 3 // 2)
@given(st.sampled_from(sorted(STRATEGIES)), st.lists(HAPPENINGS, max_size=25))
def test_no_happenings_confuse_the_follower(strategy, happenings):
    bench = WildBench(yard(), 1, strategy)
    before = bench.follower.report()
    for what, *how in happenings:
        getattr(bench, what)(*how)
        after = bench.follower.report()
        check_change(before, after)
        before = after
    for report in [*bench.reports, before]:
        check_states(report)


def check_states(report: RouteReport) -> None:
    """Checks that the states are in the order of the edges, and that a failure has a reason."""
    done = report.states.count(EdgeState.COMPLETE)
    assert set(report.states[:done]) <= {EdgeState.COMPLETE}
    assert len(set(report.states[done:])) <= 1
    if report.states:
        assert bool(report.reason) == (EdgeState.FAILED in report.states)
    assert 0.0 <= report.pose.percentage <= 100.0


def check_change(before: RouteReport, after: RouteReport) -> None:
    """Checks that each complete or failed edge of a route keeps this state."""
    if after.route_id == before.route_id and after.edges == before.edges:
        assert after.states.count(EdgeState.COMPLETE) >= before.states.count(EdgeState.COMPLETE)
        if EdgeState.FAILED in before.states:
            assert (after.reason, after.states) == (before.reason, before.states)


@given(st.sampled_from(['vertex_by_vertex', 'direct', 'rolling']), st.lists(st.one_of(
    st.tuples(st.just('drive'), st.integers(1, 60)),
    st.tuples(st.just('restart'), st.sampled_from([0.0, 2.0, 8.0])),
    st.tuples(st.just('outage'), st.sampled_from(list(p.RobotLink)), st.integers(1, 15))),
    max_size=12))
def test_no_restart_and_no_short_outage_costs_the_route_or_gives_a_goal_twice(strategy, happenings):
    bench = WildBench(yard(), 1, strategy)
    Bench.order(bench, 7, 1, 5, 6)
    for what, *how in happenings:
        if what == 'outage':
            link, steps = how
            bench.cut(link)
            bench.deaf = link is p.RobotLink.COMMANDS
            bench.hear_links()
            bench.drive(steps)
            bench.mend()
            bench.deaf = False
            bench.hear_links()
            bench.drive(30)
        else:
            getattr(bench, what)(*how)
    bench.run()
    assert bench.states() == [2, 2, 2], bench.follower.report().reason.text
    assert len(set(bench.commands)) == len(bench.commands), bench.commands
