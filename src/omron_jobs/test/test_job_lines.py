"""Each line of OMRON's sources that the server sends, byte for byte, with its source.

A row is a conversation: `> ` is a line of a client, `< ` a line that must follow, and `* ` an act
of the fleet. The lines were copied from the sources, not from the server. A source is a page ("p.")
of OMRON's ARCL manual (I617-E-01), the name of a client program, or "real": a Fleet Manager has
sent the line.
"""
from __future__ import annotations

import calendar
from typing import Dict, List, Sequence

import pytest
from job_fleet import tell
from job_line import ACTIVE, AT, LATER, Line

from omron_jobs.core.job_commands import VERSION
from omron_jobs.core.job_words import RobotStatus
from omron_jobs.core.jobs import DriveAct, JobMissionState
from omron_jobs.core.robots import RobotNews

OPEN = f'{AT} None None'
ROWS: Dict[str, Sequence[str]] = {
    # -- replies, and the course of a job ----------------------------------------------------------
    'queuePickup, p. 217': (
        '* number 13', '> queuePickup z 11 xyz',
        '< queuepickup goal "z" with priority 11 id PICKUP13 and job_id xyz successfully queued',
        f'< QueueUpdate: PICKUP13 xyz 11 Pending None Goal "z" "None" {OPEN} 0 ',
        '* served Lynx1',
        f'< QueueUpdate: PICKUP13 xyz 11 InProgress UnAllocated Goal "z" "Lynx1" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP13 xyz 11 InProgress Allocated Goal "z" "Lynx1" {OPEN} 0 ',
        '* drives',
        f'< QueueUpdate: PICKUP13 xyz 11 InProgress Driving Goal "z" "Lynx1" {OPEN} 0 ',
        '* wait 16', '* done',
        f'< QueueUpdate: PICKUP13 xyz 11 Completed None Goal "z" "Lynx1" {AT} {LATER} 0 '),
    'queuePickup with defaults, p. 213': (
        '> queuePickup z',
        '< queuepickup goal "z" with priority 10 id PICKUP1 and job_id JOB1 successfully queued',
        f'< QueueUpdate: PICKUP1 JOB1 10 Pending None Goal "z" "None" {OPEN} 0 '),
    'queuePickupDropoff, p. 221; a chain, p. 214': (
        '* number 12', '> queuePickupDropoff x y default 20',
        '< queuepickupdropoff goals "x" and "y" with priorities 10 and 20 ids PICKUP12 and '
        'DROPOFF13 job_id JOB12 successfully queued',
        f'< QueueUpdate: PICKUP12 JOB12 10 Pending None Goal "x" "None" {OPEN} 0 ',
        f'< QueueUpdate: DROPOFF13 JOB12 20 Pending ID_PICKUP12 Goal "y" "None" {OPEN} 0 ',
        '> queuePickupDropoff x z',  # jobs are numbered by segments: the next one is JOB14
        '< queuepickupdropoff goals "x" and "z" with priorities 10 and 20 ids PICKUP14 and '
        'DROPOFF15 job_id JOB14 successfully queued',
        f'< QueueUpdate: PICKUP14 JOB14 10 Pending None Goal "x" "None" {OPEN} 0 ',
        f'< QueueUpdate: DROPOFF15 JOB14 20 Pending ID_PICKUP14 Goal "z" "None" {OPEN} 0 ',
        '* job 0', '* served Lynx1',
        f'< QueueUpdate: PICKUP12 JOB12 10 InProgress UnAllocated Goal "x" "Lynx1" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP12 JOB12 10 InProgress Allocated Goal "x" "Lynx1" {OPEN} 0 ',
        '* drives',
        f'< QueueUpdate: PICKUP12 JOB12 10 InProgress Driving Goal "x" "Lynx1" {OPEN} 0 ',
        '* wait 16', '* done',  # the same robot continues at once; queuing times do not change
        f'< QueueUpdate: PICKUP12 JOB12 10 Completed None Goal "x" "Lynx1" {AT} {LATER} 0 ',
        f'< QueueUpdate: DROPOFF13 JOB12 20 InProgress UnAllocated Goal "y" "Lynx1" {OPEN} 0 ',
        f'< QueueUpdate: DROPOFF13 JOB12 20 InProgress Allocated Goal "y" "Lynx1" {OPEN} 0 ',
        '* drives',
        f'< QueueUpdate: DROPOFF13 JOB12 20 InProgress Driving Goal "y" "Lynx1" {OPEN} 0 ',
        '* done',
        f'< QueueUpdate: DROPOFF13 JOB12 20 Completed None Goal "y" "Lynx1" {AT} {LATER} 0 '),
    'a swap, p. 221-222': (
        '* number 10', '> queuePickupDropoff x y', '* skip', '* served Lynx1', '* done', '* skip',
        '> queuePickupDropoff y z',
        '< queuepickupdropoff goals "y" and "z" with priorities 10 and 20 ids PICKUP12 and '
        'DROPOFF13 job_id JOB12 successfully queued and linked to job_id JOB10',
        f'< QueueUpdate: PICKUP12 JOB12 10 Pending None Goal "y" "Lynx1" {OPEN} 0 ',
        f'< QueueUpdate: DROPOFF13 JOB12 20 Pending ID_PICKUP12 Goal "z" "Lynx1" {OPEN} 0 '),
    'queueMulti, p. 213-214; job_id: a real line': (
        '> queueMulti 4 2 x pickup 10 y pickup 19 z dropoff default x dropoff 20',
        '< QueueMulti: goal "x" with priority 10 id PICKUP1 and job_id JOB1 successfully queued',
        '< QueueMulti: goal "y" with priority 19 id PICKUP2 and job_id JOB1 successfully queued '
        'and linked to PICKUP1',
        '< QueueMulti: goal "z" with priority 20 id DROPOFF3 and job_id JOB1 successfully queued '
        'and linked to PICKUP2',
        '< QueueMulti: goal "x" with priority 20 id DROPOFF4 and job_id JOB1 successfully queued '
        'and linked to DROPOFF3',
        '< EndQueueMulti',
        f'< QueueUpdate: PICKUP1 JOB1 10 Pending None Goal "x" "None" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP2 JOB1 19 Pending ID_PICKUP1 Goal "y" "None" {OPEN} 0 ',
        f'< QueueUpdate: DROPOFF3 JOB1 20 Pending ID_PICKUP2 Goal "z" "None" {OPEN} 0 ',
        f'< QueueUpdate: DROPOFF4 JOB1 20 Pending ID_DROPOFF3 Goal "x" "None" {OPEN} 0 '),
    'queueCancel of a pending job, p. 193-194': (
        '> queuePickup x 10 j', '* skip', '* exchange', '> queueCancel id pickup1 default reason',
        '< queuecancel cancelling "id" "pickup1" "" "reason" from queue',
        '* wait 16', '* exchange',
        f'< QueueUpdate: PICKUP1 j 10 Cancelled reason Goal "x" "None" {AT} {LATER} 0 '),
    'queueCancel of a job in progress, p. 193-194': (
        '> queuePickup x 10 j', '* served r', '* skip', '> queueCancel jobId J echoit why',
        '< queuecancel cancelling "jobId" "J" "echoit" "why" from queue',
        f'< QueueUpdate: PICKUP1 j 10 Cancelling why Goal "x" "r" {OPEN} 0 ',
        '* wait 16', '* exchange',
        f'< QueueUpdate: PICKUP1 j 10 Interrupted None Goal "x" "r" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP1 j 10 Cancelled why Goal "x" "r" {AT} {LATER} 0 '),
    'queueCancel by robot and by status, and without reason, p. 192': (
        '> queueCancel robotName r',
        '< queuecancel cancelling "robotName" "r" "" "None" from queue',
        '> queueCancel status pending',
        '< queuecancel cancelling "status" "pending" "" "None" from queue',
        '> queuecancel status inprogress',
        '< queuecancel cancelling "status" "inprogress" "" "None" from queue',
        '> queueCancel status interrupted',
        '< queuecancel cancelling "status" "interrupted" "" "None" from queue'),
    'queueCancel of what is not there: clients wait for "failed"': (
        '> queuecancel jobid X', '< CommandError: queuecancel jobid X',
        '< CommandErrorDescription: queueCancel failed: there is no active job with jobid "X"'),
    'queueModify of a priority, p. 203-205': (
        '* number 5', '> queuePickup x', '* skip', '> queueModify pickup5 priority 6',
        '< queuemodify modifying id pickup5 priority 6',
        f'< QueueUpdate: PICKUP5 JOB5 10 BeforeModify None Goal "x" "None" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP5 JOB5 6 AfterModify None Goal "x" "None" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP5 JOB5 6 Pending None Goal "x" "None" {OPEN} 0 '),
    'queueModify of a goal while the robot drives, p. 201-205': (
        '* number 5', '> queuePickup x', '* served r', '* drives', '* skip',
        '> queueModify pickup5 goal y',
        '< queuemodify modifying id pickup5 goal "y"',
        f'< QueueUpdate: PICKUP5 JOB5 10 BeforeModify Driving Goal "x" "r" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP5 JOB5 10 InterruptedByModify None Goal "x" "r" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP5 JOB5 10 AfterModify None Goal "y" "r" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP5 JOB5 10 Pending None Goal "y" "None" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP5 JOB5 10 InProgress UnAllocated Goal "y" "r" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP5 JOB5 10 InProgress Allocated Goal "y" "r" {OPEN} 0 '),
    'a goal that is not there, p. 46': (
        '> queuePickup goal6', '< CommandError: queuePickup goal6',
        '< CommandErrorDescription: queuePickup no such goal "goal6"'),
    'a job id again: an error while its job is active, then not, p. 225': (
        '* number 12', '> queuePickup x 10 xyz', '* skip', '> queuePickup y 10 xyz',
        '< CommandError: queuePickup y 10 xyz',
        '< CommandErrorDescription: queuePickup job_id "xyz" is the id of an active job',
        '* served r', '* done', '* skip', '> queuePickup y 10 xyz',
        '< queuepickup goal "y" with priority 10 id PICKUP13 and job_id xyz successfully queued',
        f'< QueueUpdate: PICKUP13 xyz 10 Pending None Goal "y" "None" {OPEN} 0 '),
    'substates of steps, p. 48-49': (
        '> queuePickupDropoff x y 10 20 j', '* served r', '* skip', '* waits',
        f'< QueueUpdate: PICKUP1 j 10 InProgress Driving Goal "x" "r" {OPEN} 0 ',
        f'< QueueUpdate: PICKUP1 j 10 InProgress BeforePickup Goal "x" "r" {OPEN} 0 ',
        '* works', f'< QueueUpdate: PICKUP1 j 10 InProgress AfterPickup Goal "x" "r" {OPEN} 0 ',
        '* done', '* skip', '* waits',
        f'< QueueUpdate: DROPOFF2 j 20 InProgress Driving Goal "y" "r" {OPEN} 0 ',
        f'< QueueUpdate: DROPOFF2 j 20 InProgress BeforeDropoff Goal "y" "r" {OPEN} 0 ',
        '* works', f'< QueueUpdate: DROPOFF2 j 20 InProgress AfterDropoff Goal "y" "r" {OPEN} 0 '),
    'Failed and Interrupted, p. 224, 235': (
        '> queuePickup x 10 j', '* served r', '* skip', '* paused',
        f'< QueueUpdate: PICKUP1 j 10 Interrupted None Goal "x" "r" {OPEN} 0 ', '* failed',
        f'< QueueUpdate: PICKUP1 j 10 Failed None Goal "x" "r" {AT} {AT} 0 '),
    # -- lists -------------------------------------------------------------------------------------
    'queueShow, p. 230-231': (
        '* robot 21 InProgress Driving', '* robot robot_1 Available Parked', '* number 4',
        '* clock 2012 11 14 11 49 34', '> queuePickup 7', '* served 21', '* drives', '* skip',
        '> queueShow', '< QueueRobot: "21" InProgress Driving ""',
        '< QueueRobot: "robot_1" Available Parked ""',  # a real line
        '< QueueShow: PICKUP4 JOB4 10 InProgress Driving Goal "7" "21" 11/14/2012 11:49:34 None '
        'None "" 0', '< EndQueueShow'),
    'queueQuery: a real line': (
        '* number 1128', '* clock 2026 5 13 12 25 6', '> queuePickup rack_1 10 JOB_ID',
        '* served robot_1', '* wait 158', '* done', '* skip', '> queueQuery jobId JOB_ID',
        '< QueueQuery: PICKUP1128 JOB_ID 10 Completed None Goal "rack_1" "robot_1" '
        '05/13/2026 12:25:06 05/13/2026 12:27:44 "" 0', '< EndQueueQuery',
        '> queueShowCompleted',
        '< QueueShow: PICKUP1128 JOB_ID 10 Completed None Goal "rack_1" "robot_1" '
        '05/13/2026 12:25:06 05/13/2026 12:27:44 "" 0', '< EndQueueShowCompleted'),
    'queueQuery by status, higher priority first, p. 224-225': (
        '> queuePickup x 1 a', '* skip', '> queuePickup y 30 b', '* skip',
        '> queueQuery status pending echo1',
        f'< QueueQuery: PICKUP2 b 30 Pending None Goal "y" "None" {OPEN} echo1 0',
        f'< QueueQuery: PICKUP1 a 1 Pending None Goal "x" "None" {OPEN} echo1 0',
        '< EndQueueQuery', '> queueQuery status completed', '< EndQueueQuery',
        '> queueQuery status cancelled', '< EndQueueQuery', '> queueQuery status failed',
        '< EndQueueQuery', '> queueQuery robotName r', '< EndQueueQuery',
        '> queueQuery id PICKUP9', '< EndQueueQuery'),
    'queueShowRobot, p. 36, 234': (
        '* robot 21 InProgress Driving', '* robot robot_1 Available Parked',
        '> queueShowRobot default echoit', '< QueueRobot: "21" InProgress Driving echoit',
        '< QueueRobot: "robot_1" Available Parked echoit', '< EndQueueShowRobot',
        '> queueShowRobot robot_1', '< QueueRobot: "robot_1" Available Parked ""',
        '< EndQueueShowRobot'),
    'empty lists, p. 230-234': (
        '> queueShow', '< EndQueueShow', '> queueShowCompleted', '< EndQueueShowCompleted',
        '> queueShowRobot', '< EndQueueShowRobot'),
    # -- other queries of clients ------------------------------------------------------------------
    'queryFaults, p. 187: a client reads on until EndQueryFaults': (
        '* robot a Available Available', '* robot b UnAvailable EStopPressed',
        '* robot c UnAvailable Fault_Driving_Application_failed',
        '> queryFaults',
        '< RobotFaultQuery: "b" Fault_Driving EStopPressed "EStopPressed" "b serves no jobs '
        '(EStopPressed)" true false false ""',
        '< RobotFaultQuery: "c" Fault_Driving_Application failed "failed" "c serves no jobs '
        '(failed)" true false true ""', '< EndQueryFaults',
        '> queryFaults A', '< EndQueryFaults', '> queryFaults d', '< CommandError: queryFaults d',
        '< CommandErrorDescription: queryFaults no such robot "d"'),
    'getDateTime, p. 127': (
        '* clock 2012 5 3 4 48 55', '> getDateTime', '< DateTime: 05/03/2012 04:48:55'),
    'getGoals, p. 128': (
        '> getGoals', '< Goal: x', '< Goal: y', '< Goal: z', '< Goal: goal 4', '< Goal: 7',
        '< Goal: rack_1', '< End of goals'),
    'sections: PyARCL refuses to queue without them': (
        '> getConfigSectionList', '< GetConfigSectionList: Queuing Manager',
        '< EndOfGetConfigSectionList', '> getConfigSectionValues Queuing Manager',
        '< GetConfigSectionValue: DefaultPickupPriority 10',
        '< GetConfigSectionValue: DefaultDropoffPriority 20',
        '< GetConfigSectionValue: MaxNumberOfCompletedItems 100',
        '< GetConfigSectionValue: DeleteCompletedItemsMinutes 60', '< EndOfGetConfigSectionValues',
        '> getconfigsectionvalues General', '< CommandError: getconfigsectionvalues General',
        '< CommandErrorDescription: getConfigSectionValues No section of name "General"'),
    'groups that PyARCL reads': (
        '> queuePickup x', '* skip', '> getDataStoreGroupList',
        '< GetDataStoreGroupList: FleetRobotInformation', '< GetDataStoreGroupList: JobCounts',
        '< GetDataStoreGroupList: QueueInformation', '< GetDataStoreGroupList: Versions',
        '< EndOfGetDataStoreGroupList', '> getDataStoreGroupValues QueueInformation',
        '< GetDataStoreGroupValues: QueueSizePending 1', '< EndOfGetDataStoreGroupValues',
        '> getDataStoreGroupValues JobCounts', '< GetDataStoreGroupValues: CompletedJobs 0',
        '< GetDataStoreGroupValues: CancelledJobs 0', '< EndOfGetDataStoreGroupValues',
        '> getDataStoreGroupValues FleetRobotInformation', '< GetDataStoreGroupValues: Robots 0',
        '< EndOfGetDataStoreGroupValues', '> getDataStoreGroupValues Versions',
        f'< GetDataStoreGroupValues: omron_jobs {VERSION}', '< EndOfGetDataStoreGroupValues'),
    'payload: robots of this fleet have no slots, p. 170-179': (
        '> payloadQuery', '< EndPayloadQuery', '> payloadSlotCount', '< EndPayloadSlotCount'),
    'an empty line has no answer': ('> ', '> \t '),
    # -- syntax ------------------------------------------------------------------------------------
    'missing arguments: the syntax line, p. 44': (
        '> queuePickup', '< usage: queuePickup <goal> [priority or "default"] [job_id]',
        '> queuePickupDropoff x', '< usage: queuePickupDropoff <pickup goal> <dropoff goal> '
        '[priority1 or "default"] [priority2 or "default"] [job_id]',
        '> queueCancel id', '< usage: queueCancel <id, jobId, robotName or status> <value> [echo '
        'or "default"] [reason]',
        '> queueModify PICKUP1 goal', '< usage: queueModify <id> <goal or priority> <value>',
        '> queueQuery id', '< usage: queueQuery <id, jobId, robotName or status> <value> [echo]',
        '> queueMulti 1', '< usage: queueMulti <number of goals> <2> <goal> <pickup or dropoff> '
        '<priority or "default"> ... [job_id]'),
    'priorities are signed 32-bit integers, p. 45': (
        '> queuePickup x -2147483648 a', '* skip', '> queuePickup x 2147483647 b',
        '< queuepickup goal "x" with priority 2147483647 id PICKUP2 and job_id b successfully '
        'queued', f'< QueueUpdate: PICKUP2 b 2147483647 Pending None Goal "x" "None" {OPEN} 0 ',
        '> queuePickup x -2147483649', '< CommandError: queuePickup x -2147483649',
        '< CommandErrorDescription: queuePickup needs a whole number in the place of '
        '"-2147483649"'),
}


ACTS: Dict[str, DriveAct] = {
    'drives': DriveAct.DRIVES, 'waits': DriveAct.WAITS, 'works': DriveAct.WORKS}
STATES = {'paused': JobMissionState.PAUSED, 'failed': JobMissionState.FAILED}


class Conversation:
    """Carries out rows, and compares the lines that both clients get.

    job -- number of the job to which the acts of the fleet apply; -1: the last job
    """

    def __init__(self, line: Line) -> None:
        self.line, self.job = line, -1

    def check(self, wanted: Sequence[str]) -> None:
        """Checks the lines since the last check: replies go to one client, changes to both."""
        told = bytes(self.line.client.output)
        assert told == b''.join(one.encode() + b'\r\n' for one in wanted)
        self.skip()

    def skip(self) -> None:
        changes = [one for one in self.line.heard() if one.startswith('QueueUpdate: ')]
        assert self.line.heard(self.line.other) == changes

    def act(self, verb: str, *words: str) -> None:
        line = self.line
        if verb == 'skip':
            self.skip()
        elif verb == 'number':
            line.book.counters = line.book.counters._replace(number=int(words[0]))
        elif verb == 'clock':
            year, month, day, hour, minute, second = map(int, words)
            line.now_ms = 1000 * calendar.timegm((year, month, day, hour, minute, second))
        elif verb == 'robot':
            name, status, substatus = words
            line.site.robots = {**line.site.robots,
                                name: RobotNews(RobotStatus(status), substatus)}
        elif verb == 'job':
            self.job = int(words[0])
        elif verb == 'wait':
            line.wait(float(words[0]))
        else:
            self.drive(verb, *words)

    def drive(self, verb: str, *words: str) -> None:
        """Does an act of the fleet. The lines that follow wait for the next check."""
        line, key = self.line, self.line.key(self.job)
        for message in line.book.due(line.now):
            for one, shown in line.fleet.handle(message):
                line.server.announce(tell(line.book, one, shown, line.now))
        if verb in ACTS:
            drives = {mission: drive._replace(act=ACTS[verb])
                      for mission, drive in line.fleet.drives().items()}
            line.server.announce(line.book.hear_drives(drives))
        elif verb != 'exchange':
            if verb == 'done':
                line.fleet.reach(key)
            else:
                line.fleet.set(key, ACTIVE if verb == 'served' else STATES[verb], *words)
            line.server.announce(
                tell(line.book, key, line.fleet.missions[key].shown, line.now))


@pytest.mark.parametrize('source', ROWS)
def test_the_server_sends_the_lines_of(line: Line, source: str) -> None:
    line.site.goals = {**line.site.goals, '7': 7, 'rack_1': 8}
    conversation = Conversation(line)
    wanted: List[str] = []
    for step in (*ROWS[source], '> '):
        kind, text = step[:2], step[2:]
        if kind == '< ':
            wanted.append(text)
            continue
        if wanted or kind == '> ':
            conversation.check(wanted)
            wanted = []
        if kind == '> ':
            line.client.receive(text.encode() + b'\r\n')
        else:
            conversation.act(*text.split())


@pytest.mark.parametrize('short, name, rest', [
    ('qp', 'queuePickup', 'x'), ('qpd', 'queuePickupDropoff', 'x y'),
    ('qm', 'queueMulti', '1 2 x pickup 3'), ('qc', 'queueCancel', 'id X'),
    ('qmod', 'queueModify', 'X goal y'), ('qq', 'queueQuery', 'id X'), ('qs', 'queueShow', ''),
    ('qsc', 'queueShowCompleted', ''), ('qsr', 'queueShowRobot', ''), ('pq', 'payloadQuery', ''),
    ('psc', 'payloadSlotCount', ''), ('qf', 'queryFaults', '')])
def test_commands_have_shortcuts_and_no_case(short: str, name: str, rest: str) -> None:
    short_one, *others = [
        [told for told in Line().say(f'{one} {rest}') if not told.startswith('CommandError: ')]
        for one in (short, name, name.lower(), name.upper())]
    assert short_one and not short_one[0].startswith('Unknown')
    assert others == [short_one] * 3


@pytest.mark.parametrize('command', [
    'queueDropoff', 'qd', 'queueCancelLocal', 'qcl', 'queueModifyLocal', 'qmodl',
    'queueQueryLocal', 'qql', 'queueShowRobotLocal', 'qsrl', 'pauseTaskCancel', 'waitTaskCancel',
    'modeUnlock'])
def test_what_only_a_robot_takes_is_refused(line: Line, command: str) -> None:
    told = line.say(f'{command} x')
    assert told[0] == f'CommandError: {command} x'
    assert told[1].endswith('is a command of a robot; the fleet manager does not take it')


@pytest.mark.parametrize('command', [
    # commands that a Fleet Manager does not have
    'status', 'goto', 'stop', 'doTask', 'getRobots', 'queueMultiple', 'queueDropoffList',
    'goalAndTask',
    # commands of a Fleet Manager that this server does not offer
    'log', 'arclSendText', 'popupSimple', 'connectOutgoing', 'configAdd', 'configStart',
    'getConfigSectionInfo', 'getDataStoreFieldInfo', 'newConfigParam', 'mapObjectList', 'extIOAdd',
    'tripReset'])
def test_a_command_that_is_not_there_is_unknown(line: Line, command: str) -> None:
    assert line.say(f'{command} x') == [f'Unknown command {command[:16]}']


def test_known_clients_find_their_words(line: Line) -> None:
    line.site.robots = {'r': RobotNews(RobotStatus.AVAILABLE, 'Available')}
    told = line.say('queuePickup x')
    assert [told[0].split(' ')[k] for k in (7, 10)] == ['PICKUP1', 'JOB1']
    assert len(told[1].split(' ')) == 15 and told[1].split(' ')[13] == '0'  # a client requires it
    told = line.say('queuePickupDropoff x y')
    assert [told[0].split(' ')[k] for k in (11, 13, 15)] == ['PICKUP2', 'DROPOFF3', 'JOB2']
    told = line.say('queueMulti 1 2 x pickup 3')
    assert [told[0].split(' ')[k] for k in (2, 5, 7, 10)] == ['"x"', '3', 'PICKUP4', 'JOB4']
    shown = [one for one in line.say('queueShow') if one.startswith('QueueShow: ')]
    assert {len(one.split(' ')) for one in shown} == {15}
    assert {one.split(' ')[14] for one in shown} == {'0'}
    queried = line.say('queueQuery jobId JOB2')
    assert [one.split(' ')[13] for one in queried[:-1]] == ['""', '""']
