"""The actors that carry out steps in virtual time: robots, persons, and programs outside."""
from __future__ import annotations

from functools import partial
from random import Random
from typing import Dict, Iterator, List, NamedTuple, Tuple

from fleet_core.supervision.missions import CommandKind, Mission, StepAnswer
from fleet_core.work.rules import StepDecision
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stops import Actor
from fleet_core.work.tables import StepState
from fleet_core.work.work import StepPlace, Work
from fleet_simulation.agv.steps import SECONDS, SimulatedSteps, asked_seconds
from fleet_simulation.driven_robot import DrivenRobot
from fleet_simulation.step_times import WorkTimes
from fleet_simulation.virtual_fleet import VirtualFleet
from route_protocol.steps import StepCommand


class _Answer(NamedTuple):
    """The answer that a step of a mission is done, and the virtual time at which it is due."""

    at: float
    mission: int
    key: int


class VirtualActors:
    """Carries out all steps of a virtual fleet. The duration of each step is drawn.

    Robots carry out their own steps. Persons and programs outside answer that a step is done.
    """

    def __init__(self, world: VirtualFleet[DrivenRobot], work: SiteWork, times: WorkTimes,
                 seed: int) -> None:
        self._world, self._times, self._seed = world, times, seed
        self._stations = {place: name for name, one in work.stations.items()
                          for place in one.places}
        self._answers: Dict[Tuple[int, int], _Answer] = {}
        world.steps = {name: SimulatedSteps(lambda: 1, partial(self._robots_seconds, name))
                       for name in world.agvs}
        for name, device in world.devices.items():
            device.seconds = times.of_device(name)

    def stepped(self) -> None:
        """Gives the supervisor the answers of persons and programs whose steps are done now."""
        now, running = self._world.now, set()
        due: List[_Answer] = []
        for mission, work, place, key in list(self._outside()):
            running.add((mission.serial, key))
            if (mission.serial, key) not in self._answers:
                self._answers[mission.serial, key] = _Answer(
                    now + self._seconds(mission, work, place, SECONDS), mission.request.id, key)
            if self._answers[mission.serial, key].at <= now:
                due.append(self._answers[mission.serial, key])
        self._answers = {known: one for known, one in self._answers.items() if known in running}
        for one in due:
            self._world.do(self._world.supervisor.command(
                one.mission, CommandKind.ANSWER, now, StepAnswer(StepDecision.DONE, one.key)))

    def _outside(self) -> Iterator[Tuple[Mission, Work, StepPlace, int]]:
        """Yields the steps that persons and programs carry out now, with their keys."""
        desk = self._world.supervisor.desk
        for mission in self._world.supervisor.book.serving.values():
            work = desk.work(mission.serial)
            for place, step, own in () if work is None else work.steps:
                if own.state is StepState.RUNNING and step.actor is not Actor.ROBOT:
                    assert work is not None
                    yield mission, work, place, own.key

    def _robots_seconds(self, name: str, command: StepCommand) -> float:
        """Returns how long a robot takes for the step of a command."""
        asked = asked_seconds(command)
        mission = self._world.supervisor.book.of_robot(name)
        work = None if mission is None else self._world.supervisor.desk.work(mission.serial)
        if mission is None or work is None:
            return asked
        place = next((place for place, _, own in work.steps if own.key == command.key), None)
        return asked if place is None else self._seconds(mission, work, place, asked)

    def _seconds(self, mission: Mission, work: Work, place: StepPlace, usual: float) -> float:
        """Draws the duration of a step. Each run with the same seed draws the same duration."""
        vertex = work.stops[place.stop].place
        time = self._times.of_step(work.step(place).type, self._stations.get(vertex, ''), vertex)
        if time is None:
            return usual
        return time.draw(Random(f'{self._seed} {mission.request.id} {place.stop} {place.step}'))
