"""A graph file whose name comes from another program is read safely.

Only regular files are read, and error messages quote nothing from a file.
"""
from __future__ import annotations

import os
import threading

import pytest

from trajectory_graph import GraphError, load_graph

SECRET = 'hunter2'


def refusal(path: str) -> str:
    """Returns why `path` is not loaded; fails if the answer takes longer than 10 s."""
    errors = []

    def load() -> None:
        with pytest.raises(GraphError) as caught:
            load_graph(path)
        errors.append(str(caught.value))

    thread = threading.Thread(target=load, daemon=True)
    thread.start()
    thread.join(10.0)
    assert not thread.is_alive(), f'{path!r} is still being read'
    error, = errors
    return error


def test_a_pipe_that_nobody_writes_to_is_not_waited_for(tmp_path):
    path = str(tmp_path / 'graph.yaml')
    os.mkfifo(path)
    assert refusal(path) == f'{path}: this is not a regular file.'


@pytest.mark.parametrize('path', ['/dev/zero', '/dev/null', '/'])
def test_a_device_and_a_folder_are_refused(path):
    assert 'not a regular file' in refusal(path)


@pytest.mark.parametrize('path', ['a\0b.yaml', '\ud800.yaml'])
def test_a_path_that_no_file_can_have_is_refused_in_printable_words(path):
    error = refusal(path)
    assert 'no file can have this name' in error
    assert error.isprintable()


@pytest.mark.parametrize('text', [
    SECRET, f'*{SECRET}', f'!{SECRET}! x', f'&{SECRET} a: &{SECRET} b', f'password: {SECRET}',
    f'{SECRET}: 1\n{SECRET}: 2', f'- {SECRET}', f'"\\{SECRET}"', f'%{SECRET} 1', f'a: *{SECRET}'])
def test_nothing_of_a_file_that_is_no_graph_is_told(tmp_path, text):
    path = tmp_path / 'shadow'
    path.write_text(text)
    assert SECRET[:4] not in refusal(str(path))
