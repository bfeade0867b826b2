"""Editing a graph file changes only the bytes of the edited parts."""
from __future__ import annotations

import pytest
from graph_edits import EDIT_LISTS, edited
from hypothesis import given

from trajectory_graph import editing, load_graph
from trajectory_graph.errors import GraphError
from trajectory_graph.yaml_editing import GraphFile

FLOW = """\
# Graph of the hall -- do not lose this comment
Fleet: {name: hall, colour: [1, 2]}   # a key that no program here knows
Edges:
# the long one
- {CurveType: line, Destination_ID: 2, Id: 1, Origin_ID: 1, ParamB: 0.25, ParamF: 0.25, VelocityBackwards: 0.3, VelocityForward: 1.0, Zone: A}  # main lane
- {Id: 2, CurveType: spline, Origin_ID: 2,   Destination_ID: 3, ParamB: 1.50, ParamF: 1.50,
   VelocityBackwards: 0.30, VelocityForward: .5}

# a gap, and another
- {CurveType: line, Destination_ID: 1, Id: 3, Origin_ID: 3, ParamB: 0.25, ParamF: 0.25, VelocityBackwards: 0.3, VelocityForward: 1.0}
Vertices:
- {FrameId: map/nn0, Id: 1, Label: 'pass', Theta: 0, ThetaHolomonic: 0.0, X: 0.00, Y: 0.00}   # start
- {FrameId: map/nn0, Id: 2, Label: pass, Theta: 0.0, ThetaHolomonic: 0.0, X: 8.0, Y: 0.0, Colour: red}
- {FrameId: map/nn0, Id: 3, Label: dock, Theta: 1.57, ThetaHolomonic: 0.0, X: 10.0, Y: 3.0}
"""  # noqa: E501
BLOCK = """\
Vertices:
  - Id: 1   # first
    FrameId: 'm'
    Label: "a b"
    Theta: 0.0
    ThetaHolomonic: 0.0
    X: 1.0
    Y: 1.0
    Dock: false

  # the second
  - Id: 2
    FrameId: m
    Label: dock
    Dock: true
    Theta: 0.0
    ThetaHolomonic: 0.0
    X: 3.0
    Y: 1.0
    Extra: {deep: [1, 2]}
  -
    Id: 3
    FrameId: m
    Label: third
    Parking: true
    Theta: 0.0
    ThetaHolomonic: 0.0
    X: 3.0
    Y: 5.0
Edges:
  - Id: 7
    CurveType: line
    Origin_ID: 1
    Destination_ID: 2
    ParamF: 0.25
    ParamB: 0.25
    VelocityForward: 1.0
    VelocityBackwards: 0.0
  - {Id: 8, CurveType: line, Origin_ID: 2, Destination_ID: 3, ParamF: 0.25, ParamB: 0.25, VelocityForward: 1.0, VelocityBackwards: 0.0}
Tail: yes # the end"""  # noqa: E501
LAYOUTS = [FLOW, BLOCK, FLOW.replace('\n', '\r\n'), '\ufeff' + BLOCK]


@pytest.mark.parametrize('text', LAYOUTS)
def test_a_file_that_was_not_edited_is_the_same_file(text):
    file = GraphFile(text, 'hall.yaml')
    assert file.edited(file.draft).text == text


def test_only_the_value_that_changed_is_written():
    file = GraphFile(FLOW, 'hall.yaml')
    after = file.edited(editing.move_vertex(file.draft, 2, 8.5, 0.0)).text
    assert after == FLOW.replace('X: 8.0', 'X: 8.5')


def test_a_key_that_was_not_there_is_added_to_its_record():
    file = GraphFile(FLOW, 'hall.yaml')
    after = file.edited(editing.change_vertex(file.draft, 2, parking=True, dock=True)).text
    assert after == FLOW.replace('Colour: red}', 'Colour: red, Dock: true, Parking: true}')


def test_a_key_that_says_nothing_any_more_is_taken_out():
    file = GraphFile(BLOCK, 'hall.yaml')
    after = file.edited(editing.change_vertex(file.draft, 3, parking=None)).text
    assert after == BLOCK.replace('    Parking: true\n', '')


def test_a_deleted_record_goes_with_its_lines_only():
    file = GraphFile(FLOW, 'hall.yaml')
    after = file.edited(editing.delete_edge(file.draft, 2)).text
    lines = FLOW.splitlines(True)
    assert after == ''.join(lines[:5] + lines[7:])


@pytest.mark.parametrize('text', LAYOUTS)
def test_a_new_record_looks_like_the_one_before(text):
    file = GraphFile(text, 'hall.yaml')
    draft, id = editing.add_vertex(file.draft, 5.0, 5.0, label='new')
    draft, edge = editing.connect(draft, 1, id)
    after = file.edited(draft)
    assert after.draft == draft
    added = [line for line in after.text.splitlines(True) if line not in text.splitlines(True)]
    assert all(line in after.text for line in text.splitlines(True))
    if 'hall' in text:
        assert len(added) == 2 and all(line.startswith('- {') for line in added)
        assert all(line.endswith('\r\n') for line in added) == ('\r\n' in text)


def test_the_label_dock_that_made_a_dock_may_change():
    file = GraphFile(FLOW, 'hall.yaml')
    after = file.edited(editing.change_vertex(file.draft, 3, label='charger'))
    assert after.draft.vertices[3].dock
    assert 'Label: charger' in after.text and 'Dock: true' in after.text


def test_a_graph_that_the_loader_refuses_is_not_written():
    file = GraphFile(FLOW, 'hall.yaml')
    draft, _ = editing.add_vertex(file.draft, 5.0, 5.0)
    with pytest.raises(GraphError, match='cannot be reached'):
        file.edited(draft)


def test_records_in_brackets_and_empty_lists_are_written_anew():
    text = ('Edges: []\nVertices: [{FrameId: m, Id: 1, Label: a, Theta: 0.0, ThetaHolomonic: 0.0, '
            'X: 0.0, Y: 0.0}]\n')
    file = GraphFile(text, 'one.yaml')
    draft, id = editing.add_vertex(file.draft, 2.0, 0.0)
    draft, _ = editing.connect(draft, 1, id)
    assert file.edited(draft).draft == draft


def test_an_anchor_is_refused_rather_than_spoilt():
    text = FLOW.replace('X: 8.0', 'X: &far 8.0').replace('X: 10.0', 'X: *far')
    file = GraphFile(text, 'hall.yaml')
    with pytest.raises(GraphError, match='anchors'):
        file.edited(editing.move_vertex(file.draft, 2, 8.5, 0.0))


def test_a_saved_file_is_loaded_again(tmp_path):
    path = tmp_path / 'hall.yaml'
    path.write_text(FLOW, encoding='utf-8')
    file = GraphFile.load(path)
    file.edited(editing.move_vertex(file.draft, 1, 0.5, 0.0)).save(path)
    assert load_graph(path).vertices[1].x == 0.5
    assert [entry.name for entry in tmp_path.iterdir()] == ['hall.yaml']


@pytest.mark.parametrize('text', LAYOUTS)
@given(edits=EDIT_LISTS)
def test_records_that_were_not_touched_keep_their_lines(text, edits):
    file = GraphFile(text, 'hall.yaml')
    draft = file.draft
    for edit in edits:
        draft = edited(draft, edit)
    try:
        draft.graph()
    except GraphError:
        with pytest.raises(GraphError):
            file.edited(draft)
        return
    after = file.edited(draft)
    assert after.draft == draft
    assert after.edited(file.draft).draft == file.draft
    changed = {('vertex', id) for id, old in file.draft.vertices.items()
               if draft.vertices.get(id) != old}
    changed |= {('edge', id) for id, old in file.draft.edges.items() if draft.edges.get(id) != old}
    if 'hall' in text:
        lines = text.splitlines(True)
        for kind, id, start, end in (('edge', 1, 4, 5), ('edge', 2, 5, 7), ('edge', 3, 9, 10),
                                     ('vertex', 1, 11, 12), ('vertex', 2, 12, 13)):
            if (kind, id) not in changed:
                assert ''.join(lines[start:end]) in after.text
    for comment in ('# Graph of the hall -- do not lose this comment', '# the long one',
                    '# a gap, and another', '# the second', '# the end'):
        assert (comment in text) == (comment in after.text)
