"""systemd is notified that a unit works as long as each of its nodes had a good report recently."""
from __future__ import annotations

from fleet_services.health import PATIENCE, Health


def test_a_unit_is_ready_once_each_node_has_been_well():
    health = Health(['/a', '/b'])
    health.hear('/a', True, 0.0)
    health.hear('/b', False, 0.0)
    assert not health.is_ready
    health.hear('/b', True, 1.0)
    assert health.is_ready


def test_nodes_of_other_units_do_not_count():
    health = Health(['/a'])
    health.hear('/other', True, 0.0)
    assert not health.is_ready
    health.hear('/a', True, 0.0)
    assert health.hung(PATIENCE) == frozenset()


def test_a_node_that_stands_still_or_is_silent_is_hung_after_a_while():
    health = Health(['/a', '/b', '/c'])
    for node in health.nodes:
        health.hear(node, True, 0.0)
    health.hear('/a', True, PATIENCE)
    health.hear('/b', False, PATIENCE)
    assert health.hung(PATIENCE) == frozenset()
    assert health.hung(PATIENCE + 0.1) == {'/b', '/c'}
    health.hear('/b', True, PATIENCE + 0.2)
    assert health.hung(PATIENCE + 0.2) == {'/c'}
