"""The work file of path_supervisor, which is read at the start and with each new graph."""
from __future__ import annotations

from typing import Optional, Set

import rospy

from fleet_core.files.errors import FileError
from fleet_core.files.work_file import load_work
from fleet_core.fleet import Fleet
from fleet_core.supervision.load_places import too_near
from fleet_core.work.site_work import SiteWork
from node_lifecycle import parameter
from trajectory_graph import Graph


class WorkFile:
    """Reads the file that ~work_file names.

    fleet   -- the robots that carry the loads
    trouble -- a clause that says why the file cannot be used; empty if it can be used
    """

    def __init__(self, fleet: Fleet) -> None:
        self._fleet = fleet
        self._path: str = parameter('~work_file', '')
        self.trouble = ''
        self._warned: Set[str] = set()

    def read(self, graph: Graph) -> Optional[SiteWork]:
        """Reads the work file for the site of a graph; returns its content, or None if it is wrong.

        Warns of places where a robot would keep other robots from their loads.

        Without the site's devices and stations robots must not drive. So the node reads a wrong
        file again and again, until a person has corrected it.
        """
        if not self._path:
            return SiteWork()
        try:
            work = load_work(self._path, graph, self._fleet)
        except FileError as error:
            trouble = str(error).rstrip('.')
            if trouble != self.trouble:
                rospy.logerr('%s. The fleet manager does not begin before the file is mended; it '
                             'is read again every few seconds.', trouble)
            self.trouble = trouble
            return None
        self.trouble = ''
        told, self._warned = self._warned, {one.text for one in too_near(work, self._fleet, graph)}
        for text in sorted(self._warned - told):
            rospy.logwarn('%s: %s.', self._path, text)
        return work
