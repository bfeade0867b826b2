"""The colours of stations, devices, machines and loads in RViz: the colours of the dark fleet page.
"""
from __future__ import annotations

from typing import Mapping

from std_msgs.msg import ColorRGBA

from fleet_core.supervision.looks import ResourceLook
from rviz_drawing import drawing

HEX_OF_LOOK: Mapping[ResourceLook, str] = {
    ResourceLook.PLACE: '#59bff2', ResourceLook.OPEN: '#40d966',
    ResourceLook.SHUT: '#f2b333', ResourceLook.TROUBLE: '#ff4033'}
HEX_OF_LOAD = '#d9994d'


def _paint(text: str) -> ColorRGBA:
    red, green, blue = (int(text[k:k + 2], 16) / 255.0 for k in (1, 3, 5))
    return drawing.colour(red, green, blue)


PAINTS: Mapping[ResourceLook, ColorRGBA] = {
    look: _paint(text) for look, text in HEX_OF_LOOK.items()}
LOAD = _paint(HEX_OF_LOAD)
