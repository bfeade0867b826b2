from collections import Counter
from pathlib import Path

import pytest
from converter_builders import LAB, graph_of, lab_generator, map_with, real_maps
from hypothesis import given
from hypothesis import strategies as st

from omron_map import MapDocument, MapError, MapObject
from omron_map_converter.converter import (
    Conversion,
    ConversionError,
    ConversionOptions,
    ExistingGoals,
    check_output,
    convert,
    convert_file,
)
from omron_map_converter.corridors import CorridorRules, corridors_of
from omron_map_converter.fences import FENCE, Fences, is_fence
from trajectory_graph import load_graph

GRAPH = graph_of([(1, 0.0, 0.0), (2, 4.0, 0.0), (3, 8.0, 0.0)], [(1, 2), (2, 3)])
DOCKED = ConversionOptions(dock_vertex=3)


def did(added=()):
    """Returns the result of a conversion that added these objects and did nothing else."""
    return Conversion((), (), tuple(added), (), (), corridors_of(GRAPH, CorridorRules()))


def names(document):
    return [(obj.kind, obj.name) for obj in document.goals + document.docks]


def test_all_vertices_are_in_the_map():
    document = map_with()
    convert(GRAPH, document, DOCKED)
    assert names(document) == [('GoalWithHeading', '1'), ('Goal', '2'), ('DockLynx', '3')]


def test_without_a_dock_vertex_there_is_no_dock():
    document = map_with()
    convert(GRAPH, document, ConversionOptions())
    assert document.docks == ()
    assert len(document.goals) == 3


def test_converting_again_changes_nothing():
    document = map_with()
    convert(GRAPH, document, DOCKED)
    once = document.to_bytes()
    again = convert(GRAPH, document, DOCKED)
    assert document.to_bytes() == once
    assert (again.added, again.removed, len(again.places)) == ((), (), 3)


@pytest.mark.parametrize('existing, expected', [
    (ExistingGoals.REPLACE, [('GoalWithHeading', '1'), ('Goal', 'Pick'), ('Goal', '2'),
                             ('DockLynx', '3')]),
    (ExistingGoals.KEEP, [('GoalWithHeading', '1'), ('Goal', 'Pick'), ('Goal', '2'),
                          ('DockLynx', '3')]),
    (ExistingGoals.DROP, [('GoalWithHeading', '1'), ('Goal', '2'), ('DockLynx', '3')]),
])
def test_goals_of_the_base_map(existing, expected):
    document = map_with('Goal 900 0 0 "" ICON "Pick"', 'Goal 3900 50 0 "by hand" ICON "2"')
    convert(GRAPH, document, ConversionOptions(dock_vertex=3, existing_goals=existing))
    assert names(document) == expected
    moved = document.find('2')
    kept = existing is ExistingGoals.KEEP
    assert (moved.x, moved.description) == ((3900, 'by hand') if kept else (4000, ''))


def test_a_route_that_loses_its_goal_is_told():
    document = map_with('Goal 900 0 0 "" ICON "Pick"')
    notes = convert(GRAPH, document, ConversionOptions(existing_goals=ExistingGoals.DROP)).notes
    assert any("RouteInfo: names 'Pick'" in note for note in notes), notes


def test_a_replaced_goal_is_not_told_of_as_lost():
    graph = graph_of([(1, 0.0, 0.0), (2, 4.0, 0.0)], [(1, 2)])
    document = map_with('Goal 5 5 0 "" ICON "2"')
    data = document.to_bytes().replace(b'"Pick"', b'"2"')
    document = MapDocument.from_bytes(data)
    conversion = convert(graph, document, ConversionOptions())
    assert [obj.name for obj in conversion.removed] == ['2']
    assert conversion.notes == ()


def test_another_dock_is_told():
    document = map_with('DockLynx 0 0 90 "" ICON "Old dock"', 'Goal 9 9 0 "" ICON "Pick"')
    notes = convert(GRAPH, document, DOCKED).notes
    assert len(notes) == 1
    assert "'Old dock'" in notes[0]


def test_a_dock_type_that_the_map_does_not_declare_is_told():
    data = map_with('Goal 9 9 0 "" ICON "Pick"').to_bytes().replace(b'DockLynx', b'DockHD')
    notes = convert(GRAPH, MapDocument.from_bytes(data), DOCKED).notes
    assert any('DockLynx' in note for note in notes), notes


def test_a_name_that_another_object_has_is_refused():
    document = map_with('ForbiddenArea 0 0 0 "" ICON "2" 0 0 10 10')
    with pytest.raises(MapError, match="ForbiddenArea '2'"):
        convert(GRAPH, document, ConversionOptions())


def test_a_dock_vertex_that_is_not_there_is_refused():
    with pytest.raises(ConversionError, match='no vertex 9'):
        convert(GRAPH, map_with(), ConversionOptions(dock_vertex=9))


def test_the_generator_makes_the_committed_laboratory(tmp_path):
    lab_generator().main([str(tmp_path)])
    for name in ('lab_base.map', 'lab_graph.yaml'):
        assert (tmp_path / name).read_bytes() == (LAB / name).read_bytes(), name


def test_the_converter_makes_the_committed_laboratory_map(tmp_path):
    made = tmp_path / 'lab.map'
    conversion = convert_file(load_graph(str(LAB / 'lab_graph.yaml')), str(LAB / 'lab_base.map'),
                              str(made), ConversionOptions(dock_vertex=16))
    assert made.read_bytes() == (LAB / 'lab.map').read_bytes()
    assert conversion.notes == ()


def test_the_laboratory_has_24_goals_and_its_dock():
    document = MapDocument.load(str(LAB / 'lab.map'))
    assert sorted(int(goal.name) for goal in document.goals) == [
        1, 2, 4, 6, 8, 10, 12, 14, 18, 20, 22, 24, 26, 27, 32, 33, 35, 39, 40, 41, 42, 47, 49, 52]
    assert [dock.name for dock in document.docks] == ['16']
    assert document.warnings == ()


@pytest.mark.parametrize('path', real_maps())
def test_a_real_map_keeps_every_byte_but_the_new_lines(path, tmp_path):
    made = tmp_path / 'made.map'
    convert_file(GRAPH, str(path), str(made), ConversionOptions(dock_vertex=3, fences=Fences.NONE))
    left = path.read_bytes().split(b'\n')
    right = made.read_bytes().split(b'\n')
    new = [line for line in right if line.endswith((b'"" ICON "1"', b'ICON "2"', b'ICON "3"'))]
    assert len(new) == 3
    assert [line for line in right if line not in new] == left


def test_an_output_that_does_not_say_what_was_made_is_found(tmp_path):
    made = tmp_path / 'made.map'
    base = map_with('Goal 900 0 0 "" ICON "Pick"')
    made.write_bytes(base.to_bytes())
    with pytest.raises(ConversionError, match='objects read back'):
        check_output(base, did(added=[MapObject.goal('1', 0, 0)]), str(made))


def test_an_output_with_another_line_changed_is_found(tmp_path):
    made = tmp_path / 'made.map'
    base = map_with()
    made.write_bytes(base.to_bytes().replace(b'GoalAfter', b'GoalBefore'))
    with pytest.raises(ConversionError, match='lines of base.map'):
        check_output(base, did(), str(made))


def test_a_map_may_be_converted_in_place(tmp_path):
    file = tmp_path / 'site.map'
    file.write_bytes(map_with('Goal 900 0 0 "" ICON "Pick"').to_bytes())
    convert_file(GRAPH, str(file), str(file), DOCKED)
    assert len(MapDocument.load(str(file)).goals) == 3


def test_a_base_map_that_is_not_there_leaves_the_output_alone(tmp_path):
    output = tmp_path / 'made.map'
    output.write_text('precious')
    with pytest.raises(MapError, match='absent.map'):
        convert_file(GRAPH, str(tmp_path / 'absent.map'), str(output), DOCKED)
    assert output.read_text() == 'precious'
    assert [path.name for path in Path(tmp_path).iterdir()] == ['made.map']


def test_fences_are_replaced_and_other_areas_left_alone():
    theirs = 'ForbiddenArea 0 0 30.000000 "by hand" ICON "FA1" 3000 4000 5000 6000'
    stale = f'ForbiddenArea 0 0 0.000000 "{FENCE}" ICON "" 1000 900 1200 1100'
    document = map_with(stale, theirs)
    conversion = convert(GRAPH, document, ConversionOptions())
    assert [obj.extent.from_x for obj in conversion.removed] == [1000]
    assert f'Cairn: {theirs}\n'.encode() in document.to_bytes()
    assert Counter(filter(is_fence, document.objects)) == Counter(conversion.fences)


def test_fences_may_become_lines_or_nothing():
    document = map_with()
    convert(GRAPH, document, ConversionOptions(fences=Fences.AREAS))
    assert document.forbidden_areas
    convert(GRAPH, document, ConversionOptions(fences=Fences.LINES))
    assert not document.forbidden_areas
    assert all(map(is_fence, document.forbidden_lines)) and document.forbidden_lines
    convert(GRAPH, document, ConversionOptions(fences=Fences.NONE))
    assert not document.forbidden_lines


def test_a_goal_behind_the_fences_is_told():
    notes = convert(GRAPH, map_with('Goal 900 3000 0 "" ICON "Pick"'), ConversionOptions()).notes
    assert [note for note in notes if "'Pick' is outside the corridors" in note]


@pytest.mark.parametrize('home, told', [
    ('900 3000 0 "" ICON ""', True), ('0 0 0 "" ICON "" 800 2900 1000 3100', True),
    ('1000 0 0 "" ICON ""', False), ('0 0 0 "" ICON "" -500 -500 1500 3100', False)])
def test_a_place_to_start_at_behind_the_fences_is_told(home, told):
    notes = convert(GRAPH, map_with(f'RobotHome {home}'), ConversionOptions()).notes
    assert bool([note for note in notes if note.startswith('RobotHome at ')
                 and 'can drive to no goal' in note]) is told
    assert not convert(GRAPH, map_with('RobotHome 900 3000 0 "" ICON ""'),
                       ConversionOptions(fences=Fences.NONE)).notes


def test_an_edge_that_leads_through_a_wall_is_told():
    document = MapDocument.from_bytes(map_with().to_bytes() + b'2000 100\n')
    notes = convert(GRAPH, document, ConversionOptions()).notes
    assert any(note.startswith('Edge 1 leads past an obstacle at a distance of 100 mm near 2000 0')
               for note in notes), notes


def test_a_width_for_an_edge_that_is_not_there_is_refused():
    with pytest.raises(ConversionError, match='no edge 77'):
        convert(GRAPH, map_with(),
                ConversionOptions(corridors=CorridorRules(edge_widths={77: 900.0})))


@given(st.lists(st.tuples(st.integers(1, 6), st.integers(-9999, 9999), st.integers(-9999, 9999)),
                max_size=6, unique_by=lambda goal: goal[0]),
       st.sampled_from(list(ExistingGoals)))
def test_whatever_goals_there_are_each_vertex_has_exactly_one_place(goals, existing):
    document = map_with(*(f'Goal {x} {y} 0 "" ICON "{name}"' for name, x, y in goals))
    conversion = convert(GRAPH, document,
                         ConversionOptions(existing_goals=existing, fences=Fences.NONE))
    found = [obj.name for obj in document.goals]
    assert len(found) == len(set(found))
    assert {'1', '2', '3'} <= set(found)
    others = {str(name) for name, _, _ in goals} - {'1', '2', '3'}
    assert set(found) - {'1', '2', '3'} == (set() if existing is ExistingGoals.DROP else others)
    assert {obj.name for obj in conversion.places} == {'1', '2', '3'}
