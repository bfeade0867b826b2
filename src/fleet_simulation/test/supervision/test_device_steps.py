"""Steps that a device carries out, in a supervised fleet: one at a time, each requested once."""
from __future__ import annotations

from test_work_at_stops import WorkingFleet

from fleet_core.supervision.machine_view import MachineState, MachineView
from fleet_core.supervision.missions import MissionState
from fleet_core.work.devices import StepDevice
from fleet_core.work.rules import StepDecision
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stops import Actor, LoadEffect, Policy, WorkStep, WorkStop
from fleet_core.work.tables import LoadState
from route_protocol.steps import StepAct, StepCommand, Word

SITE = SiteWork(step_devices={'press': StepDevice('press', 10.0)})
HAND = WorkStep('handshake', 60.0, actor=Actor.DEVICE, device='press', load=LoadEffect.TAKES)


def fleet_of(*robots: str) -> WorkingFleet:
    return WorkingFleet(*robots, work=SITE)


def test_a_device_hands_a_load_over_and_the_robot_waits_for_it():
    fleet = fleet_of()
    fleet.send(1, WorkStop(4, steps=(HAND,)))
    fleet.run_until(lambda: fleet.step_devices['press'].running)
    assert 'handshake) of stop 1 by device press' in fleet.reason(1)
    assert fleet.load() is LoadState.UNKNOWN
    fleet.run_until(lambda: fleet.state(1) is MissionState.SUCCEEDED)
    assert (fleet.step_devices['press'].done, fleet.load()) == (['handshake'], LoadState.LOADED)
    assert fleet.done() == []


def test_a_machine_tells_whether_it_works_and_for_which_robot_and_where():
    fleet = fleet_of()
    fleet.run_until(lambda: machine(fleet).state is MachineState.FREE)
    fleet.send(1, WorkStop(4, steps=(HAND,)))
    fleet.run_until(lambda: fleet.step_devices['press'].running)
    fleet.run_until(lambda: machine(fleet).state is MachineState.WORKING)
    (_, _, step), = fleet.supervisor.desk.work(1).steps
    name, = fleet.supervisor.robots
    assert machine(fleet) == MachineView('press', MachineState.WORKING, (4,), step.key, name, 1)
    silent, = fleet.supervisor.desk.machines(fleet.now + 3.1)
    assert silent == MachineView('press', MachineState.SILENT)
    fleet.run_until(lambda: fleet.state(1) is MissionState.SUCCEEDED)
    assert machine(fleet).state is MachineState.FREE


def machine(fleet: WorkingFleet) -> MachineView:
    view, = fleet.supervisor.desk.machines(fleet.now)
    return view


def test_a_device_that_fails_follows_the_policy_of_the_step():
    fleet = fleet_of()
    again = WorkStep('handshake', 60.0, actor=Actor.DEVICE, device='press',
                     on_failure=Policy.RETRY, retries=1)
    fleet.step_devices['press'].fail_next(Word.FAILED, 1)
    fleet.send(1, WorkStop(4, steps=(again,)))
    fleet.run_until(lambda: fleet.state(1) is MissionState.SUCCEEDED)


def test_a_device_of_which_the_outcome_is_not_known_makes_a_person_decide():
    fleet = fleet_of()
    fleet.step_devices['press'].fail_next(Word.UNKNOWN, 1)
    fleet.send(1, WorkStop(4, steps=(HAND,)))
    fleet.run_until_asked(1)
    fleet.answer(1, StepDecision.DONE)
    fleet.run_until(lambda: fleet.state(1) is MissionState.SUCCEEDED)
    assert fleet.load() is LoadState.LOADED


def test_a_driver_that_has_restarted_without_its_memory_makes_a_person_decide():
    fleet = fleet_of()
    fleet.send(1, WorkStop(4, steps=(HAND,)))
    fleet.run_until(lambda: fleet.step_devices['press'].running)
    fleet.step_devices['press'].restart()
    fleet.run_until_asked(1)
    assert 'the driver of device press has restarted' in fleet.reason(1)


def test_a_fleet_manager_that_restarts_waits_for_the_same_step():
    fleet = fleet_of()
    fleet.send(1, WorkStop(4, steps=(HAND,)))
    fleet.run_until(lambda: fleet.step_devices['press'].running)
    fleet.restart()
    fleet.run_until(lambda: fleet.state(1) is MissionState.SUCCEEDED)
    assert fleet.step_devices['press'].done == ['handshake']


def test_a_device_carries_out_one_step_at_a_time():
    fleet = fleet_of('a', 'b')
    fleet.send(1, WorkStop(3, steps=(HAND,)), robot='a')
    fleet.send(2, WorkStop(6, steps=(HAND,)), robot='b')
    fleet.run_until(lambda: 'device press carries out another one' in (
        fleet.reason(1) + fleet.reason(2)))
    assert len(fleet.step_devices['press'].running) == 1
    fleet.run_until(lambda: fleet.state(1) is fleet.state(2) is MissionState.SUCCEEDED)
    assert fleet.step_devices['press'].done == ['handshake'] * 2


def test_an_unknown_device_is_refused():
    fleet = fleet_of()
    fleet.send(1, WorkStop(4, steps=(WorkStep('handshake', 60.0, actor=Actor.DEVICE,
                                              device='pres'),)))
    assert "no machine 'pres' among the devices; there are: press" in fleet.statuses[-1].reason


def test_a_device_that_has_worked_since_the_journal_was_kept_makes_all_loads_unknown_once():
    fleet = fleet_of('a', 'b')
    press = fleet.step_devices['press']
    press.receive(StepCommand(int(3e12), StepAct.DO, press.report().run, 'handshake'))
    fleet.run(5.0)
    assert (fleet.load('a'), fleet.load('b')) == (LoadState.UNKNOWN,) * 2
    assert not fleet.set_load('a') and not fleet.set_load('b')
    fleet.restart()
    fleet.send(1, WorkStop(4, steps=(HAND,)))
    fleet.run_until(lambda: fleet.state(1) is MissionState.SUCCEEDED)
