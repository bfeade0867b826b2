"""No text of the editor covers another."""
from __future__ import annotations

import math
from itertools import combinations
from typing import Dict, List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rviz_drawing.text_places import REACH, TextPlaces, VertexText
from trajectory_graph.placing import shared

ID, LABEL = ((0.25, 0.28), (0.3, 0.3)), ((1.6, 0.33), (0.0, -0.36))
coordinates = st.floats(-3.0, 3.0)
vertices = st.dictionaries(st.integers(1, 40), st.tuples(coordinates, coordinates), max_size=25)


def texts_of(places: Dict[int, tuple]) -> Dict[tuple, VertexText]:
    return {(kind, id): VertexText(place, *sizes) for kind, sizes in (('id', ID), ('label', LABEL))
            for id, place in places.items()}


def boxes(places: TextPlaces, texts: Dict[tuple, VertexText]) -> List[tuple]:
    shown = [(places.middle(key), text.size) for key, text in texts.items()]
    return [(x - width / 2.0, y - height / 2.0, x + width / 2.0, y + height / 2.0)
            for middle, (width, height) in shown if middle is not None
            for x, y in (middle,)]


@given(st.lists(vertices, min_size=1, max_size=4))
def test_texts_never_cover_each_other_however_the_graph_is_edited(edits):
    places = TextPlaces()
    for graph in edits:
        texts = texts_of(graph)
        places.show(texts)
        assert not any(shared(one, other)
                       for one, other in combinations(boxes(places, texts), 2))


@given(vertices)
def test_each_text_is_near_its_vertex(graph):
    places, texts = TextPlaces(), texts_of(graph)
    places.show(texts)
    for key, text in texts.items():
        middle = places.middle(key)
        if middle is not None:
            away = [max(abs(at - of) - size / 2.0, 0.0)
                    for at, of, size in zip(middle, text.vertex, text.size)]
            assert max(away) <= REACH


@given(vertices)
def test_edits_leave_nothing_behind(graph):
    places = TextPlaces()
    places.show(texts_of(graph))
    places.show({})
    alone = texts_of({1: (0.0, 0.0)})
    places.show(alone)
    assert [places.middle(key) for key in alone] == [(0.3, 0.3), (0.0, -0.36)]


def test_texts_of_vertices_a_metre_apart_are_all_written():
    places = TextPlaces()
    texts = texts_of({10 * x + y: (float(x), float(y)) for x in range(5) for y in range(5)})
    ids = {key: text for key, text in texts.items() if key[0] == 'id'}
    places.show(ids)
    assert len(boxes(places, ids)) == 25
    assert all(places.middle(key) == pytest.approx((text.vertex[0] + 0.3, text.vertex[1] + 0.3))
               for key, text in ids.items()), (
                   'the texts must be at their usual places, where there is room')


def test_the_first_text_keeps_its_place_and_the_other_moves():
    places, texts = TextPlaces(), texts_of({1: (0.0, 0.0), 2: (0.8, 0.0)})
    places.show(texts)
    assert places.middle(('label', 1)) == (0.0, -0.36)
    assert places.middle(('label', 2)) not in (None, (0.8, -0.36))


def test_a_text_goes_back_when_there_is_room_again():
    places = TextPlaces()
    places.show(texts_of({1: (0.0, 0.0), 2: (0.8, 0.0)}))
    places.show(texts_of({1: (-5.0, 0.0), 2: (0.8, 0.0)}))
    assert places.middle(('label', 2)) == (0.8, -0.36)


def test_what_is_written_elsewhere_stays_where_it_is():
    places = TextPlaces()
    graph = {id: (1.2 * id, 0.0) for id in range(1, 10)}
    places.show(texts_of(graph))
    before = {key: places.middle(key) for key in texts_of(graph) if key[1] > 3}
    places.show(texts_of({**graph, 1: (1.2, -4.0)}))
    moved = [key for key, middle in before.items()
             if math.dist(middle or (0.0, 0.0), places.middle(key) or (0.0, 0.0)) > 0.0]
    assert not [key for key in moved if key[0] == 'id']


def test_one_of_two_texts_without_room_is_not_written():
    places = TextPlaces()
    texts = {('id', id): VertexText((0.0, 0.0), (20.0, 20.0), (0.0, 0.0)) for id in range(12)}
    places.show(texts)
    assert len(boxes(places, texts)) < 12
    assert not any(shared(one, other) for one, other in combinations(boxes(places, texts), 2))
