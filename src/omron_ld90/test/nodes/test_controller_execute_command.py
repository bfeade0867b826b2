"""Each way in which a command can end has its own outcome."""
from __future__ import annotations

from omron_arcl import Outcome
from omron_ld90.nodes.controller_execute_command import _OUTCOMES
from omron_ld90_msgs.msg import ExecuteCommandResult


def test_every_way_to_end_has_an_outcome_of_the_action():
    assert set(_OUTCOMES) == set(Outcome)
    assert _OUTCOMES[Outcome.EMERGENCY_STOPPED] == ExecuteCommandResult.EMERGENCY_STOPPED
    assert _OUTCOMES[Outcome.LOST] == ExecuteCommandResult.LOST
