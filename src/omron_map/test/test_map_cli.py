"""The output of `ld_map`, its files, and its exit status."""
from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from map_builders import CELL, OBJECTS, TWO_SCANS, room_bytes
from map_fixtures import BAD, ODD
from map_server_reader import read_served_map
from PIL import Image

from omron_map.cli import main


@pytest.fixture
def write(tmp_path):
    def write(data: bytes, name: str = 'a.map') -> str:
        (tmp_path / name).write_bytes(data)
        return str(tmp_path / name)
    return write


class TestCheck:
    def test_a_good_file_is_ok(self, write, capsys):
        path = write(CELL)
        assert main(['check', path]) == 0
        assert capsys.readouterr().out == f'{path}: ok\n'

    def test_what_is_odd_is_told_and_is_no_failure(self, write, capsys):
        path = write(ODD['wrong count'].data)
        assert main(['check', path]) == 0
        assert f'{path}: warning: line 4: NumPoints says 7, the rows say 4\n' in (
            capsys.readouterr().out)

    @pytest.mark.parametrize('name', BAD)
    def test_a_bad_file_fails_with_one_sentence(self, write, capsys, name):
        path = write(BAD[name].data)
        assert main(['check', path]) == 1
        output = capsys.readouterr()
        assert output.out == '' and output.err.startswith(f'ld_map: {path}')
        assert output.err.count('\n') == 1 and 'Traceback' not in output.err

    def test_one_bad_file_among_others_fails_and_the_others_are_still_checked(self, write, capsys):
        bad, good = write(b'', 'bad.map'), write(CELL, 'good.map')
        assert main(['check', bad, good]) == 1
        assert capsys.readouterr().out == f'{good}: ok\n'

    def test_a_missing_file_is_told(self, capsys):
        assert main(['check', '/nowhere/a.map']) == 1
        assert capsys.readouterr().err == (
            'ld_map: /nowhere/a.map: it cannot be read (No such file or directory).\n')


class TestInfo:
    def test_counts_places_and_warnings(self, write, capsys):
        assert main(['info', write(room_bytes())]) == 0
        told = capsys.readouterr().out
        assert 'points      240, 50 mm apart\n' in told
        assert "  ForbiddenArea 'Keep out' at (2.281, 3.049) m, 3.000 x 1.000 m, 30 deg\n" in told
        assert "  DockLynx 'Dock' at (-0.800, -0.700) m, 90 deg\n" in told
        assert "  Goal 'Shelf A' at (0.000, 0.000) m\n" in told
        assert "  ForbiddenLine 'Line' from (0.500, -0.900) m to (0.500, 0.400) m\n" in told
        assert told.endswith('warnings    0\n')

    def test_each_scan_is_told_of(self, write, capsys):
        assert main(['info', write(TWO_SCANS)]) == 0
        assert 'scan        Low\npoints      2, 50 mm apart' in capsys.readouterr().out

    @pytest.mark.parametrize('command', [['info'], ['check'], ['diff', '{path}']])
    def test_passwords_and_hosts_are_never_printed(self, write, capsys, command):
        path = write(room_bytes())
        main([word.format(path=path) for word in command] + [path])
        output = capsys.readouterr()
        assert 'hush-hush' not in output.out + output.err
        assert 'robot.example' not in output.out + output.err


class TestExport:
    def test_image_and_description_hold_the_grid(self, write, tmp_path, capsys):
        out = str(tmp_path / 'grid.pgm')
        assert main(['export', write(room_bytes()), out, '--background', 'free']) == 0
        served = read_served_map(str(tmp_path / 'grid.yaml'))
        assert served.cells.shape == (41, 81) and set(np.unique(served.cells)) == {0, 100}
        assert capsys.readouterr().out == f'wrote {out}\nwrote {tmp_path / "grid.yaml"}\n'

    def test_options_reach_the_grid(self, write, tmp_path):
        out = str(tmp_path / 'grid.png')
        main(['export', write(room_bytes()), out, '--resolution', '100', '--areas', '--use',
              'both'])
        served = read_served_map(str(tmp_path / 'grid.yaml'))
        assert served.resolution == 0.1 and (served.cells == 100).sum() > 130

    def test_without_a_name_the_files_are_called_like_the_map_and_stand_here(
            self, write, tmp_path, monkeypatch):
        path = write(room_bytes())
        (tmp_path / 'here').mkdir()
        monkeypatch.chdir(tmp_path / 'here')
        assert main(['export', path]) == main(['draw', path]) == 0
        assert sorted(os.listdir('.')) == ['a.pgm', 'a.png', 'a.yaml']
        assert main(['export', path]) == main(['draw', path]) == 0, 'its own files are replaced'

    @pytest.mark.parametrize('command, arguments, of_the_user', [
        ('export', [], 'a.yaml'), ('export', [], 'a.pgm'), ('export', ['a.png'], 'a.yaml'),
        ('export', ['a.yaml'], 'a.pgm'), ('draw', [], 'a.png')])
    def test_a_file_of_the_user_stays_if_its_name_was_not_given(
            self, write, tmp_path, monkeypatch, capsys, command, arguments, of_the_user):
        path = write(room_bytes())
        (tmp_path / 'here').mkdir()
        monkeypatch.chdir(tmp_path / 'here')
        with open(of_the_user, 'w') as file:
            file.write('name: hall')
        assert main([command, path, *arguments]) == 1
        assert of_the_user in capsys.readouterr().err
        with open(of_the_user) as file:
            assert file.read() == 'name: hall'

    def test_a_file_whose_name_was_given_is_replaced(self, write, tmp_path, monkeypatch):
        path = write(room_bytes())
        monkeypatch.chdir(tmp_path)
        for name in ('b.pgm', 'c.png'):
            (tmp_path / name).write_text('old')
        assert main(['export', path, 'b.pgm']) == main(['draw', path, 'c.png']) == 0

    def test_a_map_without_a_pitch_needs_one(self, write, tmp_path, capsys):
        assert main(['export', write(TWO_SCANS), str(tmp_path / 'grid.png')]) == 1
        assert 'gives no pitch' in capsys.readouterr().err
        assert not (tmp_path / 'grid.png').exists()


class TestDiff:
    def test_equal_maps_differ_in_nothing(self, write, capsys):
        assert main(['diff', write(CELL), write(CELL, 'b.map')]) == 0
        assert capsys.readouterr().out == ''

    def test_every_kind_of_change_is_told(self, write, capsys):
        objects = (OBJECTS
                   .replace('Cairn: DockLynx -800 -700 90.000000 "" ICON "Dock"\n', '')
                   .replace('Goal 0 0 0.000000 "with, a comma"', 'GoalWithHeading 0 100 45.0 ""')
                   + 'Cairn: Goal 2900 0 0.000000 "" ICON "New"\n')
        new = room_bytes(objects).replace(b'\n3000 950\n', b'\n')
        assert main(['diff', write(room_bytes()), write(new, 'b.map')]) == 1
        assert capsys.readouterr().out.splitlines() == [
            "- DockLynx 'Dock' at (-0.800, -0.700) m, 90 deg",
            "+ Goal 'New' at (2.900, 0.000) m",
            "~ Goal 'Shelf A' at (0.000, 0.000) m: now GoalWithHeading 'Shelf A', "
            'moved to (0.000, 0.100) m, 45 deg, other description',
            '~ points: 0 added, 1 removed']


class TestDraw:
    def pixels(self, path: str) -> np.ndarray:
        return np.asarray(Image.open(path).convert('RGB')).astype(int)

    def test_every_kind_of_object_has_its_colour(self, write, tmp_path):
        out = str(tmp_path / 'a.png')
        assert main(['draw', write(room_bytes()), out, '--size', '800']) == 0
        image = self.pixels(out)
        assert max(image.shape) == 800
        red, green, blue = image[..., 0], image[..., 1], image[..., 2]
        for what, seen in (
                ('points, black', (red < 50) & (green < 50) & (blue < 50)),
                ('lines, red', (red > 150) & (green < 90) & (blue < 90)),
                ('goals, green', (green > 110) & (red < 60) & (blue < 100)),
                ('forbidden lines, orange', (red > 220) & (abs(green - 140) < 20) & (blue < 60)),
                ('sectors, violet', (abs(red - 125) < 25) & (green < 110) & (blue > 160))):
            assert seen.sum() > 20, f'the picture has no {what}'

    def test_a_square_stands_where_its_goal_is(self, write, tmp_path):
        out = str(tmp_path / 'a.png')
        main(['draw', write(room_bytes()), out, '--size', '500'])
        image = self.pixels(out)
        # The picture spans 5 m, 0.5 m around the room: 100 px per metre; "Shelf A" is at (0, 0).
        assert image.shape[:2] == (301, 500) or image.shape[:2] == (300, 500)
        assert image[150, 150].tolist() == [22, 150, 70]

    @pytest.mark.parametrize('x, heading', [(-1000, ''), (-1000, 'WithHeading'), (3000, '')])
    def test_a_name_leaves_its_square_free_at_every_edge(self, write, tmp_path, x, heading):
        name, out = 'Receiving dock 3, north gate', str(tmp_path / 'a.png')
        goal = f'Cairn: Goal{heading} {x} 0 0.000000 "" ICON "{name}"\n'
        main(['draw', write(room_bytes(objects=goal)), out, '--size', '1000'])
        image = self.pixels(out)
        column, row = round((x + 1500) / 5), 300  # 200 px per metre from (-1.5, 1.5) m
        square = image[row - 24:row + 24, column - 28:column + 24]
        red, green, blue = square[..., 0], square[..., 1], square[..., 2]
        assert ((green > 110) & (red < 60) & (blue < 100)).mean() > (0.5 if heading else 0.85)
        assert not ((red < 30) & (green > 70) & (green < 110)).any(), (
            'the name must be on the square')

    def test_names_in_any_script_are_no_obstacle(self, write, tmp_path, monkeypatch):
        monkeypatch.setattr('omron_map.canvas.FONTS', ())
        out = str(tmp_path / 'a.png')
        assert main(['draw', write(room_bytes()), out]) == 0
        assert os.path.getsize(out) > 1000

    def test_an_empty_map_is_told(self, write, tmp_path, capsys):
        assert main(['draw', write(b'2D-Map\nDATA\n'), str(tmp_path / 'a.png')]) == 1
        assert 'nothing in the map to draw' in capsys.readouterr().err


@pytest.mark.parametrize('arguments', [[], ['info'], ['draw', 'a', 'b', '--size', '0'], ['fly']])
def test_wrong_arguments_end_with_status_2(arguments, capsys):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2 and 'usage: ld_map' in capsys.readouterr().err


def test_a_reader_that_leaves_early_is_no_error(write):
    program = 'import sys; from omron_map.cli import main; sys.exit(main())'
    with subprocess.Popen([sys.executable, '-c', program, 'info', write(room_bytes())],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as ld_map:
        ld_map.stdout.close()
        assert ld_map.stderr.read() == ''
    assert ld_map.returncode == 0
