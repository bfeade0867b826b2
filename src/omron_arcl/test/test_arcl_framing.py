"""Lines are complete, however their bytes are split."""
from __future__ import annotations

import pytest

from omron_arcl.framing import LineBuffer


@pytest.mark.parametrize('end', [b'\n', b'\r', b'\r\n', b'\n\r', b'\r\n\r\n'])
def test_each_kind_of_line_end_ends_a_line(end):
    assert LineBuffer().feed(b'one' + end + b'two' + end) == [b'one', b'two']


def test_a_cut_line_is_kept_until_its_end_arrives():
    buffer = LineBuffer()
    assert buffer.feed(b'Arri') == []
    assert buffer.feed(b'ved at 1\r') == [b'Arrived at 1']
    assert buffer.feed(b'\nnext\n') == [b'next']


def test_blank_lines_are_nothing():
    assert LineBuffer().feed(b'\n \n\t\r\n') == []


@pytest.mark.parametrize('negotiation', [
    b'\xff\xfb\x01', b'\xff\xfd\x03\xff\xfb\x01', b'\xff\xf1', b'\xff\xff'])
def test_telnet_negotiation_is_cut_out(negotiation):
    assert LineBuffer().feed(negotiation + b'Enter password:\r\n') == [b'Enter password:']


def test_telnet_negotiation_is_cut_out_across_pieces():
    buffer = LineBuffer()
    assert buffer.feed(b'\xff') == []
    assert buffer.feed(b'\xfb\x01Enter password:\n') == [b'Enter password:']


def test_other_bytes_stay_as_they_are():
    assert LineBuffer().feed('Goal: café'.encode() + b'\x00\xfe\n') \
        == ['Goal: café'.encode() + b'\x00\xfe']


@pytest.mark.parametrize('size', [1, 7, 10_000])
def test_a_line_over_the_limit_overflows_after_the_good_lines(size):
    buffer = LineBuffer(limit=100)
    data = b'good\n' + b'x' * 101 + b'\nlate\n'
    lines = [line for i in range(0, len(data), size) for line in buffer.feed(data[i:i + size])]
    assert lines == [b'good']
    assert buffer.overflowed
    assert buffer.feed(b'more\n') == []


def test_a_line_of_the_limit_is_taken():
    buffer = LineBuffer(limit=100)
    assert buffer.feed(b'x' * 100 + b'\n') == [b'x' * 100]
    assert not buffer.overflowed
