"""Only one node at a time keeps its data in a file."""
from __future__ import annotations

import subprocess
import sys

import pytest

from node_lifecycle import ConfigurationError, kept_files
from node_lifecycle.kept_files import hold

HOLDER = """
import sys
from node_lifecycle.kept_files import hold
hold(sys.argv[1], '~motion_file')
print('held', flush=True)
sys.stdin.read()
"""


@pytest.fixture
def path(tmp_path, monkeypatch) -> str:
    monkeypatch.setattr(kept_files, 'PATIENCE', 0.05)
    return str(tmp_path / 'folder' / 'motion.json')


def test_a_second_node_is_told_in_a_sentence_until_the_first_one_has_ended(path, monkeypatch):
    with subprocess.Popen([sys.executable, '-c', HOLDER, path], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE) as holder:
        assert holder.stdout.readline() == b'held\n'
        with pytest.raises(ConfigurationError, match='Another node keeps its memory in .*json: '
                           'end that node, or .* with ~motion_file.$'):
            hold(path, '~motion_file')
        monkeypatch.setattr(kept_files, 'PATIENCE', 20.0)
        holder.stdin.close()  # the first node ends while the second one waits
        hold(path, '~motion_file')


def test_without_a_file_or_a_place_for_it_nothing_is_held(tmp_path, path):
    hold('', '~motion_file')
    (tmp_path / 'file').write_text('')
    hold(str(tmp_path / 'file' / 'motion.json'), '~motion_file')
