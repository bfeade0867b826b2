"""A changed map file is reported when it has settled; programs wait for a map not made yet."""
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
    """Sets the modification time of `path` to `seconds` after the epoch."""
    os.utime(path, (seconds, seconds))


class Watched:
    """A watched file, and the time between two checks of it."""

    def __init__(self, path: str) -> None:
        self.now = 0.0
        self.watcher = MapWatcher(path, settled=2.0, clock=lambda: self.now)

    def after(self, *seconds: float) -> list:
        """Checks the file after each of these pauses (s). Returns the results."""
        told = []
        for pause in seconds:
            self.now += pause
            told.append(self.watcher.changed())
        return told


class TestMapWatcher:
    @pytest.fixture
    def old(self, path) -> Watched:
        set_age(path, 1000)
        return Watched(path)

    def test_an_unchanged_file_is_no_news(self, old):
        assert not old.watcher.unfinished
        assert not any(old.after(0.5, 5.0, 5.0))

    def test_a_change_is_told_once_it_has_settled_and_only_once(self, old):
        write(old.watcher.path, b'longer')
        assert old.after(0.5, 1.5, 0.4, 0.2, 9.0) == [False, False, False, True, False]

    def test_a_file_that_grows_slowly_is_waited_for(self, old):
        told = []
        for size in (5, 6, 7):
            write(old.watcher.path, b'x' * size)
            told += old.after(0.9, 0.9)
        assert not any(told)
        assert old.after(0.9, 0.3) == [False, True]

    def test_a_file_that_was_written_just_now_is_told_when_it_has_settled(self, path):
        new = Watched(path)
        assert new.watcher.unfinished
        assert new.after(0.5, 1.6, 5.0) == [False, True, False]
        assert not new.watcher.unfinished

    def test_a_file_replaced_by_another_of_the_same_size_and_time_is_a_change(self, old):
        other = old.watcher.path + '.new'
        write(other, b'two')
        set_age(other, 1000)
        os.replace(other, old.watcher.path)
        assert old.after(0.1, 2.0) == [False, True]

    def test_a_file_that_goes_is_no_change_but_one_that_comes_is(self, old):
        os.unlink(old.watcher.path)
        assert not any(old.after(1.0, 3.0, 3.0))
        write(old.watcher.path, b'back again')
        assert old.after(0.1, 2.0) == [False, True]

    def test_a_file_that_is_not_there_is_not_unfinished(self, path):
        assert not MapWatcher(path + '.gone').unfinished


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
        with pytest.raises(MapError, match=r'older than its source files: .*a\.map\.base'):
            wait_for_map(path, made_from=[base], timeout=0.0, say=lambda text: None)
        with pytest.raises(MapError, match='cannot be read'):
            wait_for_map(path + '.gone', timeout=0.0)

    def test_what_the_map_is_made_from_must_be_there(self, path):
        with pytest.raises(MapError, match=r'no\.yaml: the map is created from this file'):
            wait_for_map(path, made_from=['no.yaml'])

    def test_it_can_be_given_up(self, path):
        with pytest.raises(MapError):
            wait_for_map(path + '.gone', timeout=1e9, say=lambda text: None, given_up=lambda: True)
