"""`ld90_sim`: a simulated LD-90 as a program."""
from __future__ import annotations

import argparse
import signal
import sys
from typing import List, Optional, Tuple

from omron_ld90.maps import MapError, wait_for_map
from omron_ld90_sim.planner import NoWay
from omron_ld90_sim.simulator import DEFAULT_LISTS, Simulator
from omron_ld90_sim.transport import PortTaken


def _address(text: str) -> Tuple[str, int]:
    host, _, port = text.rpartition(':')
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise argparse.ArgumentTypeError(f"'{text}' is not HOST:PORT")
    return host, int(port)


def _pose(text: str) -> Tuple[float, float, float]:
    try:
        x, y, theta = (float(part) for part in text.split(','))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not X,Y,DEG (metres, metres, degrees)"
                                         ) from None
    return x * 1000.0, y * 1000.0, theta


def _speed(text: str) -> float:
    try:
        speed = float(text)
    except ValueError:
        speed = 0.0
    if not 0.1 <= speed <= 20.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a factor from 0.1 to 20")
    return speed


def _list(text: str) -> Tuple[float, str]:
    seconds, colon, commands = text.partition(':')
    try:
        return float(seconds), commands if colon else ''
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not SECONDS:COMMAND|COMMAND...") from None


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(
        prog='ld90_sim', description='A simulated OMRON LD-90 that speaks ARCL.')
    result.add_argument('--map', required=True, metavar='FILE', help='.map file to drive on')
    result.add_argument('--made-from', nargs='*', default=[], metavar='FILE',
                        help='wait until the map is at least as new as these files')
    result.add_argument('--port', type=int, default=7171,
                        help='port of the ARCL server (7171); 0 chooses a free one')
    result.add_argument('--host', default='127.0.0.1',
                        help='address to listen on (127.0.0.1; 0.0.0.0 for other machines)')
    secret = result.add_mutually_exclusive_group()
    secret.add_argument('--password', help='ARCL password; visible in the process list')
    secret.add_argument('--password-file', metavar='FILE',
                        help='file that holds the ARCL password and nothing else')
    result.add_argument('--outgoing', type=_address, metavar='HOST:PORT',
                        help='where the robot dials out to')
    result.add_argument('--outgoing-commands', type=_list, action='append', metavar='SECONDS:LIST',
                        help='command list of the outgoing connection, commands separated by |; '
                             'up to five (0.5:Status and 0.5:RangeDeviceGetCurrent Laser_1)')
    result.add_argument('--speed', type=_speed, default=1.0,
                        help="factor on the robot's whole clock, 0.1 to 20")
    result.add_argument('--start', type=_pose, metavar='X,Y,DEG',
                        help='start pose in metres and degrees (the dock, RobotHome, a goal, or a '
                             'free place)')
    result.add_argument('--seed', type=int, default=0, help='seed of everything random')
    return result


def _password(arguments: argparse.Namespace) -> str:
    if arguments.password_file is None:
        return arguments.password or 'adept'
    with open(arguments.password_file, encoding='utf-8') as file:
        word = file.read().strip()
    if not word:
        raise ValueError(f'{arguments.password_file} is empty: write the ARCL password into it')
    return word


def main(argv: Optional[List[str]] = None) -> int:
    """Runs the program; 0 after a signal, 1 with one sentence when it cannot start."""
    given = sys.argv[1:] if argv is None else argv
    # roslaunch adds remappings such as __name:=ld90_sim, which mean nothing here
    words = [word for word in given if ':=' not in word]
    while '--start' in words[:-1]:      # argparse takes -1.0,2.0,90 for an option
        at = words.index('--start')
        words[at:at + 2] = [f'--start={words[at + 1]}']
    arguments = parser().parse_args(words)
    lists = DEFAULT_LISTS
    if arguments.outgoing_commands:
        lists = dict(enumerate(arguments.outgoing_commands[:5], 1))
    try:
        wait_for_map(arguments.map, made_from=arguments.made_from)
        simulator = Simulator(arguments.map, arguments.port, _password(arguments),
                              arguments.outgoing, arguments.speed, arguments.start,
                              arguments.seed, arguments.host, lists)
    except (MapError, PortTaken, NoWay, ValueError) as error:
        print(f'ld90_sim: {error}', file=sys.stderr)
        return 1
    except OSError as error:
        print(f'ld90_sim: cannot read {error.filename}: {error.strerror}', file=sys.stderr)
        return 1
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: simulator.loop.stop())
    print(f'ready: ARCL on {arguments.host}:{simulator.port}', flush=True)
    simulator.run()
    return 0
