"""The ARCL password comes from a regular file or the environment, and is never shown."""
from __future__ import annotations

import os

import pytest

from node_lifecycle import ConfigurationError
from omron_ld90.nodes import controller_password
from omron_ld90.nodes.controller_password import PASSWORD_VARIABLE, read_password


@pytest.fixture(autouse=True)
def warnings(monkeypatch) -> list:
    said = []
    monkeypatch.setattr(controller_password.rospy, 'logwarn', lambda *words: said.append(words))
    monkeypatch.delenv(PASSWORD_VARIABLE, raising=False)
    return said


@pytest.mark.parametrize('content', [b'secret', b'secret\n', b' secret\r\n'])
def test_the_password_is_what_the_file_holds(tmp_path, content):
    path = tmp_path / 'password'
    path.write_bytes(content)
    assert read_password(str(path)) == b'secret'


def test_without_a_file_the_environment_has_the_password_and_it_is_said_where_that_leaks(
        monkeypatch, warnings):
    monkeypatch.setenv(PASSWORD_VARIABLE, 'secret')
    assert read_password('') == b'secret'
    assert 'roslaunch' in warnings[0][0]
    assert 'secret' not in str(warnings)


def test_no_program_inherits_the_password_from_here(monkeypatch, tmp_path):
    monkeypatch.setenv(PASSWORD_VARIABLE, 'secret')
    path = tmp_path / 'password'
    path.write_text('other')
    assert read_password(str(path)) == b'other'
    assert PASSWORD_VARIABLE not in os.environ


def test_a_pipe_is_no_password_file_and_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / 'pipe')
    with pytest.raises(ConfigurationError, match='pipe: it is no regular file'):
        read_password(str(tmp_path / 'pipe'))


@pytest.mark.parametrize('path', ['/dev/zero', '/tmp'])
def test_neither_is_a_device_or_a_folder(path):
    with pytest.raises(ConfigurationError, match='no regular file|Is a directory'):
        read_password(path)


@pytest.mark.parametrize('content', [b'', b'\n', b'sec\nret', b'sec\x00ret', b's\xe9cret'])
def test_an_unusable_password_is_refused_and_not_shown(tmp_path, content):
    path = tmp_path / 'file'
    path.write_bytes(content)
    with pytest.raises(ConfigurationError) as refused:
        read_password(str(path))
    assert str(path) in str(refused.value)
    assert 'ret' not in str(refused.value)


def test_a_missing_password_file_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match='No such file'):
        read_password(str(tmp_path / 'none'))


def test_without_any_password_both_ways_are_named():
    with pytest.raises(ConfigurationError, match=f'~password_file.*{PASSWORD_VARIABLE}'):
        read_password('')


@pytest.mark.parametrize('mode, is_simulated, is_told', [
    (0o600, False, False), (0o640, False, True), (0o604, False, True), (0o644, True, False)])
def test_a_password_that_others_can_read_is_told_for_a_real_robot(
        tmp_path, warnings, mode, is_simulated, is_told):
    path = tmp_path / 'password'
    path.write_text('secret')
    path.chmod(mode)
    read_password(str(path), is_simulated)
    assert [words[1:] for words in warnings] == (
        [('ARCL password file', str(path))] if is_told else [])
