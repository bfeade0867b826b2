"""The session log: regular files only, and a disk that is full ends the log, not the session."""
from __future__ import annotations

import os

import pytest

from omron_arcl import SessionLog


def test_both_sides_are_written_and_what_is_not_printable_is_escaped(tmp_path):
    log = SessionLog(str(tmp_path / 'log'))
    trace = log.connection()
    trace('C', b'goto 12')
    trace('S', b'\x1b[2J caf\xe9')
    log.outgoing()('S', b'Stopped')
    log.close()
    said = [line.split(' ', 1)[1] for line in (tmp_path / 'log').read_text('ascii').splitlines()]
    assert said == ['C> goto 12', r'S> \x1b[2J caf\xe9', 'S0> Stopped']


def test_an_older_log_is_kept(tmp_path):
    (tmp_path / 'log').write_text('an older one')
    SessionLog(str(tmp_path / 'log')).close()
    assert (tmp_path / 'log.old').read_text() == 'an older one'


def test_a_folder_is_refused_and_keeps_its_name(tmp_path):
    folder = tmp_path / 'folder'
    folder.mkdir()
    with pytest.raises(OSError, match='no regular file'):
        SessionLog(str(folder))
    assert folder.is_dir()
    assert not (tmp_path / 'folder.old').exists()


def test_a_pipe_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / 'pipe')
    with pytest.raises(OSError, match='no regular file'):
        SessionLog(str(tmp_path / 'pipe'))


def test_a_full_disk_ends_the_log_with_a_reason_and_nothing_else(tmp_path):
    log = SessionLog(str(tmp_path / 'log'))
    full = open('/dev/full', 'w', encoding='ascii', buffering=1)  # noqa: SIM115  the log closes it
    log._file.close()
    log._file = full
    trace = log.connection()
    trace('S', b'Stopped')
    trace('S', b'Stopped')
    assert 'No space left on device' in log.failure
    assert str(tmp_path / 'log') in log.failure
    log.close()
