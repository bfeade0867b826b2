"""The actions of the editor's menus: one table for RViz, the window and the tests."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Dict, List, Optional, Tuple


class Action(Enum):
    """The actions of the menus; the value is the text of the menu entry."""

    CONNECT = 'Connect from here: then click a vertex or the floor'
    CONNECT_HERE = 'Connect to here'
    HEAD_ALONG = 'Face along the first edge'
    TURN_ROUND = 'Turn round'
    QUARTER_LEFT = 'Turn 90 degrees left'
    DOCK = 'Dock: yes or no'
    PARKING = 'Parking: yes or no'
    DELETE_VERTEX = 'Delete this vertex and its edges'
    LINE = 'Straight line'
    SPLINE = 'Spline'
    CUT = 'Cut in the middle'
    TURN_EDGE = 'Turn round: origin and destination'
    TWO_WAY = 'Two-way'
    ONE_WAY = 'One-way, from origin to destination'
    DELETE_EDGE = 'Delete this edge'
    UNDO = 'Undo'
    REDO = 'Redo'
    SAVE = 'Save'
    TAKE_OVER = 'Save and take over: robots drive on it'
    LOAD = 'Load again from the file'
    SPEED = 'Speed'
    GRID = 'Snap to a grid'


SPEEDS = (0.2, 0.3, 0.5, 0.8, 1.0)  # m/s
GRIDS = (0.0, 0.05, 0.1, 0.25, 0.5)  # m; 0: no grid


@dataclass(frozen=True)
class MenuItem:
    """An entry of a menu: an action with its argument, or a submenu with `entries`."""

    title: str
    action: Optional[Action] = None
    argument: float = 0.0
    entries: Tuple[MenuItem, ...] = ()


def _entries(*actions: Action) -> Tuple[MenuItem, ...]:
    return tuple(MenuItem(action.value, action) for action in actions)


_SPEEDS = MenuItem(Action.SPEED.value, entries=tuple(
    MenuItem(f'{speed:g} m/s', Action.SPEED, speed) for speed in SPEEDS))
_GRIDS = MenuItem(Action.GRID.value, entries=tuple(
    MenuItem(f'{grid:g} m' if grid else 'Off', Action.GRID, grid) for grid in GRIDS))
_ALWAYS = (*_entries(Action.UNDO, Action.REDO), _GRIDS,
           *_entries(Action.SAVE, Action.TAKE_OVER, Action.LOAD))

VERTEX_MENU: Tuple[MenuItem, ...] = (
    *_entries(Action.CONNECT, Action.CONNECT_HERE, Action.HEAD_ALONG, Action.QUARTER_LEFT,
              Action.TURN_ROUND, Action.DOCK, Action.PARKING, Action.DELETE_VERTEX), *_ALWAYS)
EDGE_MENU: Tuple[MenuItem, ...] = (
    *_entries(Action.LINE, Action.SPLINE, Action.CUT, Action.TURN_EDGE, Action.TWO_WAY,
              Action.ONE_WAY), _SPEEDS, *_entries(Action.DELETE_EDGE), *_ALWAYS)


def numbered(menu: Tuple[MenuItem, ...]) -> Tuple[List[Tuple[int, int, str]], Dict[int, MenuItem]]:
    """Returns the rows of a menu for RViz (id, id of the parent or 0, title), and the menu's
    entries by their ids.
    """
    rows: List[Tuple[int, int, str]] = []
    by_id: Dict[int, MenuItem] = {}

    def add(entries: Tuple[MenuItem, ...], parent: int) -> None:
        for entry in entries:
            id = len(rows) + 1
            rows.append((id, parent, entry.title))
            by_id[id] = entry
            add(entry.entries, id)
    add(menu, 0)
    return rows, by_id
