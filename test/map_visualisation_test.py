#!/usr/bin/env python3
"""The displayed map: each subscriber gets the whole map at any time, and the map follows changes of
its file.
"""
from __future__ import annotations

import math
import os
import shutil
import tempfile
import time
import unittest
from pathlib import Path
from typing import List

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap, LoadMap, LoadMapResponse
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import PointCloud2
from sensor_msgs.point_cloud2 import create_cloud_xyz32
from std_msgs.msg import Header, String
from visualization_msgs.msg import Marker, MarkerArray

from omron_map import MapDocument, MapObject, RotatedRectangle
from system_support import Recorder, connected_publisher, run_cases, wait_until

ROBOT = '/omron_ld90'

# A room of 2.0 x 1.0 m from (-1, -0.5): its corners and one more point; the resolution is 100 mm.
ROOM = b"""2D-Map
MinPos: -1000 -500
MaxPos: 1000 500
NumPoints: 5
PointsAreSorted: true
Resolution: 100
LineMinPos: -1000 -500
LineMaxPos: 1000 -500
NumLines: 1
LinesAreSorted: true
LINES
-1000 -500 1000 -500
DATA
-1000 -500
-1000 500
0 -500
1000 -500
1000 500
"""


def room(*objects: MapObject) -> MapDocument:
    document = MapDocument.from_bytes(ROOM, 'the room')
    for obj in objects:
        document.add(obj)
    return document


def latched(topic: str, message_type: type):
    """Returns the message that a new subscriber gets on a latched topic."""
    return rospy.wait_for_message(f'{ROBOT}/{topic}', message_type, timeout=15.0)


def drawn(array: MarkerArray) -> List[Marker]:
    """Returns the markers of an array, which must begin with DELETEALL."""
    assert array.markers[0].action == Marker.DELETEALL, 'the array does not begin with DELETEALL'
    assert all(marker.action == Marker.ADD for marker in array.markers[1:])
    return array.markers[1:]


class MapVisualisationTest(unittest.TestCase):
    """One node shows one file. Each test begins with the room and the test's own objects."""

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('map_visualisation_test')
        cls.map_file = rospy.get_param(f'{ROBOT}/map_visualisation/map_file')
        cls.lab = str(Path(__file__).resolve().parents[1] / 'maps' / 'lab.map')
        cls.files = Recorder(f'{ROBOT}/map_file', String)
        cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)

    @classmethod
    def tearDownClass(cls) -> None:
        os.unlink(cls.map_file)

    def show(self, document: MapDocument) -> None:
        """Overwrites the displayed file. Waits until the node has shown it again."""
        shown = len(self.files.messages)
        document.save(self.map_file)
        self.files.wait_for(lambda message: message.data == self.map_file, 20.0, 'reload', shown)

    def told(self, words: str) -> None:
        self.diagnostics.wait_for(
            lambda array: any('map_visualisation' in status.name and words in status.message
                              for status in array.status),
            15.0, f'{words!r} from map_visualisation', after=len(self.diagnostics.messages))

    def test_a_late_joiner_gets_every_marker_as_the_contract_types_it(self):
        self.show(room(
            MapObject.goal('Shelf', 500, 0), MapObject.goal('Door', -500, 200, heading=90),
            MapObject.dock('Station', -800, -300, heading=180),
            MapObject.forbidden_area(RotatedRectangle(200, 100, 400, 200, 30), 'Keep out'),
            MapObject.forbidden_line(0, 0, 300, 400)))
        expected = {
            'points': (Marker.POINTS, 5, (0.0, 0.0, 0.0)),
            'lines': (Marker.LINE_LIST, 2, (0.05, 0.06, 0.08)),
            'goals': (Marker.CUBE_LIST, 2, (0.0, 0.7, 0.15)),
            'docks': (Marker.CUBE_LIST, 1, (0.0, 0.7, 0.15))}
        for topic, (kind, count, colour) in expected.items():
            marker = latched(f'map_markers/{topic}', Marker)
            self.assertEqual((kind, count, 'map'),
                             (marker.type, len(marker.points), marker.header.frame_id), topic)
            seen = (marker.color.r, marker.color.g, marker.color.b)
            self.assertEqual(colour, tuple(round(part, 2) for part in seen), f'colour of {topic}')
        corner = latched('map_markers/points', Marker).points[0]
        self.assertEqual((-1.0, -0.5), (corner.x, corner.y))

        names = {marker.text: marker for marker in
                 drawn(latched('map_markers/goal_names', MarkerArray))}
        self.assertEqual({'Shelf', 'Door', 'Station'}, set(names))
        self.assertGreater(names['Shelf'].pose.position.x, 0.5, 'the name is right of its goal')
        self.assertEqual(1.0, names['Shelf'].color.r)

        arrows = drawn(latched('map_markers/goal_headings', MarkerArray))
        self.assertEqual([Marker.ARROW] * 2, [arrow.type for arrow in arrows])
        self.assertAlmostEqual(math.sin(math.radians(45)), arrows[0].pose.orientation.z, 5)

        box, line = drawn(latched('map_markers/forbidden_areas', MarkerArray))
        self.assertEqual(Marker.CUBE, box.type)
        self.assertAlmostEqual(0.2, box.pose.position.x, 2)
        self.assertAlmostEqual(0.1, box.pose.position.y, 2)
        self.assertAlmostEqual(math.sin(math.radians(15)), box.pose.orientation.z, 5)
        self.assertAlmostEqual(0.4, box.scale.x, 2)
        self.assertEqual(2, len(line.points))

    def test_the_grid_is_on_its_topics_and_in_its_service(self):
        self.show(room())
        grid = latched('map', OccupancyGrid)
        self.assertEqual((21, 11), (grid.info.width, grid.info.height))
        self.assertEqual((-1.0, -0.5), (grid.info.origin.position.x, grid.info.origin.position.y))
        self.assertEqual({-1, 100}, set(grid.data))
        occupied = [index for index, cell in enumerate(grid.data) if cell == 100]
        self.assertEqual([0, 10, 20, 210, 230], occupied)
        self.assertEqual(grid.info, latched('map_metadata', MapMetaData))
        rospy.wait_for_service(f'{ROBOT}/static_map', 15.0)
        served = rospy.ServiceProxy(f'{ROBOT}/static_map', GetMap)().map
        self.assertEqual((grid.info, grid.data), (served.info, served.data))

    def test_what_was_removed_from_the_file_goes_from_the_picture(self):
        self.show(room(MapObject.goal('Here', 0, 0), MapObject.dock('Station', 100, 0, 0)))
        self.show(room())
        self.assertEqual(Marker.DELETE, latched('map_markers/goals', Marker).action)
        self.assertEqual(Marker.DELETE, latched('map_markers/docks', Marker).action)
        self.assertEqual([], drawn(latched('map_markers/goal_names', MarkerArray)))

    def test_a_bad_new_file_leaves_the_old_map_up_and_says_why(self):
        self.show(room(MapObject.goal('Kept', 0, 0)))
        with open(self.map_file, 'wb') as file:
            file.write(ROOM.replace(b'\n0 -500\n', b'\n0 x\n'))
        self.told('line 16')
        self.assertEqual(1, len(latched('map_markers/goals', Marker).points))
        self.show(room(MapObject.goal('A', 0, 0), MapObject.goal('B', 0, 100)))
        self.assertEqual(2, len(latched('map_markers/goals', Marker).points))
        self.told('Showing')

    def test_change_map_shows_another_file_and_refuses_a_bad_one(self):
        self.show(room())
        other = self.map_file.replace('.map', '_other.map')
        self.addCleanup(os.unlink, other)
        room(MapObject.goal('Other', 0, 0)).save(other)
        rospy.wait_for_service(f'{ROBOT}/change_map', 15.0)
        change_map = rospy.ServiceProxy(f'{ROBOT}/change_map', LoadMap)

        shown = len(self.files.messages)
        answer = change_map(f'file://{other}')
        self.assertEqual(LoadMapResponse.RESULT_SUCCESS, answer.result)
        self.assertEqual(21 * 11, len(answer.map.data))
        self.files.wait_for(lambda message: message.data == other, 10.0, 'other file', shown)
        self.assertEqual(1, len(latched('map_markers/goals', Marker).points))

        self.assertEqual(LoadMapResponse.RESULT_MAP_DOES_NOT_EXIST,
                         change_map('/nowhere/no.map').result)
        self.assertEqual(LoadMapResponse.RESULT_INVALID_MAP_DATA, change_map(__file__).result)
        self.assertEqual(other, self.files.messages[-1].data, 'the good map stays up')
        self.assertEqual(LoadMapResponse.RESULT_SUCCESS, change_map(self.map_file).result)

    def test_change_map_waits_for_nothing_and_tells_nothing_of_another_file(self):
        self.show(room())
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        secret, pipe = os.path.join(folder, 'secret'), os.path.join(folder, 'pipe')
        with open(secret, 'w', encoding='utf-8') as file:
            file.write('hunter2')
        os.mkfifo(pipe)
        log = Recorder('/rosout', Log)
        wait_until(log.is_connected, 15.0, 'connection to /rosout')
        change_map = rospy.ServiceProxy(f'{ROBOT}/change_map', LoadMap)
        for path, words in ((secret, 'not a map'), (pipe, 'a pipe'), ('/dev/zero', 'a device'),
                            (folder, 'a folder'), (f'{folder}/a\0b', 'no file can have')):
            self.assertNotEqual(LoadMapResponse.RESULT_SUCCESS, change_map(path).result, path)
            log.wait_for(lambda entry, words=words: words in entry.msg, 15.0, f'{words!r} logged')
        self.assertFalse([entry.msg for entry in log.messages if 'hunter' in entry.msg])
        self.assertEqual(21, rospy.ServiceProxy(f'{ROBOT}/static_map', GetMap)().map.info.width)

    def test_a_map_that_is_waited_for_keeps_nobody_waiting(self):
        rospy.wait_for_service('/waiting/static_map', 15.0)
        begin = time.monotonic()
        with self.assertRaisesRegex(rospy.ServiceException, 'was not loaded yet'):
            rospy.ServiceProxy('/waiting/static_map', GetMap)()
        self.assertEqual(LoadMapResponse.RESULT_SUCCESS,
                         rospy.ServiceProxy('/waiting/change_map', LoadMap)(self.lab).result)
        self.assertLess(time.monotonic() - begin, 15.0, 'the wait for the map is 30 s')

    def test_the_laser_is_drawn_while_it_is_fresh(self):
        lasers = Recorder(f'{ROBOT}/laser_markers', Marker)
        publisher = connected_publisher(f'{ROBOT}/laser_cloud', PointCloud2)
        header = Header(stamp=rospy.Time.now(), frame_id='map')
        publisher.publish(PointCloud2(header=header, width=1000, height=1))  # not a valid cloud
        publisher.publish(create_cloud_xyz32(header, [(1.5, -0.25, 0.2), (0.0, 2.0, 0.2)]))
        marker = lasers.wait_for(lambda message: True, 10.0, 'laser marker')
        self.assertEqual((Marker.POINTS, 'map', header.stamp),
                         (marker.type, marker.header.frame_id, marker.header.stamp))
        self.assertEqual([(1.5, -0.25), (0.0, 2.0)], [(p.x, p.y) for p in marker.points])
        self.assertGreater(marker.color.b, marker.color.r)
        self.assertEqual(2.0, marker.lifetime.to_sec())


if __name__ == '__main__':
    run_cases(__file__)
