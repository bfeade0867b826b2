"""The progress of a mission as a line of text: destination, position, time left, reason to wait."""
from __future__ import annotations

import math
import sys
import time
from typing import Any, List, Optional, TextIO, Tuple

from itrci_nav_msgs.msg import FleetRobot, FleetState, MissionStatus
from node_program.inert_text import return_to_line_begin
from trajectory_graph import Graph
from trajectory_graph.drawn_names import place_name

EVERY = 5.0  # s between two lines without a terminal, if nothing changes


def line_of(status: MissionStatus, destinations: List[int], state: Optional[FleetState],
            graph: Graph) -> str:
    """Returns one line about the progress of a mission.

    destinations -- those of the request or, if it has none, of `status`; empty: neither has any
    """
    if status.state in (MissionStatus.PENDING, MissionStatus.BLOCKED, MissionStatus.PLANNED):
        return f'waiting: {status.reason}' if status.reason else 'accepted'
    if status.state == MissionStatus.PAUSED:
        return f'{status.robot}: paused'
    if status.state in (MissionStatus.CANCELLING, MissionStatus.NEEDS_PERSON):
        return f'{status.robot}: {status.reason}'
    robot = _robot(state, status)
    reached, count = status.destinations_reached, len(destinations)
    if not count:
        words = [f'{status.robot}: {reached} stops made']
    elif reached >= count:
        return f'{status.robot}: {count} of {count} reached'
    else:
        words = [f'{status.robot} to {destinations[reached]} ({reached + 1} of {count})']
    if robot is not None:
        if robot.pose.edge_id:
            words.append(place_name(graph, robot.pose.edge_id, robot.pose.percentage / 100.0))
        if math.isfinite(robot.to_destination):
            words.append(f'{robot.to_destination:.0f} s to go')
        if robot.waits_for:
            words.append(f'waits for {robot.waits_for}' if status.reason == '' else status.reason)
    return ', '.join(words)


def _robot(state: Optional[FleetState], status: MissionStatus) -> Optional[FleetRobot]:
    robots = [] if state is None else state.robots
    return next((robot for robot in robots if robot.name == status.robot
                 and robot.request_id == status.request_id), None)


class ProgressLine:
    """Shows progress lines. On a terminal, each line replaces the previous line. Without a
    terminal, fewer lines are printed.
    """

    def __init__(self, stream: Optional[TextIO] = None) -> None:
        self._stream = sys.stdout if stream is None else stream
        self._begun = time.monotonic()
        self._shown: Tuple[Any, float] = (None, 0.0)
        self._width = 0

    def show(self, text: str, about: object) -> None:
        """Shows a line. Without a terminal, a line is printed only if `about` has changed or EVERY
        has passed.
        """
        seconds = int(time.monotonic() - self._begun)
        line = f'{seconds // 60}:{seconds % 60:02d}  {text}'
        if self._stream.isatty():
            return_to_line_begin(self._stream)
            print(line.ljust(self._width), end='', file=self._stream, flush=True)
            self._width = len(line)
        elif self._shown[0] != about or seconds - self._shown[1] >= EVERY:
            self._shown = (about, seconds)
            print(line, file=self._stream, flush=True)

    def end(self) -> None:
        """Ends the line of a terminal, if one was shown."""
        if self._stream.isatty() and self._width:
            print(file=self._stream)
