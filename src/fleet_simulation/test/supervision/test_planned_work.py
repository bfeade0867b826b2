"""Templates, deadlines and timetables in a supervised fleet.

Some tests restart the supervisor or change the clock.
"""
from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from typing import List

import pytest
from fleet_builders import AGV, corridor

from fleet_core.supervision.missions import CommandKind, DeadlineState, MissionState, Request
from fleet_core.supervision.waits import WaitCode
from fleet_core.supervision.why import mission_reason
from fleet_core.work.dependencies import Dependency
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import Station, StationKind
from fleet_core.work.stops import WorkStep, WorkStop
from fleet_core.work.templates import Template, TemplateStop
from fleet_core.work.timetables import Timetable
from fleet_simulation.agv.steps import SimulatedSteps
from world.supervised_fleet import SupervisedFleet

SAY = WorkStep('say', 5.0, (('text', '$to'),))
PALLET = Template('pallet', ('from', 'to'), (
    TemplateStop('$from'), TemplateStop('$to', steps=(SAY,))), (TemplateStop('2'),))
WORK = SiteWork(
    stations={'press': Station('press', (3,)),
              'shelves': Station('shelves', (5, 6), (), 2, StationKind.GROUP)},
    templates={'pallet': PALLET})
ARGUMENTS = (('from', 'press'), ('to', '7'))


class PlannedFleet(SupervisedFleet):
    """One robot on a corridor, with a work file."""

    def __init__(self, work: SiteWork = WORK, **more: object) -> None:
        super().__init__(corridor(8), {'a': (AGV, 1)}, work=work, **more)
        self.steps = {'a': SimulatedSteps(lambda: 1)}

    @property
    def moment(self) -> float:
        """The time in s since 1970, according to the clock of the fleet manager."""
        return self.wall + self.now

    def send(self, id: int, **fields: object) -> None:
        self.do(self.supervisor.request(Request(id, (), **fields), self.now))

    def mission(self, id: int):
        mission = self.supervisor.book.find(id)
        assert mission is not None, self.statuses[-1]
        return mission

    def alarms(self, id: int) -> List[DeadlineState]:
        """The published states of the deadline of a mission, without repetitions."""
        told = [s.deadline_state for s in self.statuses if s.request_id == id]
        return [one for k, one in enumerate(told) if not k or told[k - 1] is not one]


# -- templates ------------------------------------------------------------------------------------


def test_a_template_is_carried_out_with_its_arguments_and_told_with_its_status():
    fleet = PlannedFleet()
    fleet.send(1, template='pallet', arguments=ARGUMENTS)
    request = fleet.mission(1).request
    assert request.destinations == (3, 7)
    assert request.stops[1].steps == (replace(SAY, parameters=(('text', '7'),)),)
    assert request.on_cancel == (WorkStop(2),)
    fleet.run_until_done(1)
    last = fleet.statuses[-1]
    assert (last.state, last.template, last.arguments) == (
        MissionState.SUCCEEDED, 'pallet', ARGUMENTS)


@pytest.mark.parametrize('template, arguments, told', [
    ('palet', ARGUMENTS, "no template 'palet'; there are: pallet"),
    ('pallet', ARGUMENTS[:1], "'to' is not given"),
    ('pallet', (*ARGUMENTS, ('x', '1')), "'x' is no parameter"),
    ('pallet', (*ARGUMENTS, ('to', '1')), "'to' is given twice"),
    ('pallet', (('from', 'pres'), ('to', '7')), "no station and no vertex is named 'pres'")])
def test_a_request_that_does_not_fit_its_template_is_refused(template, arguments, told):
    fleet = PlannedFleet()
    fleet.send(1, template=template, arguments=arguments)
    assert fleet.statuses[-1].state is MissionState.REFUSED
    assert told in fleet.statuses[-1].reason


def test_a_step_type_that_the_site_does_not_have_is_refused_but_never_in_an_open_mission():
    fleet = PlannedFleet()
    stops = (WorkStop(3, steps=(replace(SAY, parameters=()),)),)
    stays = {'destinations': (3,), 'dwells': (-1.0,), 'stops': stops}
    fleet.do(fleet.supervisor.request(Request(1, **stays), fleet.now))
    fleet.work = replace(WORK, step_types=frozenset({'engage'}))
    fleet.restart()
    fleet.do(fleet.supervisor.request(Request(2, **stays), fleet.now))
    assert "no step type 'say'; there are: engage" in fleet.statuses[-1].reason
    assert fleet.state(1).is_open


@pytest.mark.parametrize('stamp', [0.0, 5.0])
def test_a_request_means_the_same_after_the_work_file_has_changed(stamp):
    fleet = PlannedFleet()
    fleet.send(1, template='pallet', arguments=ARGUMENTS, stamp=stamp)
    fleet.work = SiteWork()
    fleet.restart()
    fleet.send(1, template='pallet', arguments=ARGUMENTS, stamp=stamp)
    assert fleet.statuses[-1].state is not MissionState.REFUSED
    fleet.run_until_done(1)
    assert fleet.told(1)[-1] is MissionState.SUCCEEDED
    assert fleet.supervisor.book.find(1).request.destinations == (3, 7)


def test_of_a_group_the_place_is_chosen_to_which_the_fewest_open_missions_go():
    fleet = PlannedFleet()
    for id in (1, 2, 3):
        fleet.send(id, template='pallet', arguments=(('from', 'press'), ('to', 'shelves')))
    assert [fleet.mission(id).request.destinations[1] for id in (1, 2, 3)] == [5, 6, 5]


# -- earliest times and deadlines -----------------------------------------------------------------


def test_a_mission_is_planned_until_its_earliest_time_also_over_a_restart():
    fleet = PlannedFleet()
    fleet.request(1, 5, earliest=fleet.moment + 60.0)
    fleet.run(30.0)
    fleet.restart()
    fleet.run(29.0)
    assert fleet.told(1) == [MissionState.PLANNED]
    fleet.run_until_done(1)
    assert MissionState.SUCCEEDED in fleet.told(1)


def test_a_planned_mission_says_how_long_it_waits_for_its_time():
    fleet = PlannedFleet()
    fleet.request(1, 5, earliest=fleet.moment + 60.0)
    fleet.run(20.0)
    wait = mission_reason(fleet.mission(1), fleet.supervisor, fleet.now).wait
    assert (wait.code, wait.until) == (WaitCode.TIME, pytest.approx(40.0, abs=0.5))


def test_a_mission_that_was_paused_while_planned_waits_for_its_time_when_it_is_resumed():
    fleet = PlannedFleet()
    fleet.request(1, 5, earliest=fleet.moment + 60.0)
    for command in (CommandKind.PAUSE, CommandKind.RESUME):
        fleet.do(fleet.supervisor.command(1, command, fleet.now))
    assert fleet.state(1) is MissionState.PLANNED
    fleet.do(fleet.supervisor.command(1, CommandKind.PAUSE, fleet.now))
    fleet.run(61.0)
    fleet.do(fleet.supervisor.command(1, CommandKind.RESUME, fleet.now))
    assert fleet.state(1) is MissionState.PENDING or fleet.robot_of(1) == 'a'


def test_a_planned_mission_that_comes_after_another_is_blocked_when_its_time_has_come():
    fleet = PlannedFleet()
    fleet.request(1, 8, dwells=(-1.0,))
    fleet.request(2, 5, earliest=fleet.moment + 10.0, after=(Dependency(1),))
    assert fleet.state(2) is MissionState.PLANNED
    fleet.run(11.0)
    assert fleet.state(2) is MissionState.BLOCKED


def test_a_mission_that_has_not_begun_by_its_deadline_expires_after_an_alarm():
    fleet = PlannedFleet()
    fleet.request(1, 8, dwells=(-1.0,))
    fleet.request(2, 5, deadline=fleet.moment + 40.0)
    fleet.request(3, 5, after=(Dependency(2),))
    fleet.run(45.0)
    assert fleet.told(2)[-1] is MissionState.EXPIRED
    assert fleet.alarms(2) == [DeadlineState.AHEAD, DeadlineState.AT_RISK, DeadlineState.MISSED]
    assert fleet.state(3) is MissionState.FAILED
    assert any('Mission 2 will miss its deadline' in note for note in fleet.notes)


def test_a_mission_that_has_begun_never_expires_and_the_alarm_comes_before_it_is_late():
    fleet = PlannedFleet()
    fleet.request(1, 8, deadline=fleet.moment + 20.0)
    fleet.run_until(lambda: DeadlineState.AT_RISK in fleet.alarms(1))
    assert fleet.moment < fleet.mission(1).request.deadline - 10.0
    fleet.close(*fleet.graph.edges)
    fleet.run(25.0)
    fleet.restart()
    fleet.close()
    fleet.run_until_done(1)
    assert fleet.told(1)[-1] is MissionState.SUCCEEDED
    assert fleet.mission(1).deadline_state is DeadlineState.MISSED


def test_a_clock_that_is_set_back_takes_no_expiry_back_and_begins_nothing_twice():
    fleet = PlannedFleet()
    fleet.request(1, 5, earliest=fleet.moment + 20.0)
    fleet.request(2, 6, deadline=fleet.moment + 0.5, earliest=fleet.moment + 0.2)
    fleet.run_until_done(1)
    fleet.wall -= 3600.0
    fleet.run(30.0)
    assert fleet.told(1).count(MissionState.ACTIVE) == 1
    assert [state for state in fleet.told(2) if not state.is_open] in (
        [MissionState.EXPIRED], [MissionState.SUCCEEDED])


@pytest.mark.parametrize('times, told', [
    ({'earliest': float('nan')}, 'is no time'), ({'deadline': float('inf')}, 'is no time'),
    ({'earliest': 9.0, 'deadline': 9.0}, 'not after its earliest time')])
def test_times_that_make_no_sense_are_refused(times, told):
    fleet = PlannedFleet()
    fleet.request(1, 5, **times)
    assert fleet.statuses[-1].state is MissionState.REFUSED and told in fleet.statuses[-1].reason


# -- timetables -----------------------------------------------------------------------------------


EVERY_MINUTE = replace(WORK, timetables={
    'milk': Timetable('milk', 'pallet', 1, (('from', '2'), ('to', '3')))})


def runs(fleet: PlannedFleet) -> List[str]:
    """Returns the times of the runs that were requested."""
    found = {(s.request_id, s.stamp) for s in fleet.statuses
             if s.template and s.state is not MissionState.REFUSED}
    return [datetime.fromtimestamp(stamp).strftime('%H:%M') for _, stamp in
            sorted(found, key=lambda one: one[1])]


def minutes(fleet: PlannedFleet, count: int) -> List[str]:
    """Returns the local times of the first minutes of a run."""
    return [datetime.fromtimestamp(fleet.wall + 60.0 * k).strftime('%H:%M') for k in range(count)]


@pytest.mark.parametrize('seed', range(3))
def test_each_run_of_a_timetable_is_one_mission_whenever_the_fleet_manager_restarts(seed):
    fleet = PlannedFleet(EVERY_MINUTE, seed=seed)
    expected = minutes(fleet, 4)
    while fleet.now < 185.0:
        fleet.run(fleet.random.uniform(0.5, 20.0))
        fleet.restart()
    fleet.run(1.0)
    assert runs(fleet) == expected


def test_after_an_outage_only_the_newest_run_is_made_and_the_others_are_told():
    fleet = PlannedFleet(EVERY_MINUTE)
    fleet.run(1.0)
    fleet.wall += 600.0
    fleet.restart()
    fleet.run(1.0)
    assert len(runs(fleet)) == 2
    assert any('Timetable milk has missed 9 runs' in note for note in fleet.notes)


def test_a_run_whose_template_does_not_fit_any_more_is_told():
    work = replace(EVERY_MINUTE, templates={})
    fleet = PlannedFleet(work)
    fleet.run(1.0)
    assert any("The run of timetable milk" in note and "no template 'pallet'" in note
               for note in fleet.notes)


def test_while_the_disk_is_full_no_run_is_requested_and_none_is_lost():
    fleet = PlannedFleet(EVERY_MINUTE)
    fleet.run(1.0)
    fleet.disk.fails()
    fleet.run(62.0)
    assert len(runs(fleet)) == 1
    fleet.disk.fails(False)
    fleet.run(5.0)
    assert len(runs(fleet)) == 2


def pause(fleet: PlannedFleet, paused: bool, name: str = 'milk') -> str:
    problem, actions = fleet.supervisor.pause_timetable(name, paused, fleet.now)
    fleet.do(actions)
    return problem


def test_a_paused_timetable_makes_no_runs_also_after_a_restart_and_then_none_of_that_time():
    fleet = PlannedFleet(EVERY_MINUTE)
    fleet.run(1.0)
    assert pause(fleet, True) == ''
    fleet.restart()
    fleet.run(130.0)
    (view,) = fleet.supervisor.timetables.views
    assert (view.timetable.name, view.next, len(runs(fleet))) == ('milk', None, 1)
    assert pause(fleet, False) == ''
    fleet.restart()
    (view,) = fleet.supervisor.timetables.views
    fleet.run(1.0)
    assert len(runs(fleet)) == 1
    assert 0.0 < view.next - fleet.moment <= 60.0
    fleet.run(62.0)
    assert len(runs(fleet)) == 2
    assert not any('missed' in note for note in fleet.notes)


def test_a_timetable_that_the_work_file_does_not_have_is_not_paused():
    assert "no timetable 'tea'; it has: milk" in pause(PlannedFleet(EVERY_MINUTE), True, 'tea')
