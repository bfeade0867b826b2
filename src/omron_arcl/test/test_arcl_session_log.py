"""The session log, in the format of docs/reference/session_log.md, which the simulator reads."""
from __future__ import annotations

import os
from pathlib import Path

import pytest
import yaml

from omron_arcl import SessionLog, session_log
from omron_arcl.secret import redact_passwords

ROOT = Path(__file__).resolve().parents[3]
VECTORS = yaml.safe_load((ROOT / 'test' / 'vectors' / 'session_log.yaml').read_text())


@pytest.mark.parametrize('row', VECTORS, ids=lambda row: row['line'])
def test_a_line_is_written_as_documented(row, tmp_path, monkeypatch):
    monkeypatch.setattr(session_log.time, 'time', lambda: row['time'])
    log = SessionLog(str(tmp_path / 'session.log'))
    traces = [log.outgoing(), *(log.connection() for _ in range(3))]
    traces[row['connection']](row['side'], bytes(row['bytes']))
    log.close()
    assert (tmp_path / 'session.log').read_text(encoding='ascii') == row['line'] + '\n'


def test_an_older_log_is_kept(tmp_path):
    (tmp_path / 'log').write_text('an older one')
    SessionLog(str(tmp_path / 'log')).close()
    assert (tmp_path / 'log.old').read_text() == 'an older one'


def written_log(path: Path, *lines: bytes) -> SessionLog:
    log = SessionLog(str(path))
    trace = log.connection()
    for line in lines:
        trace('S', line)
    log.close()
    return log


@pytest.mark.parametrize('kept', ['my notes\n', '1.5 S> no line of a log\n', '\xff', '\n'])
def test_a_file_of_the_user_beside_the_log_is_never_replaced(tmp_path, kept):
    (tmp_path / 'log.old').write_text(kept, encoding='latin-1')
    written_log(tmp_path / 'log', b'first')
    before = (tmp_path / 'log').read_text()
    with pytest.raises(OSError, match='log.old, because that file is no session log'):
        SessionLog(str(tmp_path / 'log'))
    assert (tmp_path / 'log.old').read_text(encoding='latin-1') == kept
    assert (tmp_path / 'log').read_text() == before


def test_a_file_of_the_user_in_place_of_the_log_is_kept_however_often_it_is_begun(tmp_path):
    (tmp_path / 'log').write_text('my notes')
    written_log(tmp_path / 'log', b'first')
    with pytest.raises(OSError, match='no session log: rename it'):
        SessionLog(str(tmp_path / 'log'))
    assert (tmp_path / 'log.old').read_text() == 'my notes'


def test_a_log_that_grows_replaces_no_file_of_the_user_and_ends_with_a_reason(tmp_path):
    log = SessionLog(str(tmp_path / 'log'), size=100)
    (tmp_path / 'log.old').write_text('my notes')
    trace = log.connection()
    for _ in range(10):
        trace('S', b'Stopped')
    assert 'no session log' in log.failure
    assert (tmp_path / 'log.old').read_text() == 'my notes'
    log.close()


@pytest.mark.parametrize('lines', [(), (b'one',), (b'\xff\n', b'two')])
def test_an_older_log_of_this_program_is_replaced(tmp_path, lines):
    written_log(tmp_path / 'log', *lines)
    written_log(tmp_path / 'log', b'second')
    written_log(tmp_path / 'log', b'third')
    assert (tmp_path / 'log.old').read_text().endswith('second\n')


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


def test_the_log_never_takes_more_than_twice_its_size(tmp_path):
    log = SessionLog(str(tmp_path / 'log'), size=1000)
    trace = log.connection()
    for number in range(200):
        trace('S', f'line {number}'.encode())
        assert all(file.stat().st_size <= 1000 for file in tmp_path.iterdir())
    log.close()
    assert sorted(file.name for file in tmp_path.iterdir()) == ['log', 'log.old']
    kept = (tmp_path / 'log.old').read_text() + (tmp_path / 'log').read_text()
    numbers = [int(line.rsplit(' ', 1)[1]) for line in kept.splitlines()]
    assert numbers == list(range(numbers[0], 200)), 'the last lines must all be there'


def test_where_no_other_file_can_be_begun_the_log_ends_with_a_reason(tmp_path, monkeypatch):
    log = SessionLog(str(tmp_path / 'log'), size=100)
    trace = log.connection()

    def full(*_: object) -> None:
        raise OSError(28, 'No space left on device')
    monkeypatch.setattr(session_log.os, 'replace', full)
    for _ in range(10):
        trace('S', b'Stopped')
    assert 'No space left on device' in log.failure


# -- passwords of the robot's configuration are redacted, and nothing else is ----------------------

@pytest.mark.parametrize(('line', 'redacted'), [
    (b'GetConfigSectionValue: Password adept', b'GetConfigSectionValue: Password ********'),
    (b'configAdd Password two words', b'configAdd Password ********'),
    (b"Added 'Password adept' to the config", b"Added 'Password ********' to the config"),
    (b'configAdd PasswordUser adept', b'configAdd PasswordUser ********'),
    (b'GetConfigSectionValue: PortNumber 7171', b'GetConfigSectionValue: PortNumber 7171'),
    (b'say the password is adept', b'say the password is adept'),
    (b'Going to password', b'Going to password'),
])
def test_the_value_of_a_password_is_redacted(line, redacted):
    assert redact_passwords(line) == redacted
