"""All menus come from one table. RViz gets the table's rows with ids that refer back to the table.
"""
from __future__ import annotations

import pytest

from graph_editor.editor.actions import EDGE_MENU, SPEEDS, VERTEX_MENU, Action, numbered
from graph_editor.editor.changes import CHANGES


@pytest.mark.parametrize('menu', [VERTEX_MENU, EDGE_MENU])
def test_ids_lead_back_to_entries_and_parents_come_before_their_children(menu):
    rows, by_id = numbered(menu)
    assert [row[0] for row in rows] == list(range(1, len(rows) + 1))
    for id, parent, title in rows:
        assert by_id[id].title == title
        assert parent < id
        assert parent == 0 or by_id[id] in by_id[parent].entries


def test_a_submenu_offers_the_speeds():
    _, by_id = numbered(EDGE_MENU)
    assert [entry.argument for entry in by_id.values() if entry.action is Action.SPEED] == [
        *SPEEDS]


def test_every_action_can_be_chosen_somewhere():
    offered = {entry.action for menu in (VERTEX_MENU, EDGE_MENU)
               for entry in numbered(menu)[1].values()}
    assert set(Action) <= offered
    assert set(CHANGES) <= offered
