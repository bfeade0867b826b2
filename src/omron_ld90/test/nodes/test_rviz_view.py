"""RViz opens with the map in view, wherever the map is and however large it is."""
from __future__ import annotations

import fnmatch
from pathlib import Path

import pytest
import yaml

from omron_ld90.nodes.rviz_view import (
    FULL,
    HEIGHT,
    WIDTH,
    PixelSize,
    RvizConfiguration,
    configuration_for,
    fitted_copy,
    rendering_arguments,
    screen_size,
    view_size,
)
from omron_map import MapDocument

REPOSITORY = Path(__file__).resolve().parents[4]
SHIPPED = (REPOSITORY / 'rviz/omron_ld90.rviz').read_text()


def room(west: int, south: int, east: int, north: int) -> MapDocument:
    """Returns a map that contains two opposite corners of a room, in mm."""
    return MapDocument.from_bytes(
        f'2D-Map\nNumPoints: 2\nDATA\n{west} {south}\n{east} {north}\n'.encode())


def test_the_shipped_configuration_shows_the_whole_laboratory():
    assert configuration_for(MapDocument.load(str(REPOSITORY / 'maps/lab.map')), SHIPPED) is None


@pytest.mark.parametrize('west, south, east, north', [
    (-6260, -9820, 25820, 16320), (100000, 0, 101000, 80000), (0, 0, 300000, 1000)])
def test_a_map_that_is_larger_or_elsewhere_is_put_into_the_middle(west, south, east, north):
    text = configuration_for(room(west, south, east, north), SHIPPED)
    view = RvizConfiguration(text).view
    assert view.shows(west / 1000, south / 1000, east / 1000, north / 1000 + 1.0)
    assert view.x == pytest.approx((west + east) / 2000, abs=0.01)
    assert min(WIDTH / view.scale - (east - west) / 1000,
               HEIGHT / view.scale - (north - south) / 1000) < 2.5, 'the view is larger than needed'


def test_only_the_view_is_changed():
    shipped = yaml.safe_load(SHIPPED)
    changed = yaml.safe_load(configuration_for(room(0, 0, 90000, 90000), SHIPPED))
    for configuration in (shipped, changed):
        for name in ('Scale', 'X', 'Y'):
            del configuration['Visualization Manager']['Views']['Current'][name]
    assert changed == shipped


@pytest.mark.parametrize('screen', [PixelSize(1280, 900), PixelSize(1920, 1080)])
def test_a_screen_that_holds_the_window_changes_nothing(screen):
    assert view_size(screen) == FULL


@pytest.mark.parametrize('screen',
                         [PixelSize(1366, 768), PixelSize(1024, 740), PixelSize(1200, 1600)])
def test_on_a_smaller_screen_the_window_fits_and_shows_the_whole_map(screen):
    laboratory = MapDocument.load(str(REPOSITORY / 'maps/lab.map'))
    size = view_size(screen)
    text = configuration_for(laboratory, SHIPPED, size)
    assert RvizConfiguration(text).view.shows(-15, -9, 15, 10, size)
    window = yaml.safe_load(text)['Window Geometry']
    assert window['Width'] <= screen.width and window['Height'] <= screen.height
    assert size.width <= window['Width'] and size.height <= window['Height']


def test_a_view_that_is_not_from_above_is_left_alone():
    orbit = SHIPPED.replace('Class: rviz/TopDownOrtho', 'Class: rviz/Orbit').replace(
        '      Scale: 40\n', '      Distance: 40\n')
    assert configuration_for(room(0, 0, 90000, 90000), orbit) is None


@pytest.fixture
def site(tmp_path) -> tuple:
    """Writes a map that the view of the shipped RViz configuration does not show.

    Returns the path of the map, and a path for an RViz configuration.
    """
    room(0, 0, 90000, 90000).save(str(tmp_path / 'site.map'))
    return str(tmp_path / 'site.map'), tmp_path / 'site.rviz'


def without_views() -> str:
    configuration = yaml.safe_load(SHIPPED)
    del configuration['Visualization Manager']['Views']
    return yaml.safe_dump(configuration)


@pytest.mark.parametrize('text, problem', [
    (without_views(), 'it has no current view'), ('', 'it has no current view'),
    ('[1, 2]', 'it has no current view'), ('{ "', 'it is not YAML'),
    (SHIPPED.replace('      Scale: 40\n', ''), 'no Scale, X and Y'),
    (SHIPPED.replace('Scale: 40', 'Scale: wide'), 'no Scale, X and Y'),
    (SHIPPED.replace('Scale: 40', 'Scale: 0'), 'no Scale, X and Y')])
def test_a_configuration_that_cannot_be_fitted_is_opened_as_it_is_and_that_is_said(
        site, capsys, text, problem):
    map_file, configuration = site
    configuration.write_text(text)
    assert fitted_copy(map_file, str(configuration), FULL) == str(configuration)
    said = capsys.readouterr().err
    assert problem in said and said.count('\n') == 1


def test_a_configuration_that_cannot_be_read_is_named(site):
    map_file, configuration = site
    with pytest.raises(SystemExit, match=r'site\.rviz cannot be read'):
        fitted_copy(map_file, str(configuration), FULL)


def test_a_map_that_cannot_be_read_leaves_the_view_alone(site, capsys):
    _, configuration = site
    configuration.write_text(SHIPPED)
    assert fitted_copy('/dev/zero', str(configuration), FULL) == str(configuration)
    assert 'it is a device' in capsys.readouterr().err


def test_a_configuration_of_another_layout_is_fitted_too(site):
    map_file, configuration = site
    configuration.write_text(yaml.safe_dump(yaml.safe_load(SHIPPED), indent=4))
    copy = fitted_copy(map_file, str(configuration), FULL)
    assert RvizConfiguration(Path(copy).read_text()).view.shows(0, 0, 90, 91)


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
