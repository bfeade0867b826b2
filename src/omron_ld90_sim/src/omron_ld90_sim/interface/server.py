"""The ARCL server without I/O: it has the connected clients and the lines for each of them.

Replies go to the session that asked. `broadcast` goes to every session that is logged in, including
the outgoing one. The interpreter (`commands`) executes command lines.
"""
from __future__ import annotations

import time
from pathlib import Path
from typing import Callable, List, Optional

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.clock import SimClock, Ticker
from omron_ld90_sim.interface.configuration import RobotConfiguration
from omron_ld90_sim.interface.configuration_table import FILES, FLEET, SERVER, default_configuration
from omron_ld90_sim.interface.data_store import DataStore
from omron_ld90_sim.interface.dialect import Dialect
from omron_ld90_sim.interface.session import Impairment, LoginPhase, SimSession
from omron_ld90_sim.motion.floor import SimFloor
from omron_map import MapDocument, MapError

MINIMUM_TIMEOUT = 60.0      # s, lower limit of SessionTimeoutMins


class ArclServer:
    """The interface of one robot.

    It has many attributes because it puts the parts of one interface together.
    """

    def __init__(self, clock: SimClock, robot: SimRobot, password: str, interpreter: Interpreter,
                 configuration: Optional[RobotConfiguration] = None,
                 map_folder: Optional[Path] = None) -> None:
        """`interpreter` executes command lines: `commands.execute`.

        `map_folder`: folder of the maps that `configAdd Map` may name.
        """
        self._jobs = 0
        self.clock, self.robot, self.password = clock, robot, password
        self._interpreter = interpreter
        self.configuration = configuration or default_configuration()
        self.map_folder = map_folder
        self.sessions: List[SimSession] = []
        self.impairment = Impairment()
        self.dialect = Dialect()
        self.online = True              # False: no listener and no outgoing connection
        self.accepting = True           # False: new connections are refused
        self.outgoing_wanted = True     # False: there is no outgoing connection
        self.outgoing_asked: Callable[[], None] = lambda: None   # called when the link opens
        self.log: Callable[[int, str, bytes], None] = lambda number, direction, line: None
        self.outgoing_begins: Callable[[SimSession], object] = lambda session: None
        self.wall_time = time.localtime
        self.data_store = DataStore(robot, lambda: self.wall_time())
        self._count = 0
        robot.announce = self.broadcast
        Ticker(clock, MINIMUM_TIMEOUT / 4, self._drop_silent)

    @property
    def robot_name(self) -> str:
        """The robot's own name."""
        return self.configuration.text(FLEET, 'Identifier')

    def next_job(self) -> int:
        """Returns the number of the next job in the robot's own queue."""
        self._jobs += 1
        return self._jobs

    @property
    def date_time(self) -> str:
        """The wall clock in the form of ARCL."""
        return time.strftime('%m/%d/%Y %H:%M:%S', self.wall_time())

    def connect(self) -> SimSession:
        """Begins the session of a new client."""
        self._count += 1
        session = SimSession(self, self._count)
        self.sessions.append(session)
        return session

    def connect_outgoing(self) -> SimSession:
        """Begins the outgoing session: it has no login, and gets every broadcast."""
        session = SimSession(self, 0, outgoing=True)
        self.sessions.append(session)
        asked, self.outgoing_asked = self.outgoing_asked, lambda: None
        asked()
        self.outgoing_begins(session)
        return session

    def forget(self, session: SimSession) -> None:
        """Removes a session that has ended."""
        session.phase = LoginPhase.CLOSED
        if session in self.sessions:
            self.sessions.remove(session)

    def drop_all(self, abort: bool = False) -> None:
        """Ends every connection, including the outgoing one."""
        for session in list(self.sessions):
            session.close(abort)

    def shut_down(self) -> None:
        """Ends the server: sends a farewell, then closes the port and all connections."""
        for session in list(self.sessions):
            session.send('Shutting down server')
        self.online = False
        self.drop_all()

    def switch_off(self) -> None:
        """Switches the robot off: it stops, and every connection ends silently."""
        self.robot.halt()
        self.online = False
        self.drop_all()

    def restart(self, seconds: float, abort: bool = False) -> None:
        """Ends the robot's software for `seconds`; sends a farewell unless `abort`."""
        if abort:
            self.online = False
            self.drop_all(abort)
        else:
            self.shut_down()
        self.robot.halt()

        def up() -> None:
            self.online = True

        self.clock.after(seconds, up)

    def _drop_silent(self) -> None:
        minutes = self.configuration.number(SERVER, 'SessionTimeoutMins')
        if minutes >= 0:
            limit = max(minutes * 60.0, MINIMUM_TIMEOUT)
            for session in list(self.sessions):
                if not session.outgoing and self.clock.now - session.last_received >= limit:
                    session.close()

    def broadcast(self, line: str) -> None:
        """Sends a line to all clients that are logged in."""
        for session in list(self.sessions):
            if session.phase is LoginPhase.OPEN:
                session.send(line)

    def execute(self, session: SimSession, line: str) -> None:
        """Executes one command line for `session`."""
        self._interpreter(self, session, line)

    def switch_map(self, name: str) -> None:
        """Loads another map from the map folder. Raises ValueError, with a sentence, on failure."""
        if self.map_folder is None or Path(name).name != name:
            raise ValueError(f"The file given did not exist: '{name}'")
        try:
            document = MapDocument.load(str(self.map_folder / name))
        except MapError as error:
            raise ValueError(str(error)) from error
        self.robot.halt()
        self.robot.load_map(document, SimFloor.from_map(document))
        self.configuration.set(FILES, 'Map', name)
        self.broadcast('Map changed')


Interpreter = Callable[[ArclServer, SimSession, str], None]
