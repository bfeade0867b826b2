"""The waiting time before the next attempt to connect."""
from __future__ import annotations

from omron_arcl import Backoff
from omron_arcl.errors import ConnectionFailed, WrongPassword


def test_a_wrong_password_waits_longer_than_a_lost_connection():
    backoff = Backoff(jitter=0.0)
    assert backoff.after(WrongPassword('x')) == 30.0
    assert [backoff.after(ConnectionFailed('x')) for _ in range(7)] \
        == [0.5, 1.0, 2.0, 4.0, 8.0, 10.0, 10.0]
    backoff.reset()
    assert backoff.after(ConnectionFailed('x')) == 0.5


def test_backoff_is_spread_within_its_share_and_never_beyond_its_cap():
    waits = [Backoff(first=5.0, cap=5.5, jitter=0.2).after(ConnectionFailed('x'))
             for _ in range(200)]
    assert all(4.0 <= wait <= 5.5 for wait in waits)
    assert len(set(waits)) > 100
