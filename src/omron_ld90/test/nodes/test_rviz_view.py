"""RViz opens on the map, wherever and however large it is."""
from __future__ import annotations

import fnmatch
from pathlib import Path

import pytest
import yaml

from omron_ld90.nodes.rviz_view import (
    FULL,
    HEIGHT,
    WIDTH,
    Size,
    View,
    configuration_for,
    rendering_arguments,
    screen_size,
    view_size,
)
from omron_map import MapDocument

REPOSITORY = Path(__file__).resolve().parents[4]
SHIPPED = (REPOSITORY / 'rviz/omron_ld90.rviz').read_text()


def room(west: int, south: int, east: int, north: int) -> MapDocument:
    """A map that holds the two opposite corners of a room, in mm."""
    return MapDocument.from_bytes(
        f'2D-Map\nNumPoints: 2\nDATA\n{west} {south}\n{east} {north}\n'.encode())


def test_the_shipped_configuration_shows_the_whole_laboratory():
    assert configuration_for(MapDocument.load(str(REPOSITORY / 'maps/lab.map')), SHIPPED) is None


@pytest.mark.parametrize('west, south, east, north', [
    (-6260, -9820, 25820, 16320), (100000, 0, 101000, 80000), (0, 0, 300000, 1000)])
def test_a_map_that_is_larger_or_elsewhere_is_put_into_the_middle(west, south, east, north):
    text = configuration_for(room(west, south, east, north), SHIPPED)
    view = View.in_configuration(text)
    assert view.shows(west / 1000, south / 1000, east / 1000, north / 1000 + 1.0)
    assert view.x == pytest.approx((west + east) / 2000, abs=0.01)
    assert min(WIDTH / view.scale - (east - west) / 1000,
               HEIGHT / view.scale - (north - south) / 1000) < 2.5, 'no larger than needed'


def test_only_the_view_is_changed():
    shipped = yaml.safe_load(SHIPPED)
    changed = yaml.safe_load(configuration_for(room(0, 0, 90000, 90000), SHIPPED))
    for configuration in (shipped, changed):
        for name in ('Scale', 'X', 'Y'):
            del configuration['Visualization Manager']['Views']['Current'][name]
    assert changed == shipped


@pytest.mark.parametrize('screen', [Size(1280, 900), Size(1920, 1080)])
def test_a_screen_that_holds_the_window_changes_nothing(screen):
    assert view_size(screen) == FULL


@pytest.mark.parametrize('screen', [Size(1366, 768), Size(1024, 740), Size(1200, 1600)])
def test_on_a_smaller_screen_the_window_fits_and_shows_the_whole_map(screen):
    laboratory = MapDocument.load(str(REPOSITORY / 'maps/lab.map'))
    size = view_size(screen)
    text = configuration_for(laboratory, SHIPPED, size)
    assert View.in_configuration(text).shows(-15, -9, 15, 10, size)
    window = yaml.safe_load(text)['Window Geometry']
    assert window['Width'] <= screen.width and window['Height'] <= screen.height
    assert size.width <= window['Width'] and size.height <= window['Height']


def test_a_view_that_is_not_from_above_is_left_alone():
    orbit = SHIPPED.replace('Class: rviz/TopDownOrtho', 'Class: rviz/Orbit').replace(
        '      Scale: 40\n', '      Distance: 40\n')
    assert configuration_for(room(0, 0, 90000, 90000), orbit) is None


def test_a_map_without_points_and_lines_leaves_the_view_alone():
    assert configuration_for(MapDocument.from_bytes(b'2D-Map\nDATA\n'), SHIPPED) is None


def test_where_a_program_draws_anti_aliasing_is_left_out(monkeypatch):
    monkeypatch.setenv('LIBGL_ALWAYS_SOFTWARE', '1')
    assert rendering_arguments() == ['--disable-anti-aliasing']


@pytest.mark.parametrize('device', ['/dev/dri/card0', '/dev/nvidia0'])
def test_a_graphics_card_draws_as_well_as_it_can(monkeypatch, device):
    monkeypatch.delenv('LIBGL_ALWAYS_SOFTWARE', raising=False)
    monkeypatch.setattr('glob.glob', lambda pattern: fnmatch.filter([device], pattern))
    assert rendering_arguments() == []


def test_without_a_display_a_sentence_says_so(monkeypatch):
    monkeypatch.setenv('DISPLAY', ':12345')
    with pytest.raises(SystemExit, match='there is no X display ":12345"'):
        screen_size()
