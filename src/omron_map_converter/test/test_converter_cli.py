"""The command line of the converter: its files, messages and drawings."""
from __future__ import annotations

import contextlib
import io
import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from converter_builders import LAB, map_with
from PIL import Image

from omron_map import MapDocument
from omron_map.picture import BLACK, GREEN
from omron_map_converter import picture as colours
from omron_map_converter.cli import main
from omron_map_converter.fences import is_fence


def arguments(output, *more, graph=LAB / 'lab_graph.yaml', base_map=LAB / 'lab_base.map'):
    return ['--graph', str(graph), '--base-map', str(base_map), '--output', str(output), *more]


class Made(NamedTuple):
    """A map and a picture that the command line made, and what it printed."""

    map: Path
    picture: Path
    out: str
    err: str

    @property
    def document(self) -> MapDocument:
        return MapDocument.load(str(self.map))


@pytest.fixture(scope='module')
def made(tmp_path_factory) -> Made:
    """Returns the laboratory's map with fences as areas. It is made once, because this takes
    seconds.
    """
    folder = tmp_path_factory.mktemp('made')
    output, picture = folder / 'out.map', folder / 'out.png'
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        assert main(arguments(output, '--dock-vertex', '16', '--draw', str(picture))) == 0
    return Made(output, picture, out.getvalue(), err.getvalue())


def test_a_map_is_made_and_told_of(made):
    assert f'{made.map}: 24 goals, 5 of them with heading' in made.out
    assert 'dock 16: DockLynx at -13200 -7000 mm, facing its station at 180.0 degrees' in made.out
    assert made.err == ''


def test_the_dock_heading_may_be_given(tmp_path):
    output = tmp_path / 'out.map'
    assert main(arguments(output, '--dock-vertex', '16', '--dock-heading', '-90',
                          '--fences', 'none')) == 0
    assert MapDocument.load(str(output)).docks[0].theta == -90.0


@pytest.mark.parametrize('more, inputs, told', [
    (('--dock-vertex', '17'), {}, 'no vertex 17'),
    (('--dock-vertex', '4'), {}, 'dock vertex 4 has several edges'),
    (('--dock-vertex', '16', '--dock-heading', 'nan'), {}, 'dock_heading is nan'),
    ((), {'graph': 'absent.yaml'}, 'absent.yaml'),
    ((), {'base_map': 'absent.map'}, 'absent.map'),
    ((), {'graph': LAB / 'lab_base.map'}, 'lab_base.map'),
    ((), {'base_map': LAB / 'lab_graph.yaml'}, 'lab_graph.yaml'),
])
def test_what_cannot_be_converted_is_one_sentence_and_no_file(tmp_path, capsys, more, inputs, told):
    output = tmp_path / 'out.map'
    assert main(arguments(output, *more, **inputs)) == 1
    error = capsys.readouterr().err
    assert told in error
    assert error.startswith('error: ')
    assert len(error.splitlines()) == 1
    assert not output.exists()


def test_missing_options_end_with_status_2():
    with pytest.raises(SystemExit) as ended:
        main(['--graph', 'g.yaml'])
    assert ended.value.code == 2


def kinds_of_fences(document):
    return {kind for kind, objects in (('areas', document.forbidden_areas),
                                       ('lines', document.forbidden_lines))
            if any(map(is_fence, objects))}


def test_fences_are_areas_if_nothing_else_is_said(made):
    assert kinds_of_fences(made.document) == {'areas'}


@pytest.mark.parametrize('fences, kinds', [('lines', {'lines'}), ('none', set())])
def test_the_kind_of_fences_is_chosen(tmp_path, fences, kinds):
    output = tmp_path / 'out.map'
    assert main(arguments(output, '--fences', fences)) == 0
    assert kinds_of_fences(MapDocument.load(str(output))) == kinds


def test_single_edges_may_be_wider(tmp_path, made):
    def blocks_beside_edge_1(document):
        return min(area.rectangle.corners[:, 1].min()
                   for area in filter(is_fence, document.forbidden_areas)
                   if area.rectangle.contains([[-10000.0, 2000.0]])[0])
    output = tmp_path / 'out.map'
    assert main(arguments(output, '--edge-width', '1=1.3,2=1.0', '--fences', 'areas')) == 0
    assert blocks_beside_edge_1(made.document) == pytest.approx(450, abs=25)
    assert blocks_beside_edge_1(MapDocument.load(str(output))) == pytest.approx(650, abs=25)


@pytest.mark.parametrize('option, value, told', [
    ('--corridor-width', '0.4', 'corridor of 0.4 m'),
    ('--corridor-width', 'nan', 'corridor of nan m'),
    ('--edge-width', '3:1.2', "edge_width '3:1.2'"),
    ('--edge-width', '77=1.2', 'no edge 77'),
    ('--edge-width', '3=0.1', 'corridor of 0.1 m'),
    ('--turning-margin', '-1', 'turning_margin is -1'),
])
def test_corridors_that_make_no_sense_are_refused(tmp_path, capsys, option, value, told):
    assert main(arguments(tmp_path / 'out.map', option, value)) == 1
    error = capsys.readouterr().err
    assert told in error
    assert len(error.splitlines()) == 1


def test_the_picture_shows_fences_and_places(made):
    image = np.asarray(Image.open(str(made.picture))).astype(int)
    for colour in (colours.FENCE, colours.CORRIDOR, colours.CURVE, colours.FORBIDDEN, GREEN, BLACK):
        assert (abs(image - colour).max(axis=-1) < 12).sum() > 20, f'the picture has no {colour}'


def test_a_picture_is_replaced_by_a_complete_one(tmp_path):
    picture, old = tmp_path / 'out.png', tmp_path / 'old.png'
    picture.write_bytes(b'an older picture')
    os.link(picture, old)
    assert main(arguments(tmp_path / 'out.map', '--fences', 'none', '--draw', str(picture))) == 0
    assert picture.read_bytes().startswith(b'\x89PNG')
    assert old.read_bytes() == b'an older picture', 'the old file was overwritten in place'


def test_the_picture_of_a_map_without_walls_shows_the_outermost_fences(tmp_path):
    (tmp_path / 'base.map').write_bytes(map_with().to_bytes())
    picture = tmp_path / 'out.png'
    assert main(arguments(tmp_path / 'out.map', '--draw', str(picture),
                          base_map=tmp_path / 'base.map')) == 0
    image = np.asarray(Image.open(str(picture)))
    border = np.concatenate((image[0], image[-1], image[:, 0], image[:, -1]))
    assert (border > 220).all(), 'something other than background and grid reaches the border'
    assert (image == colours.FENCE).all(axis=-1).any()


def test_a_picture_that_cannot_be_written_is_told(tmp_path, capsys):
    picture = tmp_path / 'no' / 'out.png'
    assert main(arguments(tmp_path / 'out.map', '--fences', 'none', '--draw', str(picture))) == 1
    assert 'out.png: it cannot be written' in capsys.readouterr().err
