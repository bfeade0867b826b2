"""The last known place of the robot, its links, and the nodes that report the links."""
from __future__ import annotations

import pytest

from omron_ld90.bridge.events import LinkReported, RobotLink
from omron_ld90.bridge.robot_state import MapLocation, RobotLinks, RobotLocation

SECOND = 1_000_000_000


class TestRobotLocation:

    def test_speed_and_period_are_those_between_two_locations(self):
        location = RobotLocation()
        location.update(MapLocation(10 * SECOND, 0.0, 0.0), 1.0)
        location.update(MapLocation(10 * SECOND + SECOND // 2, 0.3, 0.4), 1.6)
        assert location.speed == pytest.approx(1.0)
        assert location.period == pytest.approx(0.5)
        assert location.heard == 1.6

    @pytest.mark.parametrize('stamp', [10 * SECOND, 9 * SECOND])
    def test_a_location_that_comes_twice_or_late_is_left_out(self, stamp):
        location = RobotLocation()
        location.update(MapLocation(10 * SECOND, 0.0, 0.0), 1.0)
        assert not location.update(MapLocation(stamp, 5.0, 0.0), 1.1)
        assert location.last.position == (0.0, 0.0)

    def test_a_clock_that_was_set_back_is_no_late_location(self):
        location = RobotLocation()
        location.update(MapLocation(100 * SECOND, 0.0, 0.0), 1.0)
        assert location.update(MapLocation(50 * SECOND, 0.1, 0.0), 1.5)


class TestRobotLinks:

    @staticmethod
    def links() -> RobotLinks:
        """Returns two links that are up at time 0."""
        links = RobotLinks(RobotLink, link_timeout=2.0, restart_timeout=20.0)
        for link in RobotLink:
            links.update(LinkReported(link, True), 0.0)
        return links

    def test_a_link_of_which_nothing_is_known_cannot_be_used_and_is_not_lost(self):
        links = RobotLinks([RobotLink.COMMANDS], 2.0, 20.0)
        assert links.why_unusable(9.0).text == 'no report has arrived about the link commands'
        assert links.why_lost(9.0).text == ''

    def test_a_link_that_is_down_is_lost_after_the_timeout(self):
        links = self.links()
        for time in (1.0, 2.0, 3.0, 4.0):
            links.update(LinkReported(RobotLink.OUTGOING, True), time)
            links.update(LinkReported(RobotLink.COMMANDS, False, 'refused'), time)
        assert links.why_unusable(1.1).text == 'lost link: commands: refused'
        assert not links.stands(RobotLink.COMMANDS, 1.1)
        assert links.why_lost(2.9).text == ''
        assert links.why_lost(3.1).text == 'lost link: commands: refused'

    def test_a_node_that_reports_nothing_is_away_and_gets_the_time_of_a_restart(self):
        links = self.links()
        assert links.why_unusable(1.9).text == ''
        assert 'commands: its node has reported nothing for 3 s' in links.why_unusable(3.0).text
        assert links.why_lost(19.0).text == ''
        assert 'its node has reported nothing for 21 s' in links.why_lost(21.0).text

    def test_a_node_that_is_back_gets_the_rest_of_that_time_for_its_link(self):
        links = self.links()
        for time in (6.0, 7.0, 8.0, 9.0, 10.0):
            links.update(LinkReported(RobotLink.OUTGOING, True), time)
            links.update(LinkReported(RobotLink.COMMANDS, False, 'connecting'), time)
        assert links.why_lost(10.0).text == ''
        for time in range(11, 22):
            for link, up in ((RobotLink.OUTGOING, True), (RobotLink.COMMANDS, False)):
                links.update(LinkReported(link, up, 'refused'), float(time))
        assert links.why_lost(21.0).text == 'lost link: commands: refused'

    def test_up_since_tells_of_the_return_of_link_and_node(self):
        links = self.links()
        links.update(LinkReported(RobotLink.COMMANDS, False, 'refused'), 1.0)
        links.update(LinkReported(RobotLink.COMMANDS, True), 1.5)
        links.update(LinkReported(RobotLink.COMMANDS, True), 2.5)
        assert links.up_since(RobotLink.COMMANDS) == 1.5
        links.update(LinkReported(RobotLink.COMMANDS, True), 9.0)
        assert links.up_since(RobotLink.COMMANDS) == 9.0
