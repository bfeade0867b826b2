"""Labels of robots that meet stay readable."""
from __future__ import annotations

import itertools
import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rviz_drawing.label_places import Label, LabelPlaces
from trajectory_graph.placing import Places

HEIGHT = 0.38
LETTER = 0.5 * HEIGHT ** 2  # m2


def label(x, y, words='agv_1  100 %\nto 49\n(ld90_1)'):
    return Label(x, y, 0.4, words, HEIGHT)


def rectangles(places, labels):
    """Yields the west, south, east and north edge of each label."""
    for name, one in labels.items():
        middle, half = np.array(one.middle(places.side(name))), np.array(one.size) / 2.0
        yield (*(middle - half), *(middle + half))


def covered(one, other):
    """Returns the area (m2) that two rectangles share."""
    width = min(one[2], other[2]) - max(one[0], other[0])
    height = min(one[3], other[3]) - max(one[1], other[1])
    return max(width, 0.0) * max(height, 0.0)


def covered_in_all(places, labels):
    return sum(covered(*pair) for pair in itertools.combinations(rectangles(places, labels), 2))


def chosen(labels):
    places = LabelPlaces()
    places.choose(labels)
    return places


def test_a_robot_alone_has_its_label_above():
    assert chosen({'a': label(3.0, 2.0)}).side('a') == 0
    x, y = label(3.0, 2.0).middle(0)
    assert x == 3.0 and y > 2.4 + label(0.0, 0.0).size[1] / 2.0


def test_nothing_to_place_is_fine():
    assert chosen({}).side('nobody') == 0


def test_of_four_robots_at_a_crossing_all_labels_can_be_read():
    labels = {name: label(x, y) for name, (x, y) in zip('abcd', (
        (-1.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, -1.0)))}
    assert covered_in_all(chosen(labels), labels) < LETTER


def test_no_label_stands_on_another_robot():
    labels = {'a': label(0.0, 0.0), 'b': label(0.0, 1.3)}
    places = chosen(labels)
    above = next(rectangles(places, labels))
    assert covered(above, (-0.4, 0.9, 0.4, 1.7)) < LETTER


def test_a_label_keeps_its_side_while_nothing_is_gained():
    places = LabelPlaces()
    places.choose({'a': label(0.0, 0.0), 'b': label(1.0, 0.0)})
    sides = places.side('a'), places.side('b')
    for step in range(20):  # the robot drives a little further each time
        places.choose({'a': label(0.0, 0.01 * step), 'b': label(1.0, 0.0)})
        assert (places.side('a'), places.side('b')) == sides


def test_a_label_stays_in_what_people_see():
    labels = {'a': label(0.0, 0.0)}
    places = LabelPlaces()
    places.choose(labels, (-0.5, -4.0, 4.0, 4.0))
    left, _, right, _ = next(rectangles(places, labels))
    assert -0.5 <= left < right <= 4.0


def test_a_label_covers_no_name_while_another_side_is_free():
    labels = {'a': label(0.0, 0.0)}
    places = LabelPlaces()
    places.choose(labels, names=[(-1.0, 0.5, 1.0, 1.0)])
    assert places.side('a') == 1
    names = [(-9.0, -9.0, 9.0, 9.0)]
    places.choose(labels, names=names, buttons=[(-9.0, -9.0, 9.0, 0.0)])
    assert places.side('a') == 0


def test_a_label_rather_lies_on_an_edge_than_on_a_name():
    labels, edges = {'a': label(0.0, 0.0)}, Places()
    for step in range(-12, 13):  # one edge crosses the robot from below, one from left to right
        for box in ((-0.15, 0.3 * step, 0.15, 0.3 * step + 0.3),
                    (0.3 * step, -0.15, 0.3 * step + 0.3, 0.15)):
            edges.cover(box, is_soft=True)
    places = LabelPlaces()
    names = (-0.5, 0.45, 0.5, 2.0), (-0.5, -2.0, 0.5, -0.45), (0.45, -0.3, 2.0, 0.3)
    places.choose(labels, names=names, beneath=edges)
    assert places.side('a') == 3, 'to the left, over the edge'


@given(st.floats(-math.pi, math.pi), st.floats(0.85, 6.0))
def test_two_labels_never_cover_each_other_wherever_the_robots_are(angle, distance):
    labels = {'a': label(0.0, 0.0),
              'b': label(distance * math.cos(angle), distance * math.sin(angle), 'ld90_2\nidle')}
    assert covered_in_all(chosen(labels), labels) < LETTER
