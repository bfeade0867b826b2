"""A file that is not regular, or is too large, is refused at once. The error does not quote it."""
from __future__ import annotations

import os
import threading
import tracemalloc

import pytest
from map_builders import CELL

from omron_map import MapDocument, MapError, MapWatcher, wait_for_map
from omron_map.regular_file import MAX_BYTES

SECRET = 'hunter2-of-the-robot'


def refusal(path: str) -> str:
    """Returns why `path` is not loaded. Fails if loading takes longer than 10 s."""
    errors = []

    def load() -> None:
        with pytest.raises(MapError) as caught:
            MapDocument.load(path)
        errors.append(str(caught.value))

    thread = threading.Thread(target=load, daemon=True)
    thread.start()
    thread.join(10.0)
    assert not thread.is_alive(), f'{path!r} is still being read'
    error, = errors
    return error


def test_a_pipe_that_nobody_writes_to_is_not_waited_for(tmp_path):
    path = str(tmp_path / 'pipe.map')
    os.mkfifo(path)
    assert refusal(path) == f'{path}: it is a pipe; expected a regular file.'


@pytest.mark.parametrize('path, kind', [
    ('/dev/zero', 'a device'), ('/dev/null', 'a device'), ('/', 'a folder')])
def test_what_is_no_file_is_refused_by_its_kind(path, kind):
    assert refusal(path) == f'{path}: it is {kind}; expected a regular file.'


def test_a_link_counts_as_what_it_leads_to(tmp_path):
    real, link = tmp_path / 'real.map', tmp_path / 'link.map'
    real.write_bytes(CELL)
    link.symlink_to(real)
    assert MapDocument.load(str(link)).to_bytes() == CELL
    link.unlink()
    link.symlink_to('/dev/zero')
    assert 'a device' in refusal(str(link))


def test_a_file_that_is_not_there_is_named(tmp_path):
    path = str(tmp_path / 'none.map')
    assert refusal(path) == f'{path}: it cannot be read (No such file or directory).'


@pytest.mark.parametrize('path', ['/tmp/a\0b.map', '/tmp/\ud800.map'])
def test_a_path_that_no_file_can_have_is_refused_in_printable_words(path):
    assert refusal(path).isprintable()
    assert 'no file can have this name' in refusal(path)
    assert not MapWatcher(path).changed()
    with pytest.raises(MapError, match='no file can have this name'):
        wait_for_map(path, timeout=0.0)


def test_a_path_cannot_speak_to_the_terminal():
    assert refusal('/nowhere/\x1b[2J.map').isprintable()
    assert len(refusal('/nowhere/' + 5000 * 'x')) < 500


@pytest.mark.parametrize('data', [
    SECRET.encode(), f'{SECRET}\nDATA\n'.encode(), f'\n\n  {SECRET}\n'.encode(),
    f'root:{SECRET}:0:0'.encode(), f'2D-Map {SECRET}\nDATA\n'.encode()])
def test_nothing_of_a_file_that_is_no_map_is_told(tmp_path, data):
    path = tmp_path / 'shadow'
    path.write_bytes(data)
    assert SECRET[:4] not in refusal(str(path))


def test_a_file_that_is_too_large_is_not_read(tmp_path):
    path = tmp_path / 'large.map'
    path.write_bytes(CELL)
    os.truncate(path, MAX_BYTES + 1)
    assert 'at most 32 MiB' in refusal(str(path))


def test_only_the_beginning_is_read_of_what_is_no_map(tmp_path):
    path = tmp_path / 'zeros.map'
    path.touch()
    os.truncate(path, MAX_BYTES)
    tracemalloc.start()
    refusal(str(path))
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 2_000_000, f'{most} bytes of memory were used'
