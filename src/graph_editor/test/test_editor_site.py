"""Sites from maps of robots and of ROS; an unusable map gives one clear message."""
from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from graph_editor.errors import SiteError
from graph_editor.ros_map import load_ros_map
from graph_editor.site import PlaceKind, SiteOptions, load_site, site_of_grid
from omron_map import MapError

LAB = str(Path(__file__).resolve().parents[3] / 'maps' / 'lab_base.map')
ROS_MAP = """\
image: hall.pgm
resolution: 0.1
origin: [-2.0, -1.0, 0.0]
occupied_thresh: 0.65
free_thresh: 0.196
negate: 0
"""


def hall() -> np.ndarray:
    """Returns a hall of 6 x 4 m in the grey values of map_server; row 0 has the highest y."""
    grey = np.full((40, 60), 254, np.uint8)
    grey[(0, -1), :] = grey[:, (0, -1)] = 0
    grey[5:10, 5:10] = 205  # unknown cells
    return grey


def ros_map(folder, text: str = ROS_MAP, grey=None) -> str:
    Image.fromarray(hall() if grey is None else grey).save(folder / 'hall.pgm')
    (folder / 'hall.yaml').write_text(text)
    return str(folder / 'hall.yaml')


def test_a_robots_map_gives_walls_floor_and_places_in_metres():
    site = load_site(LAB, SiteOptions())
    home, = (place for place in site.places if place.kind is PlaceKind.HOME)
    assert home.position == (-12.0, 0.0)
    assert site.floor.clearance_at(np.array([home.position]))[0] > 0.5
    assert site.floor.clearance_at(np.array([(5.7, -7.8)]))[0] == 0.0, 'a forbidden area'
    assert site.frame_id == 'map/lab_base'
    assert site.notes == ()


def test_a_map_with_a_graphs_fences_in_it_is_noticed():
    site = load_site(LAB.replace('lab_base', 'lab'), SiteOptions())
    assert 'fences' in site.notes[0]


def test_goals_and_docks_keep_name_place_and_heading():
    places = load_site(LAB.replace('lab_base', 'lab'), SiteOptions()).places
    dock, = (place for place in places if place.kind is PlaceKind.DOCK)
    assert dock.heading is not None and abs(dock.heading) <= math.pi
    assert {place.name for place in places if place.kind is PlaceKind.GOAL} >= {'8', '14'}


def test_only_the_area_counts_that_was_asked_for():
    site = load_site(LAB, SiteOptions(area=(-13.0, -1.0, -10.0, 1.0)))
    rows, columns = np.nonzero(site.floor.inside)
    centres = site.floor.centres(rows, columns)
    assert (centres.min(axis=0) >= (-13.0, -1.0)).all()
    assert (centres.max(axis=0) <= (-10.0, 1.0)).all()


def test_a_ros_map_is_read_as_map_server_does(tmp_path):
    grid = load_ros_map(ros_map(tmp_path))
    assert grid.origin == (-2.0, -1.0)
    assert grid.cells[-1, 30] == 100 and grid.cells[20, 30] == 0
    assert grid.cells[-7, 7] == -1, 'an image begins at the top, a grid at the bottom'


def test_a_negated_ros_map_is_the_same_with_the_colours_exchanged(tmp_path):
    plain = load_ros_map(ros_map(tmp_path)).cells
    negated = load_ros_map(ros_map(tmp_path, ROS_MAP.replace('negate: 0', 'negate: 1'),
                                   255 - hall())).cells
    assert np.array_equal(plain, negated)


def test_what_a_ros_map_does_not_know_is_no_floor(tmp_path):
    floor = load_site(ros_map(tmp_path), SiteOptions()).floor
    assert floor.clearance_at(np.array([(1.0, 0.5)]))[0] > 1.0
    assert floor.clearance_at(np.array([(-1.25, 2.25)]))[0] == 0.0


def test_a_grid_without_free_cells_is_floor_inside_its_outline():
    cells = np.where(hall()[::-1] == 0, 100, -1).astype(np.int8)
    floor = site_of_grid(cells, 0.1, (0.0, 0.0), SiteOptions()).floor
    assert floor.clearance_at(np.array([(3.0, 2.0)]))[0] > 1.5


@pytest.mark.parametrize('change, words', [
    (('image: hall.pgm', 'image: no.pgm'), 'no.pgm'),
    (('resolution: 0.1', 'resolution: -1'), 'positive'),
    (('resolution: 0.1', 'resolution: .nan'), 'positive'),
    (('resolution: 0.1\n', ''), 'resolution is missing'),
    (('[-2.0, -1.0, 0.0]', '[-2.0, .inf, 0.0]'), 'numbers'),
    (('[-2.0, -1.0, 0.0]', '[-2.0, -1.0]'), 'line 3: origin must be x, y and yaw'),
    (('[-2.0, -1.0, 0.0]', '[-2.0, -1.0, 0.5]'), 'yaw 0 '),
    (('negate: 0', 'mode: raw'), 'trinary'),
    (('negate: 0', 'negate: maybe'), 'whole number'),
    (('occupied_thresh: 0.65', 'occupied_thresh: 65'), 'not percent'),
    (('free_thresh: 0.196', 'free_thresh: 19.6'), 'not percent'),
    (('free_thresh: 0.196', 'free_thresh: 0.7'), 'free_thresh is the smaller one'),
    (('free_thresh: 0.196', 'free_thresh: .nan'), 'free_thresh is nan'),
    (('occupied_thresh: 0.65', 'occupied_thresh: .nan'), 'occupied_thresh nan'),
    (('free_thresh: 0.196', 'free_thresh: -0.1'), 'from 0 to 1'),
    (('image: hall.pgm', 'image: [1]'), 'image must be a text'),
    ((ROS_MAP, '- 1\n'), 'must be a mapping'),
    ((ROS_MAP, '{'), 'not YAML')])
def test_a_wrong_ros_map_is_refused_in_one_sentence(tmp_path, change, words):
    path = ros_map(tmp_path, ROS_MAP.replace(*change))
    with pytest.raises(SiteError, match=words) as refused:
        load_site(path, SiteOptions())
    assert '\n' not in str(refused.value) and str(tmp_path) in str(refused.value)


def test_an_image_that_is_none_is_refused(tmp_path):
    path = ros_map(tmp_path)
    (tmp_path / 'hall.pgm').write_text('P5 no image')
    with pytest.raises(SiteError, match=r'hall\.pgm, the image of .*cannot be read'):
        load_site(path, SiteOptions())


@pytest.mark.parametrize('name', ['missing.map', 'missing.yaml', '.'])
def test_a_file_that_is_not_there_is_told(tmp_path, name):
    with pytest.raises((SiteError, MapError), match=str(tmp_path)):
        load_site(str(tmp_path / name), SiteOptions())


def test_a_grid_too_large_to_work_with_is_refused():
    with pytest.raises(SiteError, match='is the most'):
        site_of_grid(np.broadcast_to(np.int8(0), (10_000, 10_000)), 0.05, (0.0, 0.0), SiteOptions())


FREE, OCCUPIED, UNKNOWN = 0, 100, -1


def pixels_of(tmp_path, name: str, mode: str, *colours: object) -> list:
    """Returns the cells that load_ros_map reads from an image with one row of pixels."""
    image = Image.new(mode, (len(colours), 1))
    for x, colour in enumerate(colours):
        image.putpixel((x, 0), colour)
    image.save(tmp_path / name)
    (tmp_path / 'hall.yaml').write_text(ROS_MAP.replace('hall.pgm', name))
    return load_ros_map(str(tmp_path / 'hall.yaml')).cells[0].tolist()


@pytest.mark.parametrize('name, mode, told', [
    # as in map_server's image_loader.cpp: the mean of all channels, alpha included
    ('a.png', 'RGB', {(255, 255, 255): FREE, (255, 255, 0): UNKNOWN, (0, 255, 0): OCCUPIED,
                      (254, 254, 254): FREE, (205, 205, 205): UNKNOWN, (0, 0, 0): OCCUPIED}),
    ('a.png', 'RGBA', {(255, 255, 255, 255): FREE, (255, 255, 255, 0): UNKNOWN,
                       (0, 0, 0, 0): OCCUPIED, (0, 0, 0, 255): OCCUPIED,
                       (90, 90, 90, 0): OCCUPIED}),
    ('a.png', 'LA', {(255, 255): FREE, (255, 0): UNKNOWN, (0, 0): OCCUPIED}),
    ('a.png', 'I;16', {65535: FREE, 205 * 256: UNKNOWN, 205 * 256 + 255: UNKNOWN, 0: OCCUPIED}),
    ('a.png', '1', {1: FREE, 0: OCCUPIED}),
    ('a.pgm', 'L', {254: FREE, 205: UNKNOWN, 0: OCCUPIED}),
    ('a.ppm', 'RGB', {(255, 255, 0): UNKNOWN})])
def test_a_pixel_of_any_kind_of_image_has_the_value_that_map_server_gives_it(
        tmp_path, name, mode, told):
    assert pixels_of(tmp_path, name, mode, *told) == list(told.values())


def test_an_image_that_map_server_would_read_otherwise_is_refused(tmp_path):
    (tmp_path / 'hall.yaml').write_text(ROS_MAP.replace('hall.pgm', 'a.png'))
    grey = Image.fromarray(hall())
    grey.convert('P').save(tmp_path / 'a.png')
    with pytest.raises(SiteError, match='save it as an 8-bit grey PGM or PNG file'):
        load_ros_map(str(tmp_path / 'hall.yaml'))
    grey.save(tmp_path / 'a.png', transparency=254)
    with pytest.raises(SiteError, match='save it as an 8-bit grey PGM or PNG file'):
        load_ros_map(str(tmp_path / 'hall.yaml'))
    (tmp_path / 'a.png').write_bytes(b'P5 2 1 65535\n' + bytes(4))  # SDL_image refuses this file
    with pytest.raises(SiteError, match='save it as an 8-bit grey PGM or PNG file'):
        load_ros_map(str(tmp_path / 'hall.yaml'))


def test_a_map_whose_unknown_cells_would_be_free_or_that_has_no_walls_is_warned_of(tmp_path):
    text = ROS_MAP.replace('free_thresh: 0.196', 'free_thresh: 0.25')
    assert '205' in load_site(ros_map(tmp_path, text), SiteOptions()).notes[0]
    assert load_site(ros_map(tmp_path), SiteOptions()).notes == ()
    light = np.full((40, 60), 254, np.uint8)
    assert 'no walls' in load_ros_map(ros_map(tmp_path, grey=light)).notes[0]
