"""A file is replaced by a complete new file, or not at all; all packages use `replace_file`."""
from __future__ import annotations

import ast
import errno
import os
import threading
from pathlib import Path
from typing import List

import pytest

import file_replacement
from file_replacement import replace_file

SOURCES = Path(__file__).resolve().parents[2]
ROTATES_ITS_LOG = 'omron_arcl/src/omron_arcl/session_log.py'
COPIES_WHAT_NO_MEMORY_HOLDS = 'fleet_services/src/fleet_services/ownership.py'


def mode_of(path: Path) -> int:
    return path.stat().st_mode & 0o7777


def names(folder: Path) -> List[str]:
    return sorted(file.name for file in folder.iterdir())


@pytest.mark.parametrize('content', ['text, ä\r\n', b'\x00\xff\r\n', ''])
def test_the_new_content_is_there_and_nothing_else(tmp_path, content):
    path = tmp_path / 'file'
    for old in (None, b'a longer content of before'):
        if old is not None:
            path.write_bytes(old)
        replace_file(path, content)
        assert path.read_bytes() == (content.encode() if isinstance(content, str) else content)
        assert names(tmp_path) == ['file']


def test_a_file_of_others_is_not_replaced_under_a_name_that_the_user_did_not_give(tmp_path):
    path = tmp_path / 'file'
    replace_file(path, '# made by me\n1', only_with=b'made by me')
    replace_file(path, '# made by me\n2', only_with=b'made by me')
    assert path.read_text() == '# made by me\n2'
    path.write_text('of the user')
    with pytest.raises(FileExistsError, match='not written by this program'):
        replace_file(path, '# made by me\n3', only_with=b'made by me')
    assert path.read_text() == 'of the user'
    assert names(tmp_path) == ['file']


@pytest.mark.parametrize('failing', ['fsync', 'replace', 'fchmod'])
def test_where_it_fails_the_old_file_stays_and_nothing_is_left_behind(
        tmp_path, monkeypatch, failing):
    path = tmp_path / 'file'
    path.write_text('old')

    def full(*_arguments: object) -> None:
        raise OSError(errno.ENOSPC, 'No space left on device')

    monkeypatch.setattr(file_replacement.os, failing, full)
    with pytest.raises(OSError, match='No space left'):
        replace_file(path, 'new')
    assert path.read_text() == 'old'
    assert names(tmp_path) == ['file']


def test_a_reader_never_sees_a_part_of_a_file(tmp_path):
    path = tmp_path / 'file'
    contents = {letter * 100_000 for letter in 'ab'}
    replace_file(path, 'a' * 100_000)
    ending = threading.Event()
    seen = set()

    def read() -> None:
        while not ending.is_set():
            seen.add(path.read_text())

    reader = threading.Thread(target=read)
    reader.start()
    for _ in range(50):
        for content in sorted(contents):
            replace_file(path, content, on_disk=False)
    ending.set()
    reader.join()
    assert seen <= contents


def test_the_file_and_then_its_folder_are_on_the_disk(tmp_path, monkeypatch):
    done: List[str] = []
    sync, replace = os.fsync, os.replace

    def noted_sync(handle: int) -> None:
        done.append('folder' if os.path.isdir(f'/proc/self/fd/{handle}') else 'file')
        sync(handle)

    def noted_replace(old: str, new: str) -> None:
        done.append('replace')
        replace(old, new)

    monkeypatch.setattr(file_replacement.os, 'fsync', noted_sync)
    monkeypatch.setattr(file_replacement.os, 'replace', noted_replace)
    replace_file(tmp_path / 'file', 'new')
    assert done == ['file', 'replace', 'folder']
    done.clear()
    replace_file(tmp_path / 'file', 'newer', on_disk=False)
    assert done == ['replace']


def test_the_mode_is_that_of_the_old_file_or_of_any_new_one(tmp_path):
    path, other = tmp_path / 'file', tmp_path / 'other'
    other.touch()
    replace_file(path, 'new')
    assert mode_of(path) == mode_of(other)
    path.chmod(0o640)
    replace_file(path, 'newer')
    assert mode_of(path) == 0o640
    replace_file(path, 'secret', mode=0o600)
    assert mode_of(path) == 0o600


def test_a_secret_can_at_no_moment_be_read_by_others(tmp_path, monkeypatch):
    modes: List[int] = []
    replace = os.replace

    def noted(old: str, new: str) -> None:
        modes.append(mode_of(Path(old)))
        replace(old, new)

    opened = os.open

    def noted_open(path: str, flags: int, mode: int = 0o777) -> int:
        modes.append(mode)
        return opened(path, flags, mode)

    monkeypatch.setattr(file_replacement.os, 'replace', noted)
    monkeypatch.setattr(file_replacement.os, 'open', noted_open)
    replace_file(tmp_path / 'file', 'secret', mode=0o600, on_disk=False)
    assert modes == [0o600, 0o600]


def test_a_link_stays_and_what_it_leads_to_is_replaced(tmp_path):
    folder = tmp_path / 'elsewhere'
    folder.mkdir()
    link = tmp_path / 'link'
    link.symlink_to(folder / 'file')
    for content in ('new', 'newer'):
        replace_file(link, content)
        assert link.is_symlink() and (folder / 'file').read_text() == content
    assert names(folder) == ['file']


def test_the_old_file_is_kept_where_it_is_asked_for(tmp_path):
    path, backup = tmp_path / 'file', tmp_path / 'file.bak'
    replace_file(path, 'first', backup=backup)
    assert not backup.exists()
    replace_file(path, 'second', backup=backup)
    assert (path.read_text(), backup.read_text()) == ('second', 'first')


def test_a_name_of_any_length_that_a_file_may_have_is_replaced(tmp_path):
    path = tmp_path / ('ä' * 127)
    replace_file(path, 'new')
    assert path.read_text() == 'new'


def test_a_folder_that_is_not_there_is_an_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        replace_file(tmp_path / 'none' / 'file', 'new')


def test_no_other_module_of_the_workspace_replaces_files():
    replacing = set()
    for file in SOURCES.glob('*/src/**/*.py'):
        for node in ast.walk(ast.parse(file.read_bytes())):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and (
                    f'{node.value.id}.{node.attr}' in ('os.replace', 'os.rename')):
                replacing.add(str(file.relative_to(SOURCES)))
    assert replacing == {'file_replacement/src/file_replacement/__init__.py', ROTATES_ITS_LOG,
                         COPIES_WHAT_NO_MEMORY_HOLDS}
