"""The simulated LD-90 in the yard, in any dialect, with the interface of `speaking_robot`."""
from __future__ import annotations

from functools import lru_cache
from typing import Callable, Optional, Tuple

from bridge_builders import DOCK_VERTEX, yard

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.behaviour.states import MotorState
from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.interface.commands import execute
from omron_ld90_sim.interface.dialect import SWITCHES
from omron_ld90_sim.interface.faults import Faults
from omron_ld90_sim.interface.server import ArclServer
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose
from omron_map import MapDocument

DIALECTS = ('interrupted name', 'interrupted coordinates', 'interrupted nothing',
            'prompt Password:', 'welcome Hello', 'help names', 'help none', 'unlisted goto stop',
            'missing dock undock', 'encoding ascii', 'goals quoted', 'replacing stopping',
            'unknown bare', 'battery volts', 'status older')
assert {dialect.split()[0] for dialect in DIALECTS} == set(SWITCHES)
_WALLS = ((-2000, -5500, 14000, -5500), (-2000, 6000, 14000, 6000), (-2000, -5500, -2000, 6000),
          (14000, -5500, 14000, 6000))


@lru_cache(maxsize=None)
def _hall() -> Tuple[MapDocument, SimFloor]:
    """Returns a hall around the yard, with a goal at each vertex of the yard."""
    lines = ['2D-Map', 'LineMinPos: -2000 -5500', 'LineMaxPos: 14000 6000',
             f'NumLines: {len(_WALLS)}', 'LinesAreSorted: false',
             'MapInfo: DockType Name=DockLynx', 'MapInfo: GoalType Name=Goal']
    for vertex in yard().vertices.values():
        x, y = (f'{1000.0 * value:.0f}' for value in vertex.position)
        lines.append(f'Cairn: DockLynx {x} {y} 270.000000 "" ICON "Dock"'
                     if vertex.id == DOCK_VERTEX else
                     f'Cairn: Goal {x} {y} 0.000000 "" ICON "{vertex.id}"')
    lines += ['LINES', *(' '.join(map(str, wall)) for wall in _WALLS), '']
    document = MapDocument.from_bytes('\n'.join(lines).encode(), name='yard.map')
    return document, SimFloor.from_map(document)


class SimulatedRobot:
    """The simulator's core with its own clock, which follows the test's clock.

    say -- called with each line that a client of the robot's server receives
    """

    def __init__(self, vertex: int, say: Callable[[str], None], time: Callable[[], float],
                 dialect: str) -> None:
        self._say, self._time, self._clock = say, time, SimClock()
        x, y = yard().vertex(vertex).position
        document, floor = _hall()
        self._robot = SimRobot(self._clock, document, floor, SimPose(1000.0 * x, 1000.0 * y, 0.0))
        self._server = ArclServer(self._clock, self._robot, 'adept', execute)
        self._faults = Faults(self._server)
        self._faults.inject(f'dialect {dialect}')
        self._session = self._server.connect()
        self._session.receive(b'adept\n')
        self._session.output.clear()

    @property
    def position(self) -> Tuple[float, float]:
        """The position in m."""
        pose = self._robot.true_pose
        return pose.x / 1000.0, pose.y / 1000.0

    @property
    def status(self) -> str:
        """The status text that the receiver gets."""
        return self._robot.status

    @property
    def is_stopped_by_button(self) -> bool:
        """Whether the emergency stop is pressed, regardless of the status text."""
        return self._robot.permission.motors is MotorState.ESTOP

    @property
    def goal(self) -> Optional[str]:
        """The goal to which the robot drives; `point` if it drives to a point; None: it stands."""
        activity = self._robot.activity
        if activity is None or activity.status.startswith(('Arrived', 'Undocking')):
            return None
        return 'dock' if 'dock' in activity.status else activity.status.split()[-1]

    def receive(self, line: str) -> None:
        """Receives a command on our connection."""
        self._catch_up()
        self._session.receive(f'{line}\n'.encode())
        self._speak()

    def hear_another(self, line: str) -> None:
        """Receives a command of another client."""
        self.inject(f'other {line}')

    def inject(self, fault: str) -> None:
        """Injects a fault into the simulator, such as `estop press`."""
        self._catch_up()
        self._faults.inject(fault)
        self._speak()

    def move(self, now: float) -> Optional[str]:
        """Drives on; returns the goal at which it has just arrived."""
        before = self.goal
        self._catch_up()
        self._speak()
        return before if self.goal is None else None

    def _catch_up(self) -> None:
        self._clock.advance(self._time())

    def _speak(self) -> None:
        text = self._session.output.decode('ascii')
        self._session.output.clear()
        for line in text.split('\r\n')[:-1]:
            self._say(line)
