"""Kept maps: a map is used again only if it was made from the same data."""
import os
from pathlib import Path

import pytest
from converter_builders import graph_of, map_with

from omron_map import MapError
from omron_map_converter import kept_maps
from omron_map_converter.converter import ConversionOptions, ExistingGoals, convert_file
from omron_map_converter.fences import Fences
from omron_map_converter.kept_maps import MOST, convert_or_copy, folder_of_this_user

GRAPH = graph_of([(1, 0.0, 0.0), (2, 4.0, 0.0), (3, 8.0, 0.0)], [(1, 2), (2, 3)])
LONGER = graph_of([(1, 0.0, 0.0), (2, 4.0, 0.0), (3, 9.0, 0.0)], [(1, 2), (2, 3)])
DOCKED = ConversionOptions(dock_vertex=3)


class Bench:
    """A base map, a folder of kept maps, and the number of conversions so far."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.base, self.output = folder / 'base.map', folder / 'made.map'
        self.kept = folder / 'kept'
        map_with().save(str(self.base))
        self.conversions = 0
        monkeypatch.setattr(kept_maps, 'convert_file', self._counted)

    def _counted(self, *arguments: object) -> None:
        self.conversions += 1
        convert_file(*arguments)

    def makes(self, graph=GRAPH, options=DOCKED) -> bytes:
        """Returns the map."""
        self.output.unlink(missing_ok=True)
        convert_or_copy(graph, str(self.base), str(self.output), options, self.kept)
        return self.output.read_bytes()

    def file(self) -> Path:
        """Returns the only kept file."""
        only, = self.kept.iterdir()
        return only


@pytest.fixture
def bench(tmp_path, monkeypatch):
    return Bench(tmp_path, monkeypatch)


def test_the_second_map_of_the_same_files_is_a_copy_of_the_first(bench):
    assert bench.makes() == bench.makes()
    assert bench.conversions == 1


@pytest.mark.parametrize('graph, options', [
    (LONGER, DOCKED),
    (GRAPH, ConversionOptions()),
    (GRAPH, ConversionOptions(dock_vertex=3, fences=Fences.LINES)),
    (GRAPH, ConversionOptions(dock_vertex=3, existing_goals=ExistingGoals.KEEP))])
def test_another_graph_or_option_is_converted(bench, graph, options):
    bench.makes()
    bench.makes(graph, options)
    assert bench.conversions == 2


def test_a_changed_base_map_is_converted(bench):
    bench.makes()
    map_with('Goal 1000 2000 0 "" ICON "other"').save(str(bench.base))
    bench.makes()
    assert bench.conversions == 2


def test_a_base_map_that_is_gone_is_told_although_its_map_is_kept(bench):
    bench.makes()
    bench.base.unlink()
    with pytest.raises(MapError):
        bench.makes()


def test_other_source_code_converts(bench, monkeypatch):
    bench.makes()
    monkeypatch.setattr(kept_maps, '_versions', lambda: iter(['another version']))
    bench.makes()
    assert bench.conversions == 2


def test_the_versions_hold_the_code_that_makes_fences_and_reads_maps():
    texts = list(kept_maps._versions())
    assert sum('def fence_areas(' in one for one in texts) == 1
    assert sum('class MapDocument' in one for one in texts) == 1
    assert sum('class Graph:' in one for one in texts) == 1


@pytest.mark.parametrize('damage', [lambda content: content[:-1], lambda content: b'',
                                    lambda content: content.replace(b'2', b'3')])
def test_a_damaged_map_is_made_again(bench, damage):
    before = bench.makes()
    bench.file().write_bytes(damage(bench.file().read_bytes()))
    assert bench.makes() == before and bench.conversions == 2
    assert bench.makes() == before and bench.conversions == 2


def test_a_folder_that_cannot_be_made_keeps_nothing(bench):
    bench.kept.write_text('a file')
    assert bench.makes() == bench.makes()
    assert bench.conversions == 2


def test_the_maps_that_were_used_last_stay(bench):
    bench.makes()
    used = bench.file()
    for number in range(MOST):
        (bench.kept / f'{number}.map').touch()
        os.utime(bench.kept / f'{number}.map', (number, number))
    bench.makes()
    bench.makes(LONGER)
    assert len(list(bench.kept.iterdir())) == MOST
    assert used.exists() and not (bench.kept / '0.map').exists()


def test_only_the_user_reads_kept_maps(bench):
    bench.makes()
    assert [one.stat().st_mode & 0o777 for one in (bench.kept, bench.file())] == [0o700, 0o600]


def test_each_user_has_a_folder_of_their_own(monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', '/caches')
    assert folder_of_this_user() == Path('/caches/omron_map_converter')
    monkeypatch.delenv('XDG_CACHE_HOME')
    monkeypatch.setenv('HOME', '/home/ada')
    assert folder_of_this_user() == Path('/home/ada/.cache/omron_map_converter')
