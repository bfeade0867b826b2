"""What is to be done about an event, once all that it relies on is on the disk."""
from __future__ import annotations

from typing import Dict, List, Mapping, Set

from graph_fleet_manager.supervision.actions import Action, Note, TellStatus
from graph_fleet_manager.supervision.journal import Journal, RobotMemory
from graph_fleet_manager.supervision.missions import MissionBook
from graph_fleet_manager.supervision.robots import ManagedRobot


class Outbox:
    """Collects the actions of one event; `take` stores first what changed, and then gives them."""

    def __init__(self, journal: Journal, book: MissionBook,
                 robots: Mapping[str, ManagedRobot]) -> None:
        self.journal = journal
        self._book = book
        self._robots = robots
        self._stale: Set[str] = set()
        self._actions: List[Action] = []
        self._wrong: Dict[str, str] = {}

    def put(self, action: Action) -> None:
        """This is to be done."""
        self._actions.append(action)

    def note(self, text: str, is_warning: bool = False) -> None:
        """The people who watch are to be told."""
        self.put(Note(text, is_warning))

    def note_state(self, subject: str, wrong: str, mended: str) -> None:
        """What is wrong with something, if anything, is told when that changes, not while it lasts.
        """
        before = self._wrong.get(subject, '')
        self._wrong[subject] = wrong
        if wrong != before:
            self.note(wrong or mended, bool(wrong))

    def robot_changed(self, name: str) -> None:
        """What is stored of a robot is not true any more."""
        self._stale.add(name)

    def take(self) -> List[Action]:
        """Everything to be done, in order; all that it relies on is on the disk."""
        for mission in self._book.take_changes():
            self.journal.write_mission(mission)
            self.put(TellStatus(mission.status))
        for name in sorted(self._stale):
            robot = self._robots[name]
            self.journal.write_robot(name, RobotMemory(
                robot.client.memory, robot.outage, robot.why, robot.is_halted, robot.comes_to_rest,
                robot.dock))
        self._stale.clear()
        self.journal.commit()
        actions, self._actions = self._actions, []
        return actions
