"""The history: missions from the fleet manager's journal, sums from the page's records."""
from __future__ import annotations

import csv
import io
from typing import Any, Dict, Iterable, List

from fleet_core.supervision.history import HISTORY_COLUMNS, HistoryLine, row_of
from fleet_page.core.records import HOUR, HistorySums
from node_program.inert_text import cell

HOTTEST = 200  # edges in the heat map, at most


def history_values(lines: Iterable[HistoryLine], sums: HistorySums, since: float,
                   now: float) -> Dict[str, Any]:
    """Returns the missions per hour, the sums per robot, and the waiting per edge, all since the
    time `since` (s since 1970).
    """
    hours = {hour: {'SUCCEEDED': 0, 'FAILED': 0, 'CANCELLED': 0, 'EXPIRED': 0}
             for hour in range(int(since // HOUR), int(now // HOUR) + 1)}
    waited: List[float] = []
    missions: Dict[str, int] = {}
    for line in lines:
        if line.ended is None or line.ended < since:
            continue
        ended = hours.get(int(line.ended // HOUR), {})
        if line.state.name in ended:
            ended[line.state.name] += 1
        if line.state.name == 'SUCCEEDED':
            missions[line.robot] = missions.get(line.robot, 0) + 1
        if line.started is not None:
            waited.append(line.started - line.accepted)
    robots = [{
        'robot': name, 'missions': missions.get(name, 0),
        'distance': round(own.distance, 1), 'waiting': round(own.waiting, 1),
        'utilisation': round(own.busy / own.watched, 3) if own.watched else 0.0}
        for name, own in sums.robots.items()]
    return {'hours': [{'begin': hour * HOUR, **counts} for hour, counts in hours.items()],
            'robots': robots, 'edges': sums.edges[:HOTTEST],
            'mean_waited': round(sum(waited) / len(waited), 1) if waited else None}


def history_csv(lines: Iterable[HistoryLine], since: float) -> str:
    """Returns the missions that were accepted since a time (s since 1970) as CSV. The columns are
    those of `mission history --csv`.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(HISTORY_COLUMNS)
    for line in lines:
        if line.accepted >= since:
            writer.writerow(map(cell, row_of(line, '{:.3f}'.format)))
    return text.getvalue()
