"""What the robot's menu in RViz asks the fleet manager for."""
from __future__ import annotations

import queue

import pytest
from std_srvs.srv import Trigger

from graph_fleet_manager.nodes import fleet_acts
from graph_fleet_manager.nodes.rviz.menus import ROBOT_MENU, Act, Subject
from itrci_nav_msgs.srv import DeclareAbsent, DeclareAbsentResponse


@pytest.mark.parametrize('act, service, kind', [
    (Act.ABSENT, '/a/declare_absent', DeclareAbsent), (Act.OUT, '/a/leave_fleet', Trigger),
    (Act.IN, '/a/join_fleet', Trigger)])
def test_a_choice_in_the_robots_menu_calls_its_service(monkeypatch, act, service, kind):
    called, said = [], queue.Queue()
    monkeypatch.setattr(fleet_acts.rospy, 'Publisher', lambda *_, **__: None)
    monkeypatch.setattr(fleet_acts.rospy, 'wait_for_service', lambda *_: None)

    def proxy(*of):
        called.append(of)
        return lambda: DeclareAbsentResponse(True, 'a: done.')
    monkeypatch.setattr(fleet_acts.rospy, 'ServiceProxy', proxy)
    fleet_acts.FleetActs(said.put).act(act, Subject(robot='a'))
    assert said.get(timeout=10.0) == 'a: done.'
    assert called == [(service, kind)] and act in ROBOT_MENU
