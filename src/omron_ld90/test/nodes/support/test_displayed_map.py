"""Only map_visualisation of the same namespace decides which map is displayed."""
from __future__ import annotations

from pathlib import Path

import pytest
import rospy
from std_msgs.msg import String

from omron_ld90.nodes.support.displayed_map import DisplayedMap

LAB = str(Path(__file__).resolve().parents[5] / 'maps' / 'lab.map')
OURS = rospy.resolve_name('map_visualisation')


@pytest.fixture
def told() -> list:
    """Returns a list that collects the callback's arguments: (document, path)."""
    return []


@pytest.fixture
def displayed(told) -> DisplayedMap:
    return DisplayedMap(lambda document, path: told.append((document, path)), 'Nothing is drawn')


def message(path: str, sender: str = OURS) -> String:
    made = String(path)
    made._connection_header = {'callerid': sender}
    return made


def test_the_displayed_map_is_loaded(displayed, told):
    displayed.on_message(message(LAB))
    (document, path), = told
    assert path == LAB
    assert len(document.docks) == 1


@pytest.mark.parametrize('sender', ['/stranger', '/other/map_visualisation', 'map_visualisation'])
def test_nobody_else_is_believed(displayed, told, sender, monkeypatch):
    said = []
    monkeypatch.setattr(rospy, 'logwarn_throttle',
                        lambda period, text, *values: said.append(text % values))
    displayed.on_message(message(LAB, sender))
    assert told == []
    assert said == [f'A map_file from {sender} is ignored: only {OURS} says which map is '
                    'displayed.']


def test_a_map_that_cannot_be_read_is_no_map_and_that_is_said(displayed, told, monkeypatch):
    said = []
    monkeypatch.setattr(rospy, 'logerr', lambda text, *values: said.append(text % values))
    displayed.on_message(message('/dev/zero'))
    assert told == [(None, '/dev/zero')]
    assert said == ['Nothing is drawn: /dev/zero: it is a device; expected a regular file.']


def test_an_empty_path_means_that_no_map_is_displayed(displayed, told):
    displayed.on_message(message(''))
    assert told == [(None, '')]
