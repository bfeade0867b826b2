"""External I/O: which clients receive an update, and the effect of removing a set."""
from __future__ import annotations

from sim_builders import Rig
from transcripts_equipment import ADD


def test_an_update_of_external_io_and_payload_reaches_every_client() -> None:
    rig = Rig()
    first, second = rig.client(), rig.client()
    first.send(ADD, 'edou example 1', 'ps 1 Books')
    assert second.lines() == [
        'extIOOutputUpdate: output example updated with 0x000000001 from 1',
        'PayloadUpdate: "robot" 1 "Books"']


def test_removing_external_io_restarts_the_robots_software() -> None:
    rig = Rig()
    first, second = rig.client(), rig.client()
    first.send(ADD, 'goto 12', 'edr example')
    assert first.lines()[-2:] == ['extIORemove: example removed', 'Shutting down server']
    assert first.session.closed and second.session.closed and not rig.server.online
    rig.clock.advance(rig.clock.now + 10.0)
    assert rig.server.online and rig.robot.base.still
    assert rig.client().ask('queryMotors', 'edd') == ['Motors enabled', 'EndExtIODump']
