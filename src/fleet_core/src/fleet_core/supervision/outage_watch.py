"""Handles the beginning and end of outages: changes the missions of the robots, and logs texts."""
from __future__ import annotations

from typing import Dict, Mapping, Optional

from fleet_core.supervision import mission_progress
from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.outbox import Outbox
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.work_desk import WorkDesk


class OutageWatch:
    """Compares the outage of each robot with its outage at the last comparison."""

    def __init__(self, book: MissionBook, robots: Mapping[str, ManagedRobot],
                 outbox: Outbox, desk: WorkDesk) -> None:
        self._book, self._robots, self._outbox, self._desk = book, robots, outbox, desk
        self._before: Dict[str, Optional[Outage]] = {}

    def compare(self) -> None:
        """Handles all changes since the last comparison."""
        for robot in self._robots.values():
            self.compare_robot(robot)

    def compare_robot(self, robot: ManagedRobot) -> None:
        """Handles the change of one robot's outage, if there is one."""
        name = robot.name
        if name in self._before and self._before[name] is robot.outage:
            return
        before = self._before.get(name)
        self._before[name] = robot.outage
        self._outbox.robot_changed(name)
        if robot.outage is not None:
            self._drop_out(robot)
        else:
            self._come_back(robot, before not in (None, Outage.UNSEEN))

    def _drop_out(self, robot: ManagedRobot) -> None:
        mission = self._book.of_robot(robot.name)
        mission_progress.drop_out(self._book, robot)
        if mission is not None:
            self._desk.parted(mission)
        if robot.outage is not Outage.UNSEEN and robot.outage is not None:
            self._outbox.note(f'{robot.name} cannot work: {robot.why or robot.outage.value}. '
                              f'{robot.outage.way_back(robot.name)}', True)

    def _come_back(self, robot: ManagedRobot, is_told: bool) -> None:
        mission = self._book.of_robot(robot.name)
        if mission is not None:
            self._book.set(mission, mission.state)
        if is_told:
            self._outbox.note(f'{robot.name} works again.')
