"""plc_sim: plays the PLCs of stations that hand loads over, for demonstrations and tests.

A mission made from a template may have steps that a program outside carries out. The mission waits
at such a step until the program answers. This node answers DONE after a delay. It does not answer
steps for which a person is asked.

Subscribes
    /mission_status (itrci_nav_msgs/MissionStatus)
Publishes
    /mission_command (itrci_nav_msgs/MissionCommand)
Parameters
    ~templates  string  pallet  the templates whose missions it answers, separated by commas
    ~seconds    float   3.0 s   duration of a hand-over
"""
from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Dict

import rospy

from fleet_requests import Sender
from itrci_nav_msgs.msg import MissionCommand, MissionStatus
from node_lifecycle import number, parameter, run
from node_lifecycle.periodic import Periodic

PERIOD = 0.2  # s between two checks for answers that are due
REPEAT = 2.0  # s after which an answer is repeated if no status shows it
ME = 'plc_sim'


@dataclass(frozen=True)
class HandOver:
    """A step that waits for an answer: its key, and when the answer is due (monotonic s)."""

    key: int
    due: float


class PlcSimulator:
    """The node; see the docstring of the module."""

    def __init__(self) -> None:
        self._templates = frozenset(
            name.strip() for name in parameter('~templates', 'pallet').split(','))
        self._seconds = number('~seconds', 3.0, 0.0, 600.0)
        self._lock = threading.Lock()
        self._waiting: Dict[int, HandOver] = {}
        """The hand-over of each mission that waits, by the id of the mission."""
        self._commands = Sender(MissionCommand)
        rospy.Subscriber('/mission_status', MissionStatus, self._on_status, queue_size=1000)
        Periodic('hand-overs', PERIOD, self._tick)

    def _on_status(self, message: MissionStatus) -> None:
        if message.template not in self._templates:
            return
        is_asked = bool(message.asks) and message.state != MissionStatus.NEEDS_PERSON
        with self._lock:
            before = self._waiting.get(message.request_id)
            if not is_asked:
                self._waiting.pop(message.request_id, None)
            elif before is None or before.key != message.asks:
                self._waiting[message.request_id] = HandOver(
                    message.asks, time.monotonic() + self._seconds)

    def _tick(self) -> None:
        now = time.monotonic()
        with self._lock:
            due = {id: one for id, one in self._waiting.items() if now >= one.due}
            if not due or not self._commands.is_heard:
                return
            for id, one in due.items():
                self._waiting[id] = HandOver(one.key, now + REPEAT)
        for id, one in due.items():
            rospy.loginfo('The load of mission %d is handed over.', id)
            self._commands.send(MissionCommand(
                request_id=id, command=MissionCommand.ANSWER, answer=MissionCommand.DONE,
                step_key=one.key, requested_by=ME))


def main() -> None:
    """Runs the node."""
    run('plc_sim', PlcSimulator)
