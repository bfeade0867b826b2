"""The body of the shipped URDF as markers, and errors in a URDF."""
from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from visualization_msgs.msg import Marker

from omron_ld90.nodes.rviz.body_markers import PLAIN, body_markers

URDF = (Path(__file__).resolve().parents[3] / 'urdf/ld90.urdf').read_text()


def link(visual: str) -> str:
    return f'<robot name="r"><link name="r/base_link"><visual>{visual}</visual></link></robot>'


def test_every_visual_of_the_shipped_body_is_drawn_in_the_frame_of_its_link():
    markers = body_markers(URDF)
    links = [link.get('name') for link in ElementTree.fromstring(URDF).iter('link')
             for _ in link.findall('visual')]
    assert [marker.header.frame_id for marker in markers] == links
    assert all(marker.frame_locked for marker in markers)


def test_the_drawn_body_has_the_length_of_an_ld90():
    boxes = [marker for marker in body_markers(URDF) if marker.type == Marker.CUBE]
    front = max(box.pose.position.x + box.scale.x / 2 for box in boxes)
    rear = min(box.pose.position.x - box.scale.x / 2 for box in boxes)
    assert front - rear == pytest.approx(0.699)


def test_no_two_markers_take_each_others_place():
    markers = body_markers(URDF)
    assert len({(marker.ns, marker.id) for marker in markers}) == len(markers)


def test_a_cylinder_is_as_wide_as_twice_its_radius_and_plain_without_a_material():
    (marker,) = body_markers(
        link('<geometry><cylinder radius="0.1" length="0.05"/></geometry>'))
    assert (marker.scale.x, marker.scale.y, marker.scale.z) == (0.2, 0.2, 0.05)
    assert marker.color == PLAIN


@pytest.mark.parametrize('visual', [
    '<geometry><sphere radius="0.1"/></geometry>',
    '<origin rpy="0 0 1"/><geometry><box size="1 1 1"/></geometry>',
])
def test_what_cannot_be_drawn_right_is_left_out(visual):
    assert body_markers(link(visual)) == []


@pytest.mark.parametrize('urdf, error', [
    ('<robot', ElementTree.ParseError),
    (link('<geometry><box/></geometry>'), KeyError),
    (link('<geometry><box size="1 1 wide"/></geometry>'), ValueError),
])
def test_a_wrong_urdf_is_refused(urdf, error):
    with pytest.raises(error):
        body_markers(urdf)
