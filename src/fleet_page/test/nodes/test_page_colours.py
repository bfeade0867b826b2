"""The page and RViz have the same colours."""
import re

from page_builders import PAGE_FOLDER

from fleet_core.supervision.looks import ResourceLook
from graph_fleet_manager.nodes.rviz.paints import HEX_OF_LOAD, HEX_OF_LOOK


def test_the_dark_page_has_the_colours_of_rviz():
    style = (PAGE_FOLDER / 'page.css').read_text(encoding='utf-8')
    dark = re.search(r'data-theme=dark\] \{(.*?)\}', style, re.DOTALL).group(1)
    colours = dict(re.findall(r'--([\w-]+): (#\w+)', dark))
    assert {look: colours[look.name.lower()] for look in ResourceLook} == HEX_OF_LOOK
    assert colours['load'] == HEX_OF_LOAD
