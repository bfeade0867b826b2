"""Command lines of clients, and their effects. OMRON's own lines are in test_job_lines."""
from __future__ import annotations

from typing import List, Tuple

import pytest
from job_fleet import tell
from job_line import ACTIVE, AT, Line

from omron_jobs.core.job_book import FleetAct
from omron_jobs.core.job_words import RobotStatus
from omron_jobs.core.jobs import DriveAct, JobDrive, JobMissionState
from omron_jobs.core.robots import RobotNews


def updates(lines: List[str]) -> List[Tuple[str, ...]]:
    """Segment, status and substatus of each line."""
    assert all(line.startswith('QueueUpdate: ') for line in lines)
    return [tuple(line.split()[k] for k in (1, 4, 5)) for line in lines]


# -- a pickup from its line to its end -------------------------------------------------------------


@pytest.mark.parametrize('goals', ['x y', 'x y 10 20', 'x y default 20', 'x y default default'])
def test_a_pickup_and_its_drop_off(line, goals):
    line.book.counters = line.book.counters._replace(number=12)
    assert line.say(f'queuePickupDropoff {goals}') == [
        'queuepickupdropoff goals "x" and "y" with priorities 10 and 20 ids PICKUP12 and DROPOFF13 '
        'job_id JOB12 successfully queued',
        f'QueueUpdate: PICKUP12 JOB12 10 Pending None Goal "x" "None" {AT} None None 0 ',
        f'QueueUpdate: DROPOFF13 JOB12 20 Pending ID_PICKUP12 Goal "y" "None" {AT} None None 0 ']
    line.exchange()
    line.set(ACTIVE, 'Lynx1')
    assert updates(line.reach()) == [
        ('PICKUP12', 'Completed', 'None'), ('DROPOFF13', 'InProgress', 'UnAllocated'),
        ('DROPOFF13', 'InProgress', 'Allocated'), ('DROPOFF13', 'InProgress', 'Driving')]
    assert line.reach() == [
        f'QueueUpdate: DROPOFF13 JOB12 20 Completed None Goal "y" "Lynx1" {AT} {AT} 0 ']


def test_a_job_of_several_goals(line):
    replies = [
        'QueueMulti: goal "x" with priority 10 id PICKUP1 and job_id JOB1 successfully queued',
        'QueueMulti: goal "y" with priority 19 id PICKUP2 and job_id JOB1 successfully queued and '
        'linked to PICKUP1',
        'QueueMulti: goal "z" with priority 20 id DROPOFF3 and job_id JOB1 successfully queued and '
        'linked to PICKUP2',
        'QueueMulti: goal "x" with priority 20 id DROPOFF4 and job_id JOB1 successfully queued and '
        'linked to DROPOFF3',
        'EndQueueMulti']
    told = line.say('queueMulti 4 2 x pickup 10 y pickup 19 z dropoff 20 x dropoff default')
    assert told[:5] == replies
    assert updates(told[5:]) == [
        ('PICKUP1', 'Pending', 'None'), ('PICKUP2', 'Pending', 'ID_PICKUP1'),
        ('DROPOFF3', 'Pending', 'ID_PICKUP2'), ('DROPOFF4', 'Pending', 'ID_DROPOFF3')]
    line.exchange()
    assert line.fleet.missions[line.key()].shown.priority == 10
    line.set(ACTIVE, '21')
    chain = []
    for _ in range(4):
        chain += [told for told in updates(line.reach()) if told[1] == 'Completed']
    assert [one for one, *_ in chain] == ['PICKUP1', 'PICKUP2', 'DROPOFF3', 'DROPOFF4']


def test_ids_of_jobs_are_those_of_their_first_segments_and_can_be_used_again(line):
    line.say('queuePickupDropoff x y')
    line.say('queuePickup x default own')
    assert [(job.id, [one.id for one in job.segments]) for job in line.book.jobs] == [
        ('JOB1', ['PICKUP1', 'DROPOFF2']), ('own', ['PICKUP3'])]
    assert line.say('qp x 10 OWN') == [
        'CommandError: qp x 10 OWN',
        'CommandErrorDescription: queuePickup job_id "OWN" is the id of an active job']
    line.exchange()
    line.set(ACTIVE, 'r')
    line.reach()
    assert line.say('queuePickup x 10 own')[0] == (
        'queuepickup goal "x" with priority 10 id PICKUP4 and job_id own successfully queued')


def test_an_id_made_here_is_never_that_of_an_active_job(line):
    line.say('queuePickup x default JOB2')
    assert 'id PICKUP3 and job_id JOB3' in line.say('queuePickup x')[0]


def test_the_number_of_segments_grows_over_restarts(line):
    line.say('queuePickup x')
    assert 'id PICKUP2 and job_id JOB2' in Line(line.disk, line.fleet).say('queuePickup x')[0]


# -- cancel and modify -----------------------------------------------------------------------------


def test_a_job_in_progress_is_cancelled_with_all_that_follows(line):
    line.say('queuePickupDropoff x y')
    line.exchange()
    line.set(ACTIVE, 'r')
    told = line.say('queueCancel jobId job1')
    assert told[0] == 'queuecancel cancelling "jobId" "job1" "" "None" from queue'
    assert updates(told[1:]) == [('PICKUP1', 'Cancelling', 'None')]
    assert updates(line.exchange()) == [
        ('PICKUP1', 'Interrupted', 'None'), ('PICKUP1', 'Cancelled', 'None'),
        ('DROPOFF2', 'Cancelled', 'None')]


@pytest.mark.parametrize('words, cancelled', [
    ('status pending', {'a', 'b'}), ('status inprogress', {'c'}), ('status INTERRUPTED', set()),
    ('robotName R1', {'c'}), ('robotname r2', set()), ('jobid b', {'b'}), ('id pickup2', {'b'})])
def test_jobs_are_cancelled_by_what_they_have_in_common(line, words, cancelled):
    for id in 'abc':
        line.say(f'queuePickup x 10 {id}')
    line.exchange()
    line.set(ACTIVE, 'r1')
    assert line.say(f'queueCancel {words}')[0].startswith('queuecancel cancelling ')
    line.exchange()
    assert {job.id for job in line.book.jobs if not job.is_open} == cancelled


@pytest.mark.parametrize('words', ['jobId none', 'id PICKUP9'])
def test_a_job_that_is_not_there_cannot_be_cancelled(line, words):
    kind, value = words.split()
    assert line.say(f'queueCancel {words}') == [
        f'CommandError: queueCancel {words}',
        f'CommandErrorDescription: queueCancel failed: there is no active job with {kind.lower()} '
        f'"{value}"']


def test_a_cancellation_is_repeated_until_the_mission_has_ended_also_after_a_restart(line):
    line.say('queuePickup x 10 j')
    line.exchange()
    line.say('queueCancel jobId j')
    again = Line(line.disk, line.fleet)  # the command was lost with the first server
    for _ in range(3):
        again.exchange()
        again.wait(3)
    assert [one.told.status.value for one in again.book.jobs[0].segments] == ['Cancelled']


def test_a_priority_changes_while_a_segment_waits(line):
    line.say('queuePickup x 10 j')
    line.exchange()
    assert line.say('queueModify pickup1 priority 6') == [
        'queuemodify modifying id pickup1 priority 6', *(
            f'QueueUpdate: PICKUP1 j {told} None Goal "x" "None" {AT} None None 0 '
            for told in ('10 BeforeModify', '6 AfterModify', '6 Pending'))]
    line.exchange()
    assert line.fleet.missions[line.key()].shown.priority == 6
    line.set(ACTIVE, 'r')
    assert line.say('queueModify pickup1 priority 7')[1] == (
        'CommandErrorDescription: queueModify failed: no segment "pickup1" is Pending')


def test_a_change_of_priority_that_is_lost_or_refused_is_sent_again(line):
    line.say('queuePickup x 10 j')
    line.exchange()
    line.fleet.refuses_changes = True
    line.say('queueModify pickup1 priority 6')
    assert line.exchange() == []
    line.fleet.refuses_changes = False
    line.wait(3)
    assert line.book.due(line.now)[0].act is FleetAct.CHANGE  # this message is lost
    again = Line(line.disk, line.fleet)
    for _ in range(3):
        again.exchange()
        again.wait(3)
    assert line.fleet.missions[line.key()].shown.priority == 6
    assert again.book.due(again.now) == []


def test_a_segment_is_driving_when_its_robot_drives_to_its_goal(line):
    line.say('queuePickupDropoff x y 10 20 j')
    line.exchange()
    line.fleet.set(line.key(), ACTIVE, 'r')
    assert updates(line.show(line.key())) == [
        ('PICKUP1', 'InProgress', 'UnAllocated'), ('PICKUP1', 'InProgress', 'Allocated')]
    for other in (JobDrive('r2', 1), JobDrive('r', 2)):
        assert line.book.hear_drives({line.key()[0]: other}) == []
    assert updates(line.drive()) == [('PICKUP1', 'InProgress', 'Driving')]
    assert line.book.hear_drives({}) == []  # the robot waits for another robot
    line.fleet.reach(line.key())
    assert updates(line.show(line.key())) == [
        ('PICKUP1', 'Completed', 'None'), ('DROPOFF2', 'InProgress', 'UnAllocated'),
        ('DROPOFF2', 'InProgress', 'Allocated')]
    line.fleet.reach(line.key())
    assert updates(line.show(line.key())) == [
        ('DROPOFF2', 'InProgress', 'Driving'), ('DROPOFF2', 'Completed', 'None')]


def test_the_steps_at_a_goal_are_told_before_and_after(line):
    line.say('queuePickupDropoff x y 10 20 j')
    line.exchange()
    line.set(ACTIVE, 'r')
    for act, sub in ((DriveAct.WAITS, 'BeforePickup'), (DriveAct.WORKS, 'AfterPickup')):
        assert updates(line.drive(act)) == [('PICKUP1', 'InProgress', sub)]
    assert line.drive(DriveAct.DRIVES) == []  # the substatus does not go back
    line.fleet.reach(line.key())
    assert updates(line.show(line.key())) == [
        ('PICKUP1', 'Completed', 'None'), ('DROPOFF2', 'InProgress', 'UnAllocated'),
        ('DROPOFF2', 'InProgress', 'Allocated')]
    assert updates(line.drive(DriveAct.WORKS)) == [
        ('DROPOFF2', 'InProgress', 'Driving'), ('DROPOFF2', 'InProgress', 'AfterDropoff')]
    assert updates(line.reach()) == [('DROPOFF2', 'Completed', 'None')]


def delivering(line):
    """A job whose robot, Lynx1, has picked up at x and drives to y."""
    line.say('queuePickupDropoff x y 10 20 first')
    line.exchange()
    line.set(ACTIVE, 'Lynx1')
    line.reach()


def test_a_pickup_where_a_running_job_drops_off_is_a_swap_for_its_robot(line):
    delivering(line)
    assert line.say('queuePickupDropoff y z 10 20 second') == [
        'queuepickupdropoff goals "y" and "z" with priorities 10 and 20 ids PICKUP3 and DROPOFF4 '
        'job_id second successfully queued and linked to job_id first',
        f'QueueUpdate: PICKUP3 second 10 Pending None Goal "y" "Lynx1" {AT} None None 0 ',
        f'QueueUpdate: DROPOFF4 second 20 Pending ID_PICKUP3 Goal "z" "Lynx1" {AT} None None 0 ']
    message, = line.book.due(line.now)
    assert (message.act, message.job.robot) == (FleetAct.REQUEST, 'Lynx1')
    for key, shown in line.fleet.handle(message):
        line.server.announce(tell(line.book, key, shown, line.now))
    assert line.heard() == []  # the waiting job keeps the name of its robot
    assert 'linked' not in line.say('queuePickupDropoff y z')[0]  # a robot can have only one swap


def test_there_is_no_swap_before_the_robot_carries_the_load_and_after_a_cancellation(line):
    line.say('queuePickupDropoff x y 10 20 first')
    line.exchange()
    line.set(ACTIVE, 'Lynx1')
    assert 'linked' not in line.say('queuePickupDropoff y z')[0]
    line.reach(0)
    assert 'linked' not in line.say('queuePickupDropoff x z')[0]
    line.say('queueCancel jobId first')
    assert 'linked' not in line.say('queuePickupDropoff y z')[0]


def test_a_swap_outlives_a_restart(line):
    delivering(line)
    line.say('queuePickupDropoff y z 10 20 second')
    again = Line(line.disk, line.fleet)
    assert [job.robot for job in again.book.jobs] == ['', 'Lynx1']


def test_another_robot_begins_with_the_steps_anew(line):
    line.say('queuePickup x')
    line.exchange()
    line.set(ACTIVE, 'r')
    line.drive(DriveAct.WORKS)
    line.fleet.set(line.key(), ACTIVE, 'other')
    assert updates(line.show(line.key())) == [('PICKUP1', 'Interrupted', 'None'), *(
        ('PICKUP1', 'InProgress', sub) for sub in ('UnAllocated', 'Allocated'))]


def test_the_goal_of_a_segment_does_not_change_when_its_robot_works_there(line):
    line.say('queuePickup x')
    line.exchange()
    line.set(ACTIVE, 'r')
    line.drive(DriveAct.WORKS)
    assert line.say('queueModify PICKUP1 goal y')[1] == (
        'CommandErrorDescription: queueModify failed: the robot works at the goal of "PICKUP1" '
        'already')


def test_the_goal_of_a_segment_that_waits_changes(line):
    line.say('queuePickupDropoff x y 10 20 j')
    line.exchange()
    line.set(ACTIVE, 'r')
    assert line.say('queueModify dropoff2 goal z') == [
        'queuemodify modifying id dropoff2 goal "z"',
        f'QueueUpdate: DROPOFF2 j 20 BeforeModify ID_PICKUP1 Goal "y" "None" {AT} None None 0 ',
        f'QueueUpdate: DROPOFF2 j 20 AfterModify None Goal "z" "None" {AT} None None 0 ',
        f'QueueUpdate: DROPOFF2 j 20 Pending ID_PICKUP1 Goal "z" "None" {AT} None None 0 ']
    assert line.say('queueModify dropoff2 goal y')[1].endswith('is just being changed: try again')
    assert line.exchange() == []
    assert line.fleet.missions[line.key()].shown.places == (1, 3)
    line.reach()
    assert line.reach() == [
        f'QueueUpdate: DROPOFF2 j 20 Completed None Goal "z" "r" {AT} {AT} 0 ']


def test_the_goal_of_a_segment_changes_while_its_robot_drives(line):
    line.say('queuePickup x 10 j')
    line.exchange()
    line.set(ACTIVE, 'r')
    assert line.say('queueModify pickup1 goal y')[1:] == [
        f'QueueUpdate: PICKUP1 j 10 {told} {AT} None None 0 ' for told in (
            'BeforeModify Driving Goal "x" "r"', 'InterruptedByModify None Goal "x" "r"',
            'AfterModify None Goal "y" "r"', 'Pending None Goal "y" "None"',
            'InProgress UnAllocated Goal "y" "r"', 'InProgress Allocated Goal "y" "r"')]
    assert line.drive() == []  # the robot still drives to the old goal
    line.exchange()
    assert updates(line.drive()) == [('PICKUP1', 'InProgress', 'Driving')]
    assert line.fleet.missions[line.key()].shown.places == (2,)


def test_a_change_of_goal_that_races_the_arrival_goes_back_and_every_client_is_told(line):
    line.say('queuePickupDropoff x y 10 20 j')
    line.exchange()
    line.set(ACTIVE, 'r')
    line.fleet.reach(line.key())  # the job server does not know this yet
    line.say('queueModify pickup1 goal z')
    assert line.exchange()[:5] == [
        f'QueueUpdate: PICKUP1 j 10 {told} "r" {AT} {end} 0 ' for told, end in (
            ('BeforeModify Allocated Goal "z"', 'None None'),
            ('AfterModify None Goal "x"', 'None None'),
            ('InProgress Allocated Goal "x"', 'None None'),
            ('InProgress Driving Goal "x"', 'None None'), ('Completed None Goal "x"', AT))]
    assert line.say('queueQuery id pickup1')[0].startswith(
        'QueueQuery: PICKUP1 j 10 Completed None Goal "x"')
    assert line.fleet.missions[line.key()].shown.places == (1, 2)
    assert line.say('queueModify pickup1 goal z')[1].endswith('is Pending or InProgress')


def test_a_change_of_goal_that_the_fleet_manager_refuses_goes_back(line):
    line.say('queuePickup x 10 j')
    line.exchange()
    line.fleet.refuses_changes = True
    line.say('queueModify pickup1 goal y')
    assert updates(line.exchange()) == [('PICKUP1', told, 'None') for told in (
        'BeforeModify', 'AfterModify', 'Pending')]
    assert line.say('queueShow')[-2].startswith('QueueShow: PICKUP1 j 10 Pending None Goal "x"')
    line.wait(3)
    assert line.exchange() == [] and line.book.due(line.now + 3) == []


# -- lists -----------------------------------------------------------------------------------------


def test_jobs_and_robots_are_listed(line):
    line.book.counters = line.book.counters._replace(number=4)
    line.site.robots = {'21': RobotNews(RobotStatus.IN_PROGRESS, 'Driving'),
                        'robot_1': RobotNews(RobotStatus.AVAILABLE, 'Parked')}
    line.site.goals['7'] = 7
    line.say('queuePickup 7')
    line.exchange()
    line.set(ACTIVE, '21')
    driving = f'PICKUP4 JOB4 10 InProgress Driving Goal "7" "21" {AT} None None'
    assert line.say('queueShow') == [
        'QueueRobot: "21" InProgress Driving ""', 'QueueRobot: "robot_1" Available Parked ""',
        f'QueueShow: {driving} "" 0', 'EndQueueShow']
    assert line.say('queueShow echoit')[2] == f'QueueShow: {driving} echoit 0'
    assert line.say('queueShowRobot default echoit') == [
        'QueueRobot: "21" InProgress Driving echoit',
        'QueueRobot: "robot_1" Available Parked echoit',
        'EndQueueShowRobot']
    assert line.say('qsr ROBOT_1') == ['QueueRobot: "robot_1" Available Parked ""',
                                       'EndQueueShowRobot']
    assert line.say('queueShowCompleted') == ['EndQueueShowCompleted']
    line.reach()
    assert line.say('queueShowCompleted') == [
        f'QueueShow: PICKUP4 JOB4 10 Completed None Goal "7" "21" {AT} {AT} "" 0',
        'EndQueueShowCompleted']


def test_the_list_has_all_open_segments_and_the_last_ones_that_have_ended(line):
    for k in range(15):
        line.say(f'queuePickup x 10 j{k}')
        line.exchange()
        if k:
            line.set(ACTIVE, 'r')
            line.reach()
    assert [told.split()[2] for told in line.say('queueShow')[:-1]] == [
        'j0', *(f'j{k}' for k in range(4, 15))]


# -- bad input -------------------------------------------------------------------------------------


@pytest.mark.parametrize('text, told', [
    ('queuePickup goal6', ['CommandError: queuePickup goal6',
                           'CommandErrorDescription: queuePickup no such goal "goal6"']),
    ('queuePickup', ['usage: queuePickup <goal> [priority or "default"] [job_id]']),
    ('goto x', ['Unknown command goto']),
    ('aVeryLongNameOfACommand', ['Unknown command aVeryLongNameOfA']),
    ('queuePickup x ten', [
        'CommandError: queuePickup x ten',
        'CommandErrorDescription: queuePickup needs a whole number in the place of "ten"']),
    ('queuePickup x 2147483648', [
        'CommandError: queuePickup x 2147483648',
        'CommandErrorDescription: queuePickup needs a whole number in the place of "2147483648"']),
    ('queueMulti 1 2 x dropoff 10', [
        'CommandError: queueMulti 1 2 x dropoff 10',
        'CommandErrorDescription: queueMulti needs a pickup as its first goal']),
    ('queueDropoff x', [
        'CommandError: queueDropoff x',
        'CommandErrorDescription: queueDropoff is a command of a robot; the fleet manager does not '
        'take it']),
    ('queueModify PICKUP1 goal y', [
        'CommandError: queueModify PICKUP1 goal y',
        'CommandErrorDescription: queueModify failed: no segment "PICKUP1" is Pending or '
        'InProgress']),
    ('queueModify PICKUP1 goal nowhere', [
        'CommandError: queueModify PICKUP1 goal nowhere',
        'CommandErrorDescription: queueModify no such goal "nowhere"'])])
def test_bad_input_is_answered_in_words_and_queues_nothing(line, text, told):
    assert line.say(text) == told
    assert line.book.jobs == ()


def test_extra_arguments_are_ignored_and_quoted_goals_are_read(line):
    assert 'goal "goal 4"' in line.say('queuePickup "goal 4" 10 j more')[0]


def test_a_goal_is_also_named_by_the_id_of_its_vertex(line):
    assert 'goal "2"' in line.say('queuePickup 2')[0]
    assert line.book.jobs[0].segments[0].vertex == 2
    assert line.say('queuePickup 02')[0] == 'CommandError: queuePickup 02'


@pytest.mark.parametrize('text', [
    'queueMulti', 'queueMulti 2 2 x pickup 1', 'queueMulti 51 2', 'queueMulti 0 2',
    'queueMulti 1 3 x pickup 1', 'queueMulti 1 2 x lift 1', 'queueCancel colour red',
    'queueCancel status lost', 'queueQuery status x', 'queueModify a b c', 'queueShowRobot none',
    'getConfigSectionValues Files', 'getDataStoreGroupValues X', 'echo loud',
    f'queuePickup x 10 {"j" * 128}', 'queuePickup x 10 "a b"'])
def test_other_bad_input_is_refused(line, text):
    told = line.say(text)
    assert told[0].startswith(('CommandError: ', 'usage: '))
    assert line.book.jobs == ()


def test_without_a_graph_or_a_disk_nothing_is_queued(line):
    line.disk.is_full = True
    assert line.say('queuePickup x') == [
        'SetUpError: queuePickup is not done: jobs cannot be stored (No space left on device)']
    assert line.exchange() == [] and line.fleet.missions == {} and line.book.jobs == ()
    line.disk.is_full = False
    assert 'id PICKUP1 ' in line.say('queuePickup x')[0]
    line.site.goals = None
    assert line.say('queuePickup x')[1] == (
        'CommandErrorDescription: queuePickup knows no goals yet: is the fleet manager running?')


# -- login -----------------------------------------------------------------------------------------


def test_the_login_shows_the_commands(line):
    client = line.server.connect()
    assert line.heard(client) == ['Enter password:']
    client.receive(b'\r\n  secret\r')
    told = line.heard(client)
    assert told[:3] == ['Welcome to the server.', "You can type 'help' at any time for the "
                        'following help list.', 'Commands:']
    assert told[-1] == 'End of commands'
    assert '    queuePickup          Queues a pickup goal for any appropriate robot [qp]' in told


def test_before_the_password_nothing_is_carried_out_and_nothing_is_told(line):
    client = line.server.connect()
    line.heard(client)
    line.say('queuePickup x')
    assert line.heard(client) == []
    client.receive(b'queuePickup x\r\nsecret\r\nqueuePickup x\r\n')
    assert client.phase.value == 'closed' and line.heard(client) == []
    assert len(line.book.jobs) == 1


def test_a_line_that_is_too_long_ends_its_client(line):
    line.client.receive(b'x' * 5001)
    assert line.heard() == ['String too long']
    assert line.client not in line.server.sessions


def test_lines_are_echoed_after_echo_on(line):
    assert line.say('echo on') == ['Echo turned on.']
    assert line.say('getDateTime') == ['getDateTime', f'DateTime: {AT}']
    assert line.say('echo off') == ['echo off', 'Echo turned off.']
    assert line.say('quit') == ['Closing connection']


# -- how missions end ------------------------------------------------------------------------------


def test_a_mission_that_fails_fails_its_job(line):
    line.say('queuePickupDropoff x y')
    line.exchange()
    line.set(ACTIVE, 'r')
    line.reach()
    assert updates(line.set(JobMissionState.FAILED)) == [('DROPOFF2', 'Failed', 'None')]
    assert [one.told.status.value for one in line.book.jobs[0].segments] == ['Completed', 'Failed']


def test_a_mission_that_is_refused_cancels_its_job(line):
    line.fleet.refuses = True
    line.say('queuePickup x')
    assert updates(line.exchange()) == [('PICKUP1', 'Cancelled', 'RefusedByFleet')]


def test_a_job_that_another_robot_gets_is_interrupted(line):
    line.say('queuePickup x')
    line.exchange()
    line.set(ACTIVE, 'r1')
    assert updates(line.set(JobMissionState.PENDING, '')) == [
        ('PICKUP1', 'Interrupted', 'None'), ('PICKUP1', 'Pending', 'None')]
    told = line.set(ACTIVE, 'r2')
    assert [one.split()[8] for one in told] == ['"r2"'] * 3


def test_a_paused_mission_is_interrupted_until_it_goes_on(line):
    line.say('queuePickup x')
    line.exchange()
    line.set(ACTIVE, 'r1')
    assert updates(line.set(JobMissionState.PAUSED)) == [('PICKUP1', 'Interrupted', 'None')]
    assert updates(line.set(ACTIVE)) == [('PICKUP1', 'InProgress', sub)
                                         for sub in ('UnAllocated', 'Allocated', 'Driving')]


def test_a_mission_that_the_fleet_manager_has_lost_is_not_done_again(line):
    line.say('queuePickup x')
    line.exchange()
    line.book.store_news()
    line.fleet.missions.clear()
    line.wait(11)
    for message in line.book.silent(line.now):
        for key, shown in line.fleet.handle(message):
            line.server.announce(tell(line.book, key, shown, line.now))
    assert updates(line.heard()) == [('PICKUP1', 'Failed', 'None')]
    assert line.fleet.missions == {}
