"""A fleet on a graph whose long edges are cut into sections: no text for people names a section."""
from __future__ import annotations

import random
import re
from typing import Dict, Iterator, Set

import pytest
from fleet_builders import AGV, corridor
from proofs import is_whole

from fleet_core.fleet import RobotType
from fleet_core.planning.tasks import PlanningOutcome
from fleet_core.supervision.actions import AskPlanner
from fleet_core.supervision.fleet_view import robot_views
from fleet_core.supervision.settings import RobotSettings
from trajectory_graph import Graph, split_edges
from world import chaos
from world.chaos import DOCKS, PARKING, PEOPLE, ROBOTS, SAME, TROUBLE, YARD, Chaos, Event
from world.supervised_fleet import SupervisedFleet
from world.wrong_plans import WRONG

WHOLE = is_whole(__file__)
NAMED = re.compile(r'\b(edge|vert)(?:s|ex|ices)? ((?:-?\d+(?:, | and )?)+)', re.IGNORECASE)


def foreign_names(text: str, drawn: Graph) -> Set[str]:
    """Returns the edges and vertices that the text names but the drawn graph does not have."""
    known = {'edge': drawn.edges, 'vert': drawn.vertices}
    return {f'{kind} {id}' for kind, ids in NAMED.findall(text)
            for id in re.findall(r'\d+', ids) if int(id) not in known[kind.lower()]}


class TellingFleet(SupervisedFleet):
    """A fleet that collects all texts for people. A tenth of the planner's answers is wrong."""

    def __init__(self, *arguments: object, **options: object) -> None:
        self.texts: Dict[str, None] = {}
        super().__init__(*arguments, **options)  # type: ignore[arg-type]

    def _plan(self, question: AskPlanner) -> PlanningOutcome:
        outcome = super()._plan(question)
        if self.random.random() >= 0.1:
            return outcome
        return self.random.choice(tuple(WRONG.values()))(outcome, self.random)

    def step(self) -> None:
        super().step()
        self.texts.update(dict.fromkeys(self._said()))

    def close(self, *edges: int) -> None:
        super().close(*self.graph.whole_edges(edges))

    def _said(self) -> Iterator[str]:
        yield from self.notes
        yield from (status.reason for status in self.statuses)
        yield from (view.waits_for.text for view in robot_views(self.supervisor, self.now))
        yield self.supervisor.plan_executor.trouble


def live(seed: int) -> Dict[str, None]:
    """Returns the texts of one random run in the yard, whose edges are cut into sections of 1 m."""
    draw = random.Random(f'life {seed}')
    kind = RobotType('agv', 0.4, 1.0, docks=frozenset(DOCKS))
    fleet = TellingFleet(chaos.YARD, {name: (kind, 21 + k) for k, name in enumerate(ROBOTS)},
                         seed=seed, parking=PARKING, settings=RobotSettings(release_ahead=3.0))
    world = Chaos(fleet)
    acts = ['request'] * 12 + [*PEOPLE, *TROUBLE]
    acts.remove('change_graph')  # an edge without one of its sections is not a drawn edge
    for _ in range(40):
        world.happen(Event(draw.choice(acts), draw.choice(('now', 'order', 'plan')),
                           draw.choice((SAME, 0, 1, 2)), draw.randrange(61), 0.8))
    return fleet.texts


def test_in_random_lives_no_text_names_a_section(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chaos, 'YARD', split_edges(YARD, 1.0))
    texts: Dict[str, None] = {}
    for seed in range(6 if WHOLE else 3):
        texts.update(live(seed))
    assert len(texts) > 50 and any(NAMED.search(text) for text in texts)
    wrong = {text: names for text in texts for names in [foreign_names(text, YARD)] if names}
    assert not wrong


DRAWN = corridor(8)  # edge k joins the vertices k and k + 1


@pytest.fixture
def fleet() -> TellingFleet:
    """Robots at both ends of a corridor whose edges are cut into three sections each."""
    return TellingFleet(split_edges(DRAWN, 0.7), {'a': (AGV, 1), 'b': (AGV, 8)})


def carry(fleet: SupervisedFleet, robot: str, edge: int) -> None:
    """Lets a person carry a robot to the middle of a drawn edge."""
    agv = fleet.agvs[robot]
    agv.forget()
    agv.edge, place = fleet.graph.nearest_edge(*DRAWN.curve(edge).point_at(1.0))
    agv.arc = place.arc_length


def test_a_carried_robot_is_told_by_the_drawn_edge(fleet: TellingFleet) -> None:
    fleet.run(1.0)
    carry(fleet, 'a', 5)
    fleet.run(2.0)
    assert fleet.supervisor.robots['a'].why.endswith(
        'it was expected at vertex 1, but is on edge 5 at 50 %')


def test_what_is_closed_is_told_by_the_drawn_edge(fleet: TellingFleet) -> None:
    fleet.request(1, 7, robot='a')
    fleet.run(3.0)
    fleet.close(5, 6)
    fleet.run(20.0)
    assert any('while edges 5, 6 are closed' in text for text in fleet.texts), fleet.texts
