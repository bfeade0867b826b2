"""The robot's body as markers, made from its URDF.

RViz's RobotModel uses the last known transform, however old it is. So it would still show a robot
that has gone. Markers with a lifetime disappear. This module parses the few shapes itself, because
urdf_parser_py is part of Noetic, but not of Debian 12.
"""
from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import Dict, List, Optional, Tuple

from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from rviz_drawing import drawing

PLAIN = drawing.colour(0.6, 0.6, 0.6)  # colour of shapes without a material


def body_markers(urdf: str) -> List[Marker]:
    """Returns a marker for each `visual` of the URDF, in the frame of its link: it moves with TF.

    Only boxes and cylinders are drawn, and only if they are not rotated in their link. Raises
    ParseError, KeyError or ValueError if `urdf` is not XML, or lacks a dimension.
    """
    robot = ElementTree.fromstring(urdf)
    paints = {material.get('name', ''): ColorRGBA(*_numbers(colour.attrib['rgba']))
              for material in robot.findall('material') for colour in material.findall('color')}
    markers: List[Marker] = []
    for link in robot.findall('link'):
        for visual in link.findall('visual'):
            marker = _marker(link.get('name', ''), visual, paints, len(markers))
            if marker is not None:
                markers.append(marker)
    return markers


def _marker(frame: str, visual: ElementTree.Element, paints: Dict[str, ColorRGBA],
            number: int) -> Optional[Marker]:
    origin, box, cylinder = (visual.find(path) for path in
                             ('origin', 'geometry/box', 'geometry/cylinder'))
    if origin is not None and any(_numbers(origin.get('rpy', '0 0 0'))):
        return None
    if box is not None:
        kind, size = Marker.CUBE, _triple(box.attrib['size'])
    elif cylinder is not None:
        width = 2.0 * float(cylinder.attrib['radius'])
        kind, size = Marker.CYLINDER, (width, width, float(cylinder.attrib['length']))
    else:
        return None
    material = visual.find('material')
    paint = PLAIN if material is None else paints.get(material.get('name', ''), PLAIN)
    marker = drawing.shape(kind, 'body', number, paint, size, frame=frame)
    if origin is not None:
        marker.pose.position = Point(*_triple(origin.get('xyz', '0 0 0')))
    marker.frame_locked = True
    return marker


def _triple(text: str) -> Tuple[float, float, float]:
    x, y, z = _numbers(text)
    return x, y, z


def _numbers(text: str) -> Tuple[float, ...]:
    return tuple(float(word) for word in text.split())
