"""Stop all: every robot stands, and none is let go on before people say so, restarts or not."""
from __future__ import annotations

from typing import Iterable, Mapping

from graph_fleet_manager.supervision.journal import Journal
from graph_fleet_manager.supervision.outbox import Outbox
from graph_fleet_manager.supervision.reports import Report
from graph_fleet_manager.supervision.robots import ManagedRobot
from graph_fleet_manager.supervision.route_ids import is_past

STOPPED = 'fleet_is_stopped'
"""By this name the journal has whether it is."""


class FleetStop:
    """Whether the fleet is stopped, be it since before there was a supervisor."""

    def __init__(self, journal: Journal, robots: Mapping[str, ManagedRobot],
                 outbox: Outbox) -> None:
        self.is_in_force = bool(journal.value(STOPPED))
        self._robots, self._out = robots, outbox
        if self.is_in_force:
            self._halt(robot for robot in robots.values() if not robot.is_halted)

    def stop(self) -> None:
        """Every robot gets an empty route at once."""
        self._set(True)
        self._halt(self._robots.values())
        self._out.send()

    def end(self) -> None:
        """Robots may go on."""
        self._set(False)

    def look_for(self, robot: ManagedRobot, report: Report) -> None:
        """Stops the fleet where the first report of a robot tells that somebody did so past a
        supervisor that hung and was ended."""
        if not is_past(report.route_id) or self.is_in_force or robot.client.is_stopping:
            return
        self._out.note(f'{robot.name} was stopped past a fleet manager that hung and was ended: '
                       'the fleet is stopped until it is resumed.', True)
        self.stop()

    def _set(self, is_in_force: bool) -> None:
        self.is_in_force = is_in_force
        self._out.value_changed(STOPPED, int(is_in_force))

    def _halt(self, robots: Iterable[ManagedRobot]) -> None:
        for robot in robots:
            robot.client.halt(self._out.new_id)
            robot.is_halted = True
            self._out.robot_changed(robot.name)
