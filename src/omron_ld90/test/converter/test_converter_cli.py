import pytest
from converter_builders import LAB

from omron_ld90.graph.converter_cli import main
from omron_ld90.maps import MapDocument


def arguments(output, *more, graph=LAB / 'lab_graph.yaml', base_map=LAB / 'lab_base.map'):
    return ['--graph', str(graph), '--base-map', str(base_map), '--output', str(output), *more]


def test_a_map_is_made_and_told_of(tmp_path, capsys):
    output = tmp_path / 'out.map'
    assert main(arguments(output, '--dock-vertex', '16')) == 0
    told = capsys.readouterr()
    assert f'{output}: 24 goals, 5 of them with heading' in told.out
    assert 'dock 16: DockLynx at -13200 -7000 mm, facing its station at 180.0 degrees' in told.out
    assert told.err == ''


def test_the_dock_heading_may_be_given(tmp_path):
    output = tmp_path / 'out.map'
    assert main(arguments(output, '--dock-vertex', '16', '--dock-heading', '-90')) == 0
    assert MapDocument.load(str(output)).docks[0].theta == -90.0


@pytest.mark.parametrize('more, inputs, told', [
    (('--dock-vertex', '17'), {}, 'no vertex 17'),
    (('--dock-vertex', '4'), {}, 'dock vertex 4 has several edges'),
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
