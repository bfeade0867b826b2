"""Programs that give commands to one robot; the test plays the robot's lines."""
from __future__ import annotations

from itertools import count
from typing import Any, List, Optional

from arcl_builders import Conversation

from omron_arcl import Execution, Giver, parse_command
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.drives import Drives
from omron_arcl.records import DriveMemory, MotionState

ROUTE, PERSON, OTHER = Giver('/bridge', 'a'), Giver('/rviz', 'b'), Giver('/adapter', 'c')
DOCKING = 'DockingState: Docking ForcedState: Unforced ChargeState: Not'
DOCKED = 'DockingState: Docked ForcedState: Unforced ChargeState: Bulk'
UNDOCKING = 'DockingState: Undocking ForcedState: Unforced ChargeState: Not'
UNDOCKED = 'DockingState: Undocked ForcedState: Unforced ChargeState: Not'


class Bench(Conversation):
    """Programs that give commands; the test plays the robot line by line."""

    def __init__(self, stored: Optional[DriveMemory] = None, is_linked: bool = True,
                 first_epoch: int = 101) -> None:
        super().__init__()
        self.kept: List[DriveMemory] = []
        numbers = count(first_epoch)
        self.records = Drives(stored, self.kept.append, lambda: next(numbers))
        self.dispatcher = Dispatcher(self.records)
        self.now = 100.0
        if is_linked:
            self.connect()

    @property
    def memory(self) -> DriveMemory:
        return self.records.motion.memory

    @property
    def epoch(self) -> int:
        return self.memory.epoch

    @property
    def state(self) -> MotionState:
        return self.records.motion.state

    def connect(self) -> None:
        self.dispatcher.on_connected(self.now)

    def lose(self) -> None:
        self.dispatcher.on_lost('the link broke')

    def drive(self, giver: Giver, text: str = 'goto 12', **options: Any) -> Execution:
        return self.give(text, giver=giver, **options)

    def stop(self, giver: Giver, **options: Any) -> Execution:
        return self.give('stop', giver=giver, **options)

    def stop_without_link(self, giver: Giver, known_epoch: int = 0) -> None:
        self.dispatcher.start_without_link(parse_command('stop'), giver, known_epoch)

    def status(self, text: str, seconds: float = 0.0) -> None:
        self.pass_time(seconds)
        self.robot(f'Status: {text} StateOfCharge: 80.0 Location: 0 0 0 Temperature: 30')
