"""The stop of the whole fleet, as the door of the page carries it out."""
from __future__ import annotations

from fleet_page.core.acts import Outcome
from graph_fleet_manager.commands.command_line import CommandError
from graph_fleet_manager.commands.stop import stop


def stop_fleet() -> Outcome:
    """Stops all robots, even if the fleet manager hangs.

    One stop may run at a time, because a direct stop uses the topics of the robots.
    """
    try:
        return Outcome(True, stop())
    except CommandError as error:
        return Outcome(False, str(error))
