"""The command `station`: lists stations, zones, devices and chargers, and which robots claim them.

Exit status 0: done; 1: wrong input, or no fleet manager.
"""
from __future__ import annotations

from typing import Any, Dict, List, Optional, Sequence

from fleet_core.interlocking.claims import ClaimState
from graph_fleet_manager.commands.command_line import OK, Parser
from graph_fleet_manager.commands.fleet_client import TopicListener, connect, run
from graph_fleet_manager.commands.tables import as_json, offer_json, table_with_notes
from graph_fleet_manager.messages.resources import CLAIM_OF_CODE, KIND_OF_CODE, device_of
from itrci_nav_msgs.msg import FleetResource, FleetState


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    return run('station', _station, arguments)


def _station(arguments: List[str]) -> int:
    parser = Parser('station', description='Lists the stations, zones and devices of the work '
                    'file, the chargers, and the robots that claim them.')
    commands = parser.add_subparsers(dest='command', metavar='COMMAND')
    commands.required = True
    offer_json(commands.add_parser(
        'list', help='each station, zone, device and charger, and the robots that claim it'))
    options = parser.parse_args(arguments)
    connect('station_command')
    resources = TopicListener('/fleet_state', FleetState).last().resources
    print(as_json({'resources': [_values(one) for one in resources]}) if options.json
          else _listed(resources))
    return OK


def _listed(resources: Sequence[FleetResource]) -> str:
    if not resources:
        return ('The fleet manager has no work file with stations, zones or devices, and no robot '
                'type has docks.')
    rows, notes = [], []
    for one in resources:
        claims = ', '.join(f'{claim.robot} ({CLAIM_OF_CODE[claim.state].value})'
                           for claim in one.claims)
        device = device_of(one)
        rows.append((one.name, KIND_OF_CODE[one.kind].value,
                     '-' if device is None else device.mode.name,
                     f'{len(one.claims)} of {one.capacity}', claims or '-'))
        notes.append('; '.join([*([device.why] if device is not None and device.why else []), *(
            f'ALARM: {claim.robot} is there, but it does not report that it is open'
            for claim in one.claims if CLAIM_OF_CODE[claim.state] is ClaimState.LOST)]))
    return table_with_notes(('name', 'kind', 'shows', 'claims', 'claimed by'), rows, notes)


def _values(one: FleetResource) -> Dict[str, Any]:
    device = device_of(one)
    return {'name': one.name, 'kind': KIND_OF_CODE[one.kind].name, 'capacity': one.capacity,
            'edges': list(one.edges), 'vertices': list(one.vertices),
            'shows': None if device is None else device.mode.name,
            'reason': None if device is None else device.why or None,
            'claims': [{'robot': claim.robot, 'state': CLAIM_OF_CODE[claim.state].name}
                       for claim in one.claims]}
