"""Graph files: strict reading, and errors that name file, line and id."""
from __future__ import annotations

import pytest

from trajectory_graph import CurveType, GraphError, load_graph, save_graph

VERTICES = """\
Vertices:
- {FrameId: map/nn0, Id: 1, Label: pass, Theta: 0.0, ThetaHolomonic: 2.74, X: 0, Y: -3.86}
- {FrameId: map/nn0, Id: 2, Label: pass, Theta: 1.64, ThetaHolomonic: 2.74, X: 4.17, Y: -3.86}
"""
EDGE = ('- {CurveType: spline, Destination_ID: 2, Id: 3, Origin_ID: 1, ParamB: 0.25, '
        'ParamF: 0.25, VelocityBackwards: 0.3, VelocityForward: 0.3}\n')
GOOD = f'Edges:\n{EDGE}{VERTICES}'


@pytest.fixture
def refused(tmp_path):
    """Returns a function that loads a text as a graph file and returns the error message."""
    def load(text):
        file = tmp_path / 'graph.yaml'
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        with pytest.raises(GraphError) as caught:
            load_graph(file)
        assert str(caught.value).startswith(str(file))
        return str(caught.value)[len(str(file)):]
    return load


def test_a_file_of_the_editor_is_read(tmp_path):
    file = tmp_path / 'graph.yaml'
    file.write_text(GOOD)
    graph = load_graph(file)
    vertex, edge = graph.vertex(2), graph.edge(3)
    assert (vertex.x, vertex.y, vertex.theta, vertex.theta_holonomic) == (4.17, -3.86, 1.64, 2.74)
    assert (vertex.label, vertex.frame_id) == ('pass', 'map/nn0')
    assert (edge.origin, edge.destination, edge.curve_type) == (1, 2, CurveType.SPLINE)
    assert (edge.param_f, edge.velocity_backwards) == (0.25, 0.3)


def test_numbers_in_the_way_c_plus_plus_writes_them(tmp_path):
    file = tmp_path / 'graph.yaml'
    file.write_text(GOOD.replace('ParamB: 0.25', 'ParamB: 1e-05'))
    assert load_graph(file).edge(3).param_b == 1e-5


@pytest.mark.parametrize(('right', 'wrong'), [
    ('ParamB: 0.25', 'ParamB: 0_25'), ('ParamB: 0.25', 'ParamB: 1_5.0'), ('Id: 3', 'Id: 3_0')])
def test_a_number_with_an_underscore_is_no_other_number(tmp_path, right, wrong):
    file = tmp_path / 'graph.yaml'
    file.write_text(GOOD.replace(right, wrong))
    with pytest.raises(GraphError, match=f"{wrong.split()[1]}', but must be a"):
        load_graph(file)


def test_fields_we_do_not_know_are_left_alone(tmp_path):
    file = tmp_path / 'graph.yaml'
    file.write_text(GOOD.replace('Label: pass', 'Label: pass, Colour: {r: 1}'))
    assert len(load_graph(file).vertices) == 2


def test_fields_that_mean_nothing_may_be_missing(tmp_path):
    file = tmp_path / 'graph.yaml'
    file.write_text('Edges:\n- {CurveType: line, Destination_ID: 2, Id: 3, Origin_ID: 1, '
                    'VelocityBackwards: 0.3, VelocityForward: 0.3}\n'
                    'Vertices:\n- {Id: 1, Theta: 0.5, X: 0, Y: 0}\n'
                    '- {Id: 2, Theta: 0, X: 3, Y: 0}\n')
    graph = load_graph(file)
    vertex, edge = graph.vertex(1), graph.edge(3)
    assert (vertex.frame_id, vertex.label, vertex.theta_holonomic) == ('', '', vertex.theta)
    assert (edge.param_f, edge.param_b) == (0.0, 0.0)


def test_docks_and_parking_are_optional_and_the_label_dock_is_a_dock(tmp_path):
    file = tmp_path / 'graph.yaml'
    file.write_text(GOOD.replace('Id: 2, Label: pass', 'Id: 2, Label: dock, Parking: true'))
    plain, dock = load_graph(file).vertex(1), load_graph(file).vertex(2)
    assert (plain.dock, plain.parking, dock.dock, dock.parking) == (False, None, True, True)
    file.write_text(GOOD.replace('Id: 2, Label: pass', 'Id: 2, Label: dock, Dock: false'))
    assert not load_graph(file).vertex(2).dock


def test_a_graph_that_is_saved_and_read_again_is_the_same(tmp_path):
    file = tmp_path / 'graph.yaml'
    file.write_text(GOOD.replace('Id: 2, Label: pass', 'Id: 2, Label: "a: b", Dock: true'))
    graph = load_graph(file)
    save_graph(graph, tmp_path / 'again.yaml', 'a comment')
    again = load_graph(tmp_path / 'again.yaml')
    assert dict(again.vertices) == dict(graph.vertices)
    assert dict(again.edges) == dict(graph.edges)


@pytest.mark.parametrize('old, new, sentence', [
    ('Label: pass', 'Label: pass, Dock: maybe',
     ", line 4: vertex 1: Dock is 'maybe', but must be true or false."),
    ('Id: 2,', 'Id: 1,', ', line 5: vertex 1: the id is used twice, first in line 4.'),
    ('Id: 3,', 'Id: 0,', ', line 2: edge 0: an id must be positive.'),
    ('Id: 3,', 'Id: 3.5,', ", line 2: Id is '3.5', but must be a whole number."),
    ('Id: 3,', 'Id: 99999999999,', ', line 2: Id is 99999999999, but must fit in 32 bits.'),
    ('Id: 3,', 'Id: 3, Id: 4,', ', line 2: Id is given twice.'),
    ('X: 4.17', 'X: .nan', ', line 5: vertex 2: x is nan, not a number within 1000000.'),
    ('X: 4.17', 'X: [1]', ', line 5: vertex 2: X must be a number.'),
    ('X: 4.17', 'X: east', ", line 5: vertex 2: X is 'east', but must be a number."),
    (', X: 4.17', '', ', line 5: vertex 2: X is missing.'),
    ('Theta: 1.64, ThetaHolomonic: 2.74, X: 4.17, Y: -3.86', 'Colour: red',
     ', line 5: vertex 2: Theta, X and Y are missing.'),
    ('Id: 2, Label: pass, Theta: 1.64, ThetaHolomonic: 2.74, X: 4.17', 'Label: pass',
     ', line 5: Id, Theta and X are missing.'),
    ('Edges:\n' + EDGE + 'Vertices:', 'vertices:', ', line 1: Vertices and Edges are missing.'),
    ('X: 4.17', 'X: 4,17', ', line 5: an entry of Vertices has a number, 17, where'),
    ('VelocityForward: 0.3', 'VelocityForward: 0,8', ', line 2: an entry of Edges has a number, 8,'
     ' where the name of a field must be; write decimal numbers with a point.'),
    ('Label: pass, Theta: 1.64', 'Label: pass, transit, Theta: 1.64',
     ', line 5: a key has no value.'),
    ('Label: pass, Theta: 1.64', 'Label: , Theta: 1.64', ', line 5: Label has no value.'),
    ('Destination_ID: 2', 'Destination_ID: 8',
     ', line 2: edge 3: ends at vertex 8, which does not exist.'),
    ('Destination_ID: 2', 'Destination_ID: 1', ', line 2: edge 3: joins vertex 1 to itself.'),
    ('CurveType: spline', 'CurveType: clothoid',
     ", line 2: edge 3: CurveType is 'clothoid', but must be spline or line."),
    (', ParamF: 0.25', '', ', line 2: edge 3: ParamF is missing.'),
    (EDGE, '- 7\n', ', line 2: an entry of Edges must be a mapping of names to values.'),
    ('Edges:\n' + EDGE, 'Edges: 5\n', ', line 1: Edges must be a list.'),
    ('Edges:\n' + EDGE, '', ', line 1: Edges is missing.'),
    ('Edges:\n' + EDGE, 'Edges: []\n', ', line 3: vertex 1: cannot be reached: no edges touch it'),
    ('Edges:', 'Edges: [', ', line 2: this is not YAML'),
])
def test_what_is_wrong_is_named_with_its_line(refused, old, new, sentence):
    assert refused(GOOD.replace(old, new)).startswith(sentence)


@pytest.mark.parametrize('tag', ['!!python/object/apply:os.system', '!!binary', '!own'])
def test_no_tag_makes_an_object(refused, tag):
    message = refused(GOOD.replace('X: 4.17', f'X: {tag} "4"'))
    assert message == ', line 5: vertex 2: X must be a number.'


@pytest.mark.parametrize('content', [b'', b'\x00\x01', b'\xff\xfe\x00', b'a: 1\n---\nb: 2\n',
                                     b'[' * 100000, b'just text'])
def test_what_is_no_graph_at_all_is_one_sentence(refused, content):
    message = refused(content)
    assert message.endswith('.')
    assert '\n' not in message


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(GraphError, match=r'nothing\.yaml: the file cannot be read \(No such file'):
        load_graph(tmp_path / 'nothing.yaml')
