"""Only "take over" puts a draft in force. Without a fleet manager, the draft is published on
/graph.
"""
from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, Dict, List

import pytest
import rospy
import yaml

from graph_editor.editor.actions import Action
from graph_editor.editor.session import EditingSession
from graph_editor.nodes import take_over
from graph_editor.nodes.take_over import TakeOver
from trajectory_graph.yaml_editing import GraphFile

EDITOR = Path(__file__).resolve().parents[2]
HALL = """\
Edges:
- {CurveType: line, Destination_ID: 2, Id: 1, Origin_ID: 1, ParamB: 0.25, ParamF: 0.25, VelocityBackwards: 0.3, VelocityForward: 1.0}
Vertices:
- {FrameId: m, Id: 1, Label: pass, Theta: 0.0, ThetaHolomonic: 0.0, X: 0.0, Y: 0.0}
- {FrameId: m, Id: 2, Label: pass, Theta: 0.0, ThetaHolomonic: 0.0, X: 8.0, Y: 0.0}
"""  # noqa: E501


class RosMaster:
    """A ROS master, with a fleet manager's services and parameters if the test has one."""

    def __init__(self) -> None:
        self.providers: List[str] = []
        self.parameters: Dict[str, str] = {}
        self.answer: Any = SimpleNamespace(success=True, message='hall.yaml is in force')
        self.published: List[str] = []

    def getSystemState(self) -> Any:  # noqa: N802  rosgraph's name
        return [], [], [['/reload_graph', self.providers]] if self.providers else []


@pytest.fixture
def master(monkeypatch: pytest.MonkeyPatch) -> RosMaster:
    master = RosMaster()

    class Topic:
        def __init__(self, name: str) -> None:
            self._name = name

        def publish(self, _: object) -> None:
            master.published.append(self._name)
    monkeypatch.setattr(take_over.rosgraph, 'Master', lambda _: master)
    monkeypatch.setattr(rospy, 'get_param', master.parameters.get)
    monkeypatch.setattr(rospy, 'ServiceProxy', lambda *_: lambda: master.answer)
    monkeypatch.setattr(take_over, 'GraphTopic', Topic)
    return master


@pytest.fixture
def session(tmp_path: Path) -> EditingSession:
    path = tmp_path / 'hall.yaml'
    path.write_text(HALL)
    return EditingSession(GraphFile.load(path), str(path))


def taken_over(session: EditingSession) -> str:
    return TakeOver().put_in_force(session.draft, session.path)


def test_a_click_for_the_editor_has_a_topic_that_no_robot_hears() -> None:
    shown = yaml.safe_load((EDITOR / 'rviz' / 'graph_editor.rviz').read_text())
    tools = shown['Visualization Manager']['Tools']
    assert [tool['Topic'] for tool in tools if 'Topic' in tool] == ['graph_editor/clicked_point']


def test_taking_over_saves_first(session: EditingSession) -> None:
    given = []
    session.on_take_over = given.append
    session.drag_vertex(2, 9.0, 0.0)
    assert given == []
    session.do(Action.TAKE_OVER, 'vertex', 1)
    assert session.is_saved
    assert given == [session.draft]


def test_what_cannot_be_saved_is_not_taken_over(session: EditingSession) -> None:
    given = []
    session.on_take_over = given.append
    session.do(Action.DELETE_EDGE, 'edge', 1)
    session.take_over()
    assert given == []
    assert session.said.startswith('NOT SAVED')


def test_without_a_fleet_manager_the_graph_goes_out_on_graph(master, session) -> None:
    assert taken_over(session).startswith('Taken over: there is no fleet manager')
    assert master.published == ['/graph']


@pytest.mark.parametrize('success, words', [(True, 'Taken over: '), (False, 'NOT TAKEN OVER: ')])
def test_a_fleet_manager_decides_and_is_the_only_one_on_graph(master, session, success, words):
    master.providers = ['/graph_server']
    master.parameters['/graph_server/graph_file'] = session.path
    master.answer = SimpleNamespace(success=success, message='edge 1 is driven by r1')
    assert taken_over(session) == f'{words}edge 1 is driven by r1'
    assert master.published == []


def test_a_fleet_manager_with_another_graph_is_left_alone(master, session) -> None:
    master.providers = ['/graph_server']
    master.parameters['/graph_server/graph_file'] = '/site/other.yaml'
    assert taken_over(session).startswith(
        'NOT TAKEN OVER: the fleet manager uses /site/other.yaml')
    assert master.published == []
