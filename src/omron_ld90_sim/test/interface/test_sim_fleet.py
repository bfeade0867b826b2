"""Fleet files."""
from __future__ import annotations

from pathlib import Path

import pytest

from omron_ld90_sim.interface.fleet import FleetError, read_fleet


@pytest.mark.parametrize('text, words', [
    ('robots: []', 'at least one robot'), ('robots: [{name: a}]', 'robot 1: has no port'),
    ('robots: [{port: 1, wings: 2}]', 'unknown field wings'), ('{', 'is not YAML'),
    ('robots: [{port: 70000}]', 'out of range'),
    ('robots: [{port: 7171}, {port: 7171}]', 'two robots have the port 7171'),
    ('robots: [{port: 1, outgoing: here}]', 'is not HOST:PORT'),
    ('robots: [{port: 1, start: [1, 2]}]', 'robot 1: '),
    ('robots: [{port: 1, start: [0, 0, .nan]}]', "'nan' is not a number"),
    ('robots: [{port: 1, battery: .inf}]', 'not a number from 0 to 100')])
def test_a_malformed_fleet_is_told_in_a_sentence(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / 'fleet.yaml'
    path.write_text(text)
    with pytest.raises(FleetError, match=words):
        read_fleet(str(path))


def test_a_file_that_is_no_text_is_told_in_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / 'fleet.yaml'
    path.write_bytes(b'robots: [{port: 1, name: \xff}]')
    with pytest.raises(FleetError, match='fleet.yaml: is not YAML'):
        read_fleet(str(path))
