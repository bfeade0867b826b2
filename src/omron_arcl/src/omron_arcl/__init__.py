"""ARCL, the text protocol of OMRON mobile robots, without ROS.

`Client` sends commands to a robot. `Listener` accepts the connection that a robot opens.
`parse_line` reads the robot's lines: each kind of line is a class in `omron_arcl.replies`.
"""
from __future__ import annotations

from omron_arcl import replies
from omron_arcl.activity import Activity, ActivityKind, read_activity
from omron_arcl.client import Client
from omron_arcl.command_line import parse_command, printable, quote
from omron_arcl.command_table import COMMANDS
from omron_arcl.commands import Category, Command
from omron_arcl.errors import ArclError, Busy, InvalidCommand, LinkError, NotConnected
from omron_arcl.execution import Execution, Giver, Outcome, Result
from omron_arcl.help_list import HelpList
from omron_arcl.link import Backoff, Link, LinkPhase
from omron_arcl.listener import Listener
from omron_arcl.parser import parse_line
from omron_arcl.replies import Reply, readable, same_name
from omron_arcl.session import Received
from omron_arcl.session_log import SessionLog
from omron_arcl.status import StatusAssembler

__all__ = [
    'Activity', 'ActivityKind', 'ArclError', 'Backoff', 'Busy', 'COMMANDS', 'Category', 'Client',
    'Command', 'Execution', 'Giver', 'HelpList', 'InvalidCommand', 'Link', 'LinkError', 'LinkPhase',
    'Listener', 'NotConnected', 'Outcome', 'Received', 'Reply', 'Result', 'SessionLog',
    'StatusAssembler', 'parse_command', 'parse_line', 'printable', 'quote', 'read_activity',
    'readable', 'replies', 'same_name',
]
