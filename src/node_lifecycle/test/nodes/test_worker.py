"""If a thread fails without which the node cannot work, the process ends."""
from __future__ import annotations

from typing import Callable, List

import pytest
import rospy

from node_lifecycle.worker import start_worker


@pytest.fixture(autouse=True)
def fatal(monkeypatch) -> List[str]:
    said: List[str] = []
    monkeypatch.setattr(rospy, 'logfatal', lambda text, *arguments: said.append(text % arguments))
    monkeypatch.setattr(rospy, 'is_shutdown', lambda: False)
    return said


def ends_with(work: Callable[[], None]) -> List[int]:
    statuses: List[int] = []
    start_worker('follower', work, statuses.append).join(5.0)
    return statuses


def test_a_defect_ends_the_process_and_is_told_with_its_place(fatal):
    def work() -> None:
        raise IndexError('no such edge')
    assert ends_with(work) == [1]
    assert 'in its thread "follower"' in fatal[0]
    assert 'IndexError: no such edge' in fatal[0]
    assert 'test_worker.py' in fatal[0]


def test_work_that_is_done_ends_nothing_else(fatal):
    assert ends_with(lambda: None) == []
    assert fatal == []


def test_a_topic_that_closes_as_the_node_ends_is_no_defect(fatal):
    def work() -> None:
        raise rospy.ROSException('publish() to a closed topic')
    assert ends_with(work) == []
    assert fatal == []
