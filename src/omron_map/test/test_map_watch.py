"""Changes of a map file are noticed once it has settled; a map being made is waited for."""
from __future__ import annotations

import os
import threading

import pytest

from omron_map import MapError, MapWatcher, wait_for_map


@pytest.fixture
def path(tmp_path) -> str:
    file = tmp_path / 'a.map'
    file.write_bytes(b'one')
    return str(file)


def write(path: str, data: bytes) -> None:
    with open(path, 'wb') as file:
        file.write(data)


def set_age(path: str, seconds: float) -> None:
    """Makes `path` seem written `seconds` after the epoch."""
    os.utime(path, (seconds, seconds))


class TestMapWatcher:
    def test_an_unchanged_file_is_no_news(self, path):
        watcher = MapWatcher(path)
        assert not any(watcher.changed() for _ in range(3))

    def test_a_change_is_told_once_it_has_settled_and_only_once(self, path):
        watcher = MapWatcher(path)
        write(path, b'longer')
        assert [watcher.changed() for _ in range(4)] == [False, True, False, False]

    def test_a_file_that_still_grows_is_waited_for(self, path):
        watcher = MapWatcher(path)
        told = []
        for size in (5, 6, 7):
            write(path, b'x' * size)
            told.append(watcher.changed())
        assert told == [False, False, False] and watcher.changed()

    def test_a_file_replaced_by_another_of_the_same_size_and_time_is_a_change(self, path):
        set_age(path, 1000)
        watcher = MapWatcher(path)
        other = path + '.new'
        write(other, b'two')
        set_age(other, 1000)
        os.replace(other, path)
        assert [watcher.changed(), watcher.changed()] == [False, True]

    def test_a_file_that_goes_is_no_change_but_one_that_comes_is(self, path):
        watcher = MapWatcher(path)
        os.unlink(path)
        assert not any(watcher.changed() for _ in range(3))
        write(path, b'back again')
        assert [watcher.changed(), watcher.changed()] == [False, True]


class TestWaitForMap:
    def test_a_map_newer_than_what_it_is_made_from_is_there(self, path):
        set_age(path, 2000)
        base = path + '.base'
        write(base, b'')
        set_age(base, 2000)
        wait_for_map(path, made_from=[base, ''], timeout=0.0, say=pytest.fail)

    @pytest.mark.parametrize('stale', [True, False])
    def test_a_map_that_comes_late_is_waited_for_and_that_is_said(self, path, stale):
        base = path + '.base'
        write(base, b'')
        set_age(base, 2000)
        if stale:
            set_age(path, 1000)
        else:
            os.unlink(path)
        said = []

        def say(text):
            said.append(text)
            threading.Thread(target=write, args=(path, b'made')).start()
        wait_for_map(path, made_from=[base], timeout=30.0, say=say)
        assert len(said) == 1 and path in said[0]

    def test_a_map_that_does_not_come_is_told_with_the_reason(self, path):
        base = path + '.base'
        write(base, b'')
        set_age(path, 1000)
        with pytest.raises(MapError, match=r'older than what it is made from: .*a\.map\.base'):
            wait_for_map(path, made_from=[base], timeout=0.0, say=lambda text: None)
        with pytest.raises(MapError, match='cannot be read'):
            wait_for_map(path + '.gone', timeout=0.0)

    def test_what_the_map_is_made_from_must_be_there(self, path):
        with pytest.raises(MapError, match=r'no\.yaml: the map is made from this file'):
            wait_for_map(path, made_from=['no.yaml'])

    def test_it_can_be_given_up(self, path):
        with pytest.raises(MapError):
            wait_for_map(path + '.gone', timeout=1e9, say=lambda text: None, given_up=lambda: True)
