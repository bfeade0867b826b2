"""The order in which RViz receives updates and keep-alives of handles."""
from __future__ import annotations

import threading

import pytest
from interactive_markers.interactive_marker_server import InteractiveMarkerServer

from node_lifecycle import marker_server
from node_lifecycle.marker_server import OrderedMarkerServer


@pytest.fixture
def sent(monkeypatch) -> list:
    """Returns the messages that the library's server would publish, in order."""
    messages = []
    for name in ('publishInit', 'keepAlive', 'applyChanges'):
        monkeypatch.setattr(InteractiveMarkerServer, name,
                            lambda self, *_, name=name: messages.append(name))
    monkeypatch.setattr(InteractiveMarkerServer, '__init__',
                        lambda self, _, q_size: self.publishInit())
    monkeypatch.setattr(InteractiveMarkerServer, '__del__', lambda self: None)
    monkeypatch.setattr(marker_server, 'Periodic', lambda *_: None)
    return messages


def test_a_keep_alive_waits_for_the_update_that_is_under_way(sent, monkeypatch):
    begun, go_on = threading.Event(), threading.Event()

    def slow(_: object) -> None:
        begun.set()
        assert go_on.wait(10)
        sent.append('applyChanges')
    monkeypatch.setattr(InteractiveMarkerServer, 'applyChanges', slow)
    server = OrderedMarkerServer('handles')
    threads = [threading.Thread(target=server.applyChanges),
               threading.Thread(target=server.keep_alive)]
    threads[0].start()
    assert begun.wait(10)
    threads[1].start()
    threads[1].join(0.1)
    assert sent == []
    go_on.set()
    for thread in threads:
        thread.join(10)
    assert sent == ['applyChanges', 'publishInit', 'keepAlive']


def test_the_whole_state_goes_out_once_after_a_change_and_not_with_each(sent):
    server = OrderedMarkerServer('handles')
    for _ in range(3):
        server.publishInit()
    assert sent == []
    server.keep_alive()
    server.keep_alive()
    assert sent == ['publishInit', 'keepAlive', 'keepAlive']
