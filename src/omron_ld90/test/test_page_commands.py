"""A test runs each command of README, tutorials and some how-to pages, or a reason is given."""
from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / 'test'))

from page_commands import PAGES, Block, blocks_of  # noqa: E402

NOTES = ('', 'goes on')


def name_of(page: Path) -> str:
    return page.name


def prose(page: Path) -> str:
    return re.sub(r'^```.*?^```$', '', page.read_text(encoding='utf-8'), flags=re.M | re.S)


@pytest.mark.parametrize('page', PAGES, ids=name_of)
def test_each_shell_block_is_run_or_has_a_reason(page):
    shell = [block for block in blocks_of(page.read_text(encoding='utf-8')) if block.is_shell]
    assert shell, 'a page without commands'
    assert [f'{page.name}:{block.line}: {block.note}' for block in shell
            if block.note not in NOTES and not block.reason] == []


@pytest.mark.parametrize('page', PAGES, ids=name_of)
def test_commands_stand_in_no_other_kind_of_block(page):
    """An indented block, or one of an unknown language, would not be found."""
    assert re.findall(r'^(?:    |\t)\S.*', prose(page), re.M) == []
    assert {block.language for block in blocks_of(page.read_text(encoding='utf-8'))} <= {
        'bash', 'yaml', 'text'}


def test_a_comment_above_a_block_tells_what_is_special():
    assert blocks_of('a\n<!-- goes on -->\n```bash\nb\n```\n\n```bash\nc\n```\n'
                     '<!-- not run: needs a robot -->\n```bash\nd\n```\n') == [
        Block('bash', 'b\n', 'goes on', 3), Block('bash', 'c\n', '', 7),
        Block('bash', 'd\n', 'not run: needs a robot', 11)]
    assert not Block('bash', '', 'not run:', 1).reason
    assert Block('bash', '', 'not run: needs a robot', 1).reason == 'needs a robot'


def test_a_comment_elsewhere_is_none_of_the_block():
    assert blocks_of('<!-- not run: x -->\n\n```bash\nb\n```\n') == [Block('bash', 'b\n', '', 3)]
