"""simulate_fleet with a work file: steps, stations, doors, deadlines, and the bottleneck."""
from __future__ import annotations

import csv
from pathlib import Path
from typing import Callable, Dict, List, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet_core.files.errors import FileError
from fleet_core.files.fleet_file import load_fleet
from fleet_core.files.robot_settings import load_settings
from fleet_core.files.work_file import load_work
from fleet_core.interlocking.resources import Resource, ResourceKind
from fleet_simulation import command
from fleet_simulation.command import main
from fleet_simulation.demand_file import load_demand
from fleet_simulation.figures import Figures, WaitingCause
from fleet_simulation.hold_ups import (
    HoldUp,
    ResourceUse,
    WaitFor,
    bottlenecks,
    held_up,
    summed,
)
from fleet_simulation.simulation import simulate
from fleet_simulation.site import site_of
from trajectory_graph import Graph

Files = Callable[..., Dict[str, str]]
WORK = '''
stations:
- {name: press, places: [25], queue: [15], capacity: 1}
- {name: shelves, places: [21, 22, 23], kind: group}
devices:
- {name: gate, kind: door, edges: [3], timeout: 60, driver: simulated}
templates:
- name: pallet
  parameters: [from, to]
  stops:
  - {at: $from, kind: pickup, steps: [{type: engage, timeout: 90, load: takes}]}
  - {at: $to, kind: dropoff, steps: [
      {type: handshake, actor: outside, timeout: 90}, {type: disengage, timeout: 90, load: gives}]}
'''
FLOW = '{template: pallet, arguments: {from: shelves, to: press}, '


def run(yard: Graph, paths: Dict[str, str], robots: int, hours: float = 0.1,
        seed: int = 1) -> Figures:
    demand = load_demand(paths['demand'], yard, load_work(paths['work'], yard))
    site = site_of(yard, load_fleet(paths['fleet']), load_settings(paths['fleet']), demand)
    figures = simulate(site, robots, seed, hours)
    assert not figures.trouble
    return figures


def waiting(figures: Figures) -> Dict[str, float]:
    return {name: sum(use.waiting.values()) for name, use in figures.resources.items()}


def test_robots_drive_no_faster_than_their_loads_allow(yard: Graph, files: Files) -> None:
    typed = WORK.replace('load: takes', 'load: takes, load_type: pallet')

    def metres(speed: float) -> float:
        loads = f'loads:\n- {{name: pallet, speed: {speed}}}\n'
        return run(yard, files(f'flows:\n- {FLOW}saturated: 1}}\n', work=loads + typed),
                   1).travelled
    assert metres(0.1) < 0.5 * metres(1.0)


def test_a_queue_place_too_near_for_a_load_is_told_before_the_runs(
        files: Files, tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.setattr(command, '_runs', lambda *_: ([], True))
    paths = files(f'flows:\n- {FLOW}saturated: 1}}\n', work=WORK.replace(
        'load: takes', 'load: takes, load_type: pallet')
        + 'loads:\n- {name: pallet, footprint: {radius: 1.8}}\n')
    main([*(f'--{name}={path}' for name, path in paths.items()),
          f'--output={tmp_path / "report"}'])
    assert f'{paths["work"]}: queue place 15 of station press is 2.00 m from vertex 25' in (
        capsys.readouterr().err)


# -- bottlenecks that are known by construction ----------------------------------------------------


def test_a_station_with_long_steps_and_room_for_one_robot_is_named(
        files: Files, tmp_path: Path, capsys) -> None:
    paths = files(f'flows:\n- {FLOW}saturated: 1}}\nsteps:\n'
                  '- {type: handshake, at: press, seconds: 60, scatter: 0.2}\n', work=WORK)
    assert main([*(f'--{name}={path}' for name, path in paths.items()), '--robots=3',
                 '--hours=0.15', '--seeds=1', f'--output={tmp_path / "report"}']) == 0
    told = capsys.readouterr().out
    assert ('Of all stations, devices and chargers, station press is the bottleneck: robots wait'
            in told)
    assert 'mostly for its turn in the queue' in told
    rows = list(csv.DictReader((tmp_path / 'report' / 'resources.csv').open()))
    press = sum(float(row['robot_s']) for row in rows if row['resource'] == 'station press')
    assert press > 5.0 * sum(float(row['robot_s']) for row in rows
                             if row['resource'] != 'station press')
    assert '<h2>Stations, devices and chargers, with 3 robots</h2>' in (
        tmp_path / 'report' / 'report.html').read_text()


def test_a_slow_door_is_the_bottleneck_and_a_fast_one_is_not(yard: Graph, files: Files) -> None:
    work = WORK.replace('edges: [3]', 'edges: [204]').replace('queue: [15], ', '')
    slow, fast = (run(yard, files(f'flows:\n- {FLOW}saturated: 1}}\ndevices: {{gate: {seconds}}}\n',
                                  work=work), 1) for seconds in (30, 1))
    assert max(waiting(slow), key=lambda name: waiting(slow)[name]) == 'gate'
    assert slow.resources['gate'].waiting[HoldUp.OPENING] > 0.9 * waiting(slow)['gate']
    assert waiting(slow)['gate'] > 3.0 * waiting(fast)['gate']
    assert slow.succeeded < fast.succeeded
    for figures in (slow, fast):
        for use in figures.resources.values():
            assert use.claimed <= use.resource.capacity * figures.seconds * 1.01
        assert sum(waiting(figures).values()) == pytest.approx(sum(
            seconds for (_, cause), seconds in figures.waiting.items()
            if cause is WaitingCause.RESOURCE))


# -- steps and deadlines ---------------------------------------------------------------------------


def test_longer_steps_serve_fewer_missions_and_a_run_depends_on_its_seed_only(
        yard: Graph, files: Files) -> None:
    def served(seconds: float) -> Tuple[int, object]:
        figures = run(yard, files(f'flows:\n- {FLOW}saturated: 1}}\nsteps:\n- {{type: engage, '
                                  f'seconds: {seconds}, scatter: 0.3}}\n', work=WORK), 1, 0.07)
        return figures.succeeded, figures.leads
    short = served(2.0)
    assert short == served(2.0)
    assert short[0] > 1.5 * served(60.0)[0]


@pytest.mark.parametrize(('deadline', 'is_missed'), [(3000.0, False), (5.0, True)])
def test_a_deadline_that_a_mission_cannot_keep_is_counted_as_missed(
        yard: Graph, files: Files, deadline: float, is_missed: bool) -> None:
    figures = run(yard, files(f'flows:\n- {FLOW}per_hour: 90, deadline: {deadline}}}\n', work=WORK),
                  2)
    assert (figures.deadlines, figures.missed) == (
        (figures.missed, figures.deadlines) if is_missed else (figures.succeeded, 0))
    assert figures.deadlines > 5


TIMETABLES = WORK + '''
timetables:
- {template: pallet, arguments: {from: shelves, to: press}, every: 2 min, from: "06:02",
   deadline: 1 h}
- {name: late, template: pallet, arguments: {from: shelves, to: press}, every: 1 h,
   from: "06:06", to: "06:06", days: mon, deadline: 1 min}
- {name: other_day, template: pallet, arguments: {from: shelves, to: press}, every: 1 min,
   days: tue-sun}
'''


def timetables(folder: Path) -> Dict[str, Dict[str, str]]:
    return {row['timetable']: row for row in csv.DictReader((folder / 'timetables.csv').open())}


def test_the_runs_of_timetables_come_at_their_times_and_are_listed_with_their_deadlines(
        files: Files, tmp_path: Path) -> None:
    paths = files('steps:\n- {type: engage, seconds: 80}\n', work=TIMETABLES)
    report = tmp_path / 'report'
    assert main([*(f'--{name}={path}' for name, path in paths.items()), '--robots=2',
                 '--hours=0.15', '--seeds=1', f'--output={report}']) == 0
    found = timetables(report)
    counted = [(name, int(row['missions'])) for name, row in found.items()]
    assert counted == [('pallet', 4), ('late', 1), ('other_day', 0)]
    assert int(found['pallet']['done']) >= 2 and found['pallet']['missed'] == '0'
    assert (found['late']['deadlines'], found['late']['missed']) == ('1', '1')
    assert '<h2>Timetables, with 2 robots</h2>' in (report / 'report.html').read_text()
    run, = csv.DictReader((report / 'runs.csv').open())
    assert run['requested'] == '5'


def test_a_run_begins_on_the_day_and_at_the_time_that_are_asked_for(
        files: Files, tmp_path: Path) -> None:
    paths = files('steps: []\n', work=TIMETABLES)
    report = tmp_path / 'report'
    assert main([*(f'--{name}={path}' for name, path in paths.items()), '--robots=1',
                 '--hours=0.05', '--seeds=1', '--begin', 'sun 00:10',
                 f'--output={report}']) == 0
    missions = {name: int(row['missions']) for name, row in timetables(report).items()}
    assert missions == {'pallet': 0, 'late': 0, 'other_day': 2}  # the first mission does not count


@pytest.mark.parametrize('begin', ['06:00', 'mo 06:00', 'mon 24:00', 'mon'])
def test_a_begin_that_is_no_day_and_time_is_refused(begin: str, capsys) -> None:
    with pytest.raises(SystemExit):
        main(['--begin', begin])
    assert 'is not a day and a time, such as "mon 06:00"' in capsys.readouterr().err


@pytest.mark.parametrize(('text', 'line', 'problem'), [
    ('flows:\n- {template: palet, per_hour: 3}\n', 2,
     "there is no template 'palet'; did you mean pallet?"),
    (f'flows:\n- {FLOW}per_hour: 3, stay: 4}}\n', 2,
     "a flow has the unknown key 'stay'; known keys: name, per_hour, timetable, saturated, "
     'priority, deadline, template, arguments'),
    ('flows:\n- {template: pallet, arguments: {from: press}, per_hour: 3}\n', 2,
     "'to' is not given: template pallet has the parameters from, to"),
    ('flows:\n- {template: pallet, arguments: {from: press, to: oven}, per_hour: 3}\n', 2,
     "no station and no vertex is named 'oven'; the stations are: press, shelves"),
    (f'flows:\n- {FLOW}per_hour: 3, deadline: -1}}\n', 2,
     'deadline is -1, but must be a number from 0 to 1e+06'),
    (f'flows:\n- {FLOW}per_hour: 3}}\nsteps:\n- {{type: weld, seconds: 3}}\n', 4,
     "no template has a step of type 'weld'; there are: disengage, engage, handshake"),
    (f'flows:\n- {FLOW}per_hour: 3}}\nsteps:\n- {{type: engage, seconds: 80, scatter: 0.2}}\n', 4,
     'a step of type engage takes up to 96 s, but template pallet gives it 90 s: let it take less, '
     'or give it a longer timeout there'),
    (f'flows:\n- {FLOW}per_hour: 3}}\nsteps:\n- {{type: engage, at: oven, seconds: 3}}\n', 4,
     "no station and no vertex is named 'oven'; the stations are: press, shelves"),
    (f'flows:\n- {FLOW}per_hour: 3}}\nsteps:\n- {{type: engage, seconds: 3}}\n'
     '- {type: engage, seconds: 4}\n', 5,
     'steps of type engage have two durations at the same place'),
    (f'flows:\n- {FLOW}per_hour: 3}}\ndevices: {{gat: 3}}\n', 3,
     "there is no device 'gat'; did you mean gate?"),
    (f'flows:\n- {FLOW}per_hour: 3}}\ndevices: {{gate: 61}}\n', 3,
     'the time of device gate is 61, but must be a number from 0 to 60'),
])
def test_what_is_wrong_is_one_sentence_with_its_line(yard: Graph, files: Files, text: str,
                                                     line: int, problem: str) -> None:
    paths = files(text, work=WORK)
    with pytest.raises(FileError) as error:
        load_demand(paths['demand'], yard, load_work(paths['work'], yard))
    assert (error.value.line, error.value.problem) == (line, problem)


@pytest.mark.parametrize(('text', 'line', 'problem'), [
    (f'flows:\n- {FLOW}per_hour: 3}}\n', 2,
     "template 'pallet' needs a work file that has it: name the file with --work"),
    ('flows:\n- {to: 21, per_hour: 3}\ndevices: {gate: 3}\n', 3,
     'devices need a work file with devices: name it with --work'),
])
def test_what_needs_a_work_file_says_so(yard: Graph, files: Files, text: str, line: int,
                                        problem: str) -> None:
    with pytest.raises(FileError) as error:
        load_demand(files(text)['demand'], yard)
    assert (error.value.line, error.value.problem) == (line, problem)


# -- the pure core ---------------------------------------------------------------------------------

ROBOTS = st.sampled_from('abcdef')
WAITS = st.builds(WaitFor, st.sampled_from(('press', 'gate')),
                  st.sampled_from((HoldUp.TURN, HoldUp.CLAIM, HoldUp.OPENING)))


@given(direct=st.dictionaries(ROBOTS, WAITS), behind=st.dictionaries(ROBOTS, ROBOTS))
def test_a_robot_is_held_up_by_what_the_first_robot_of_its_row_waits_for(
        direct: Dict[str, WaitFor], behind: Dict[str, str]) -> None:
    found = held_up(direct, behind)
    for name in 'abcdef':
        if name in direct:
            assert found[name] == direct[name]
        elif name in behind and behind[name] in found and behind[name] != name:
            assert found[name] == WaitFor(found[behind[name]].resource, HoldUp.BEHIND)
        else:
            assert name not in found


SECONDS = st.floats(0.0, 1e4)
USES = st.builds(ResourceUse, st.builds(Resource, st.sampled_from(('press', 'gate', 'oven')),
                                        st.just(ResourceKind.STATION), capacity=st.integers(1, 4)),
                 SECONDS, st.fixed_dictionaries(dict.fromkeys(HoldUp, SECONDS)))
RUNS = st.lists(st.dictionaries(st.sampled_from(('press', 'gate', 'oven')), USES), max_size=4)


@given(runs=RUNS)
def test_the_bottleneck_has_the_longest_waiting_and_nothing_is_lost_in_the_sums(
        runs: List[Dict[str, ResourceUse]]) -> None:
    whole = summed(*runs)
    found = list(bottlenecks(whole, 3600.0))
    assert len(found) == len(whole)
    minutes = [one.minutes for one in found]
    assert minutes == sorted(minutes, reverse=True)
    assert 60.0 * sum(minutes) == pytest.approx(sum(
        wait for run in runs for use in run.values() for wait in use.waiting.values()))
    assert not list(bottlenecks(whole, 0.0))
