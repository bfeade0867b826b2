"""Text from others is shown, and is harmless for a terminal, a log or a spreadsheet."""
from __future__ import annotations

import csv
import io
import logging
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import node_program
from node_lifecycle.log_file import _bounded
from node_program.inert_text import (
    LONGEST_ENTRY,
    InertStream,
    cell,
    entry,
    inert,
    return_to_line_begin,
)

SOURCES = Path(__file__).resolve().parents[3]
EVIL = 'red \x1b[31m, title \x1b]0;pwned\x07, over\rwritten, C1 \x9b2J, \u202eesrever'
WRITES_CSV = 'csv.writer('


def is_active(text: str) -> bool:
    return any((ord(one) < 32 and one not in '\t\n') or 127 <= ord(one) < 160
               or 0x202a <= ord(one) <= 0x202e for one in text)


@given(st.text())
def test_no_control_character_is_left_and_all_else_is(text):
    assert not is_active(inert(text))
    if not is_active(text) and text.isprintable():
        assert inert(text) == text


def test_a_stream_shows_escapes_and_keeps_lines_and_other_letters():
    raw = io.BytesIO()
    stream = InertStream(raw, encoding='utf-8')
    print(EVIL, 'Röntgen 台\ttab', file=stream, flush=True)
    shown = raw.getvalue().decode()
    assert not is_active(shown) and shown.endswith('台\ttab\n') and r'\x1b[31m' in shown


def test_only_the_program_itself_replaces_a_line():
    raw = io.BytesIO()
    stream = InertStream(raw, encoding='utf-8')
    return_to_line_begin(stream)
    print('50 %\rdone', end='', file=stream, flush=True)
    assert raw.getvalue() == b'\r50 %\\rdone'
    plain = io.StringIO()
    return_to_line_begin(plain)
    assert plain.getvalue() == '\r'


@pytest.mark.parametrize('stream', ['stdout', 'stderr'])
def test_the_output_of_each_command_is_inert_on_a_terminal(tmp_path, stream):
    (tmp_path / 'module_of_test.py').write_text(
        f'import sys\ndef main():\n    print({EVIL!r}, file=sys.{stream})\n')
    ours, theirs = pty.openpty()
    path = f'{tmp_path}:{Path(node_program.__file__).parents[1]}'
    done = subprocess.run(
        [sys.executable, '-c', 'from node_program import run_command; '
         'run_command("module_of_test")'], check=False, timeout=30, stdout=theirs, stderr=theirs,
        env={**os.environ, 'PYTHONPATH': path})
    os.close(theirs)
    shown = os.read(ours, 10000).decode().replace('\r\n', '\n')
    os.close(ours)
    assert done.returncode == 0 and 'pwned' in shown
    assert not is_active(shown)


@given(st.text(max_size=30))
def test_no_cell_begins_a_formula(text):
    shown = cell(text)
    begin = shown.lstrip()[:1]
    assert begin not in ('=', '@', '＝', '＋', '－', '＠')
    assert begin not in ('+', '-') or not any(one.isalpha() and one not in 'eE' for one in shown)
    assert not is_active(shown)


@pytest.mark.parametrize('text', ['=1+1', '@SUM(A1)', '+cmd|\' /C calc\'!A0', '-2+3+cmd|x', ' =1',
                                  '\t=1', '－1+A1'])
def test_a_formula_becomes_text(text):
    assert cell(text).startswith("'")


@pytest.mark.parametrize('text', ['', '-5', '-3.25', '+1e-7', '-75 -80 3', '12 %', 'lab', '3 = 3'])
def test_numbers_and_words_stay_as_they_are(text):
    assert cell(text) == text


def test_an_entry_of_a_log_is_short_and_inert():
    long = entry('\x1b' + 14_000_000 * '7,')
    assert len(long) < LONGEST_ENTRY + 100 and long.endswith('more characters)')
    assert entry('two\nlines') == 'two\nlines'


def test_each_handler_of_a_log_gets_the_short_entry():
    record = logging.LogRecord('rosout', logging.INFO, 'file', 1, 'edges: %s', ('1, ' * 9999,),
                               None)
    assert _bounded(record)
    once = record.getMessage()
    assert _bounded(record)
    assert record.getMessage() == once
    assert len(once) < LONGEST_ENTRY + 100


def test_an_entry_with_a_wrong_format_reaches_the_handler():
    record = logging.LogRecord('rosout', logging.INFO, 'file', 1, '%d', ('word',), None)
    assert _bounded(record) and record.args == ('word',)


def test_every_table_in_csv_has_inert_cells():
    writers = {str(file.relative_to(SOURCES)): file.read_text(encoding='utf-8')
               for file in SOURCES.glob('*/src/**/*.py')
               if WRITES_CSV in file.read_text(encoding='utf-8')}
    assert len(writers) == 4, sorted(writers)
    for name, text in writers.items():
        assert 'from node_program.inert_text import cell' in text, name


def test_a_reader_of_csv_gets_one_line_for_each_row():
    table = io.StringIO()
    csv.writer(table).writerow([cell('two\rlines'), cell('=1')])
    assert len(table.getvalue().splitlines()) == 1
