"""Actions of the robot without a command: battery warnings, auto-docking, stopping without a link.

By default, only the actions about the battery are on. The sections `Docking` and `Outgoing ARCL
connection setup` of the configuration switch on the other actions.
"""
from __future__ import annotations

from omron_ld90_sim.behaviour import activities
from omron_ld90_sim.behaviour.states import DockingPhase
from omron_ld90_sim.clock import Ticker
from omron_ld90_sim.devices.battery import ChargeState
from omron_ld90_sim.interface.configuration_table import DOCKING, OUTGOING
from omron_ld90_sim.interface.server import ArclServer

PERIOD = 1.0                # s between two checks
WARN_BELOW = 25.0           # percent
WARN_EVERY = 60.0           # s
# ARCL manual I617-E-02 p. 185 and 256; the robot shuts down shortly afterwards
EMPTY = ('Fault: Fault_Critical UnderVoltage "Robot battery critically low" '
         '"The robot battery is critically low and will shut down shortly" false true false')
NO_LINK = ('link', 'OutgoingARCLConnLost')


class Autonomy:
    """Carries out the automatic actions of one robot."""

    def __init__(self, server: ArclServer) -> None:
        self._server, self._robot = server, server.robot
        self._warn_from = 0.0
        self._idle_since = server.clock.now
        self._docked_by_itself = False
        Ticker(server.clock, PERIOD, self._decide)

    def _decide(self) -> None:
        robot = self._robot
        if not self._server.online:
            return
        if robot.activity is not None or not robot.base.still:
            self._idle_since = self._server.clock.now
        self._need_link()
        if robot.docking.state is DockingPhase.DOCKED:
            self._leave_when_full()
        elif robot.docking.percent <= 0.0:
            self._give_out()
        else:
            self._warn()
            self._dock_when_due()

    def _warn(self) -> None:
        now = self._server.clock.now
        if self._robot.docking.percent < WARN_BELOW and now >= self._warn_from:
            self._warn_from = now + WARN_EVERY
            self._server.broadcast('TextRequestChargeVoltage')

    def _give_out(self) -> None:
        """Shuts the robot down because its battery is empty, until a person charges
        and starts it.
        """
        self._server.broadcast(EMPTY)
        self._robot.halt()
        self._server.shut_down()

    def _dock_when_due(self) -> None:
        settings, robot = self._server.configuration, self._robot
        idle = self._server.clock.now - self._idle_since
        if not settings.flag(DOCKING, 'AutoDock') or robot.activity or not robot.can_drive:
            return
        low = robot.docking.percent < settings.number(DOCKING, 'AutoDockStateOfCharge')
        station = activities.nearest_dock(robot)
        if station and (low or idle >= 60.0 * settings.number(DOCKING, 'AutoDockIdleTime')):
            self._docked_by_itself = True
            robot.start(activities.dock(robot, station))

    def _leave_when_full(self) -> None:
        robot = self._robot
        robot.docking.update()
        full = robot.docking.charge is ChargeState.FLOAT
        if self._docked_by_itself and full and not robot.activity:
            self._docked_by_itself = False
            if robot.can_drive:
                robot.start(activities.undock(robot))

    def _need_link(self) -> None:
        required = self._server.configuration.flag(OUTGOING, 'RequireConnectionToPathPlan')
        linked = any(session.outgoing for session in self._server.sessions)
        if required and not linked:
            if NO_LINK not in self._robot.permission.blocked_by:
                self._robot.permission.block(*NO_LINK)
        else:
            self._robot.permission.unblock(*NO_LINK)
