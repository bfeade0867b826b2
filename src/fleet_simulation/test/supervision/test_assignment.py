"""Many missions are assigned to many robots at once."""
from __future__ import annotations

from dataclasses import replace
from random import Random

from fleet_builders import AGV, ladder

from fleet_core.supervision.assignment import assign
from fleet_core.supervision.missions import Mission, Request
from world.supervised_fleet import SupervisedFleet

TRUCK = replace(AGV, name='truck')


def test_each_of_many_robots_gets_a_mission_that_its_type_can_serve():
    """The matching once took minutes if not every robot could serve every mission."""
    vertices = [100 * row + k for row in (0, 1) for k in range(1, 90)]
    graph = ladder(90)
    chance = Random(1)
    robots = {f'r{k}': (chance.choice((AGV, TRUCK)), vertex)
              for k, vertex in enumerate(vertices)}
    fleet = SupervisedFleet(graph, robots)
    fleet.run(1.0)
    missions = [Mission(id, Request(id, (chance.choice(vertices),),
                                    robot_type=chance.choice((kind.name, ''))))
                for id, (kind, _) in enumerate(robots.values(), 1)]
    supervisor = fleet.supervisor
    found = assign(missions, supervisor.robots, supervisor.robots, supervisor.acceptance,
                   supervisor.networks, fleet.now)
    assert len(found.assigned) == len(robots)
