"""Transports can be closed at any time, and an error in a callback ends no thread."""
from __future__ import annotations

import os

import pytest
from arcl_builders import PASSWORD, Noted, ScriptedRobot, free_port, wait_for

from omron_arcl import Backoff, Client, LinkPhase, Listener


@pytest.mark.parametrize('make', [
    lambda: Client('127.0.0.1', free_port(), PASSWORD),
    lambda: Listener('127.0.0.1', 0, '127.0.0.1')])
def test_closing_before_the_start_frees_all_and_there_is_no_start_after_it(make):
    before = os.listdir('/proc/self/fd')
    transport = make()
    transport.close()
    transport.close()
    transport.start()
    assert not transport._thread.is_alive()
    assert len(os.listdir('/proc/self/fd')) == len(before)


def test_starting_twice_starts_once():
    with Listener('127.0.0.1', 0, '127.0.0.1') as listener:
        listener.start()
        assert listener._thread.is_alive()


def test_a_robot_that_can_be_no_host_is_a_reason_and_no_end_of_the_thread():
    links = Noted()
    with Client('10.0..5', 7171, PASSWORD, backoff=Backoff(0.01, 0.01), on_link=links) as client:
        links.wait(lambda link: 'neither an address nor a name' in link.reason, 'the reason')
        told = len(links.all)
        wait_for(lambda: len(links.all) > told + 2, 'another try')
        assert client._thread.is_alive()


def test_a_mistake_of_ours_in_a_connection_is_told_and_the_next_one_is_tried(monkeypatch, caplog):
    links = Noted()

    def fail(*_: object, **__: object) -> None:
        raise RuntimeError('a mistake')
    with ScriptedRobot() as robot:
        monkeypatch.setattr('omron_arcl.arcl_link.Session', fail)
        with Client('127.0.0.1', robot.port, PASSWORD, backoff=Backoff(0.01, 0.01),
                    on_link=links) as client:
            links.wait(lambda link: 'a mistake' in link.reason, 'the reason')
            monkeypatch.undo()
            assert client.wait_connected(5.0).phase is LinkPhase.CONNECTED
