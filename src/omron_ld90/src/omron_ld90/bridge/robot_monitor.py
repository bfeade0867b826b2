"""The known state of the robot, of its links and of other givers, and the commands that we gave."""
from __future__ import annotations

import math
from typing import Callable, Dict, Iterable, List, Optional, Type

from omron_arcl.replies import DockingState
from omron_ld90.bridge import events as p
from omron_ld90.bridge.goal_tracker import GoalTracker, RouteFailed, TakenOver
from omron_ld90.bridge.robot_state import MapLocation, RobotLinks, RobotLocation
from omron_ld90.bridge.route_strategies import RouteSettings
from route_protocol.values import EMERGENCY_STOP, EpochCause, Reason, ReasonCode

_BY_A_GIVER = (EpochCause.OTHER_GIVER, EpochCause.CANCEL)


class RobotMonitor:
    """Takes every event except orders; `check` raises an exception when the running route must end.

    The class contains all that is known about one robot, with one attribute for each fact and one
    method for each question.
    """

    def __init__(self, settings: RouteSettings, links: Iterable[p.RobotLink] = (),
                 number: int = 0, master: Callable[[], str] = lambda: '') -> None:
        """links -- the links that must be up before the robot can be driven

        number -- at least as great as the number of each earlier command
        master -- returns the name of the master whose orders count; empty: there is none
        """
        self.location = RobotLocation()
        self.links = RobotLinks(links, settings.link_timeout, settings.restart_timeout)
        self.tracker = GoalTracker()
        self.stop_owed_by_controller = False
        """Whether the controller reports that the robot has not obeyed a stop yet."""
        self.docking: Optional[DockingState] = None
        self.docking_changed = -math.inf
        self.emergency = False
        """Whether the emergency stop is pressed, or the motors are off after it."""
        self.seen: Optional[p.RobotSeen] = None
        """The last status."""
        self._settings = settings
        self.epoch = 0
        """The controller's last known epoch; 0: none is known yet."""
        self.foreign_epoch = 0
        """The newest epoch that this program did not begin, as far as it knows."""
        self.drives_for_us = False
        """Whether the present epoch began because the robot obeys a drive of ours."""
        self.overruled: Optional[EpochCause] = None
        """Why orders that were on their way must not be obeyed any more; None: they may."""
        self.was_moved_by_master = False
        """Whether a command of the master itself, not a route, drove or stopped the robot."""
        self._master = master
        self._is_unexplained = False  # the robot broke off a drive; the next epoch has the cause
        self._taken_over: Optional[TakenOver] = None
        self._number = number  # number of the last command
        self._handlers: Dict[Type[object], Callable[..., None]] = {
            p.RobotSeen: self._on_seen, p.CommandEnded: self._on_ended,
            p.MotionTold: self._on_motion, p.LinkReported: self._on_link,
        }

    # --- our commands ----------------------------------------------------------------------------

    def stop(self, epoch: int) -> None:
        """Gives a stop as soon as the robot can be reached. The stop does not end a drive that
        another giver began after `epoch`; 0: it ends any drive.
        """
        self.tracker.stop(epoch)

    def leave(self) -> None:
        """Notes that another giver drives the robot: our route does not control it any more."""
        self.tracker.end()

    def begin(self) -> None:
        """Notes that a new route begins: earlier failures and stops do not count any more."""
        self._taken_over = None
        self.tracker.forget()

    def route_extended(self) -> None:
        """Notes that a complete route gets longer. If another giver has driven the robot since the
        route ended, that drive does not count as a take-over.
        """
        self._taken_over = None

    def due_commands(self, now: float) -> List[p.Give]:
        """Returns the commands to give now; they count as given.

        No drive is given if another giver has begun an epoch, nor while it is unknown why the robot
        broke off a drive.
        """
        word = self.tracker.word
        if (self._taken_over or self._is_unexplained) and not word.is_stop or not word.due(
                self.links.stands(p.RobotLink.COMMANDS, now), now):
            return []
        self._number += 1
        return [word.give(self._number, self.epoch)]

    def resume(self, epoch: int, foreign_epoch: int, number: int) -> None:
        """Takes the epochs and the number that the program had before its restart."""
        self.epoch, self.foreign_epoch = epoch, foreign_epoch
        self._number = max(number, self._number)

    # --- judging the robot's state ----------------------------------------------------------------

    def why_unknown(self, now: float) -> Reason:
        """Returns the reason why it is unknown whether the robot can drive; empty: it can."""
        if self.location.last is None:
            return Reason(ReasonCode.NO_LOCATION, 'the robot has not reported its location')
        unusable = self.links.why_unusable(now)
        if not unusable and not self.epoch and self.links.are_expected:
            return Reason(ReasonCode.NOT_READY,
                          'omron_controller has not reported the motion of the robot')
        if not unusable and self._is_unexplained:
            return Reason(ReasonCode.NOT_READY,
                          'the robot has not said yet why it broke off its drive')
        if not unusable and self.is_location_overdue(now):
            return _no_location(now - self.location.heard)
        return unusable

    def is_heard(self, now: float) -> bool:
        """Returns whether the robot's links are up, and its last location is not too old."""
        return (self.location.last is not None and not self.links.why_unusable(now)
                and not self.is_location_overdue(now))

    @property
    def owes_stop(self) -> bool:
        """Whether a stop (ours or another giver's) may not have been obeyed yet."""
        return self.must_stop or self.stop_owed_by_controller

    @property
    def must_stop(self) -> bool:
        """Whether we have given a stop that the controller has not taken yet."""
        return self.tracker.word.is_stop and not self.tracker.word.is_taken

    @property
    def stop_problem(self) -> str:
        """Why our stop is not obeyed yet; empty: it is obeyed, or no problem is known."""
        word = self.tracker.word
        return word.problem if word.is_stop and self.owes_stop else ''

    def is_location_overdue(self, now: float) -> bool:
        """Returns whether no location has come for too long although the link was up."""
        heard = max(self.location.heard, self.links.up_since(p.RobotLink.OUTGOING))
        return now - heard > self._settings.location_timeout

    def check_giver(self) -> None:
        """Raises RouteFailed or TakenOver if others, or an emergency stop, ended the route."""
        if self.emergency or self.overruled is EpochCause.EMERGENCY_STOP:
            raise RouteFailed(EMERGENCY_STOP)
        if self._taken_over is not None:
            raise self._taken_over

    def check(self, now: float) -> None:
        """Raises RouteFailed or TakenOver if something has ended the running route."""
        self.check_giver()
        if self.tracker.failure is not None:
            raise self.tracker.failure
        lost = self.links.why_lost(now)
        if lost:
            raise RouteFailed(lost)
        if self.links.stands(p.RobotLink.OUTGOING, now) and self.is_location_overdue(now):
            raise RouteFailed(_no_location(self._settings.location_timeout))

    # --- events ----------------------------------------------------------------------------------

    def update(self, event: p.Event, now: float) -> bool:
        """Takes an event. Returns whether the event contained a new location of the robot."""
        before = self.location.heard
        self._handlers[type(event)](event, now)
        return self.location.heard != before

    def _on_seen(self, status: p.RobotSeen, now: float) -> None:
        self.seen = status
        if status.docking is not None and status.docking is not self.docking:
            self.docking, self.docking_changed = status.docking, now
        if status.place is not None and self.location.update(
                MapLocation(status.stamp, *status.place, status.heading), now):
            self.tracker.located(status.place, status.activity)

    def _on_ended(self, event: p.CommandEnded, now: float) -> None:
        self.tracker.ended(event, now)
        self._note_docked(now)

    def _note_docked(self, now: float) -> None:
        if self.tracker.has_docked and self.docking is not DockingState.DOCKED:
            self.docking, self.docking_changed = DockingState.DOCKED, now

    def _on_motion(self, event: p.MotionTold, now: float) -> None:
        self.stop_owed_by_controller, self.emergency = event.stop_owed, event.emergency_stop
        self._number = max(self._number, event.number)
        self.tracker.told(event.number, event.fate, now)
        self._note_docked(now)
        if event.epoch == self.epoch:
            return
        is_masters = self._is_of_master(event)
        self.drives_for_us, self._is_unexplained = event.obeys_us, event.is_unexplained
        known, self.epoch = self.epoch, event.epoch
        if is_masters:
            self.foreign_epoch, self.was_moved_by_master = event.foreign_epoch or event.epoch, True
        elif not event.is_unexplained:  # if it is unexplained, the next epoch shows what happened
            self._judge_foreign_epoch(known, event)

    def _is_of_master(self, event: p.MotionTold) -> bool:
        """Returns whether a command of the master itself began the epoch of the event. Then orders
        of the master that come later were given after this command.

        Returns False if the command ended a drive of ours that the controller had. Also returns
        False if there may have been epochs between the last known epoch and this one.
        """
        word = self.tracker.word
        had_our_drive = self.tracker.goal is not None and 0 < word.number <= event.number
        follows = event.previous_epoch == self.epoch != 0 and not self._is_unexplained
        return (follows and not had_our_drive and not event.is_unexplained
                and event.cause in _BY_A_GIVER
                and event.giver.rpartition('/')[2] == self._master() != '')

    def _judge_foreign_epoch(self, known: int, event: p.MotionTold) -> None:
        """Notes whether another giver, another client or the robot itself acted after the `known`
        epoch. Between the known epoch and the epoch of the event, there may have been epochs of
        which no message came.
        """
        before, self.foreign_epoch = self.foreign_epoch, event.foreign_epoch or event.epoch
        if not known or self.foreign_epoch == before:
            return
        cause, reason = event.cause, event.reason
        if self.foreign_epoch != event.epoch:  # that epoch began earlier; its cause is unknown
            cause, reason = EpochCause.OTHER_GIVER, 'an epoch that was not told here'
        if cause is not EpochCause.EMERGENCY_STOP:
            self._taken_over = TakenOver(f'Another giver came first: {reason}.')
        self.overruled = cause

    def _on_link(self, event: p.LinkReported, now: float) -> None:
        self.links.update(event, now)


def _no_location(seconds: float) -> Reason:
    return Reason(ReasonCode.NO_LOCATION,
                  f'the robot has not reported its location for {seconds:.0f} s')
