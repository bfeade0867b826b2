"""Commands that read the data store and begin a new trip."""
from __future__ import annotations

from omron_ld90_sim.interface.commands.table import CommandCall, command
from omron_ld90_sim.interface.data_store import FIELDS, GROUPS


@command('getDataStoreFieldInfo', 'Gets the info on a field in the Data Store', '<field>', 1,
         'dsfi')
def field_info(call: CommandCall) -> None:
    """Describes one field."""
    call.reply(f'GetDataStoreFieldInfo: {FIELDS[call.named(FIELDS, "field")].info}')
    call.reply('EndOfGetDataStoreFieldInfo')


@command('getDataStoreFieldList', 'Gets the list of field names in the Data Store', shortcut='dsfl')
def field_list(call: CommandCall) -> None:
    """Lists all fields of all groups."""
    for name in FIELDS:
        call.reply(f'GetDataStoreFieldList: {name}')
    call.reply('EndOfGetDataStoreFieldList')


@command('getDataStoreFieldValues', 'Gets the values of a field in the Data Store', '<field>', 1,
         'dsfv')
def field_values(call: CommandCall) -> None:
    """Answers one field's value."""
    field = FIELDS[call.named(FIELDS, 'field')]
    call.reply(f'GetDataStoreFieldValues: {field.name} {field.text(call.server.data_store)}')
    call.reply('EndOfGetDataStoreFieldValues')


@command('getDataStoreGroupInfo', 'Gets the info on a group in the Data Store', '<group>', 1,
         'dsgi')
def group_info(call: CommandCall) -> None:
    """Describes one group and its fields."""
    group = GROUPS[call.named(GROUPS, 'group')]
    call.reply(f'GetDataStoreGroupInfo: "{group.description}" "{group.category}"')
    for field in group.fields:
        call.reply(f'GetDataStoreGroupInfo: {field.info}')
    call.reply('EndOfGetDataStoreGroupInfo')


@command('getDataStoreGroupList', 'Gets the list of groups in the Data Store', shortcut='dsgl')
def group_list(call: CommandCall) -> None:
    """Lists the groups."""
    for name in GROUPS:
        call.reply(f'GetDataStoreGroupList: {name}')
    call.reply('EndOfGetDataStoreGroupList')


@command('getDataStoreGroupValues', 'Gets the values of a group in the Data Store', '<group>', 1,
         'dsgv')
def group_values(call: CommandCall) -> None:
    """Answers the values of one group's fields."""
    for field in GROUPS[call.named(GROUPS, 'group')].fields:
        call.reply(f'GetDataStoreGroupValues: {field.name} {field.text(call.server.data_store)}')
    call.reply('EndOfGetDataStoreGroupValues')


@command('getDataStoreTripGroupList', 'Gets the list of groups in the Data Store with trip values',
         shortcut='dstgl')
def trip_group_list(call: CommandCall) -> None:
    """Lists the groups that a trip reset affects."""
    for group in GROUPS.values():
        if group.trip:
            call.reply(f'GetDataStoreTripGroupList: {group.name}')
    call.reply('EndOfGetDataStoreTripGroupList')


@command('tripReset', 'Resets the trip values in the Data Store', shortcut='tr')
def trip_reset(call: CommandCall) -> None:
    """Begins a new trip, and answers its values, which are zero now."""
    store = call.server.data_store
    for field in store.reset_trip():
        call.reply(f'tripReset: {field.name} {field.text(store)}')
    call.reply('EndOfTripReset')
