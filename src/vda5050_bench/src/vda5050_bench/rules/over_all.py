"""Rules for all messages of a vehicle in a run."""
from __future__ import annotations

from vda5050_bench.master import TooLate
from vda5050_bench.rules.rule import Start, derived, must
from vda5050_bench.trial import INTERVAL, Trial
from vda5050_bench.verdicts import NotTried, expect


@must('6.10', 'a state is published on events, or at the latest every 30 s', Start.NOTHING)
def _interval(trial: Trial) -> None:
    times = [*trial.master.arrivals.get('state', ()), trial.master.now()]
    if len(times) == 1:
        raise TooLate('no state came')
    deaths = trial.deaths  # another rule reports them
    longest = max((after - before for before, after in zip(times, times[1:])
                   if not any(before <= death <= after for death in deaths)), default=0.0)
    expect(longest <= INTERVAL + 1.0, f'{longest:.1f} s passed without a state')


@derived('6.14', 'the connection does not break as long as the broker runs', Start.NOTHING)
def _alive(trial: Trial) -> None:
    expect(not trial.deaths, f'CONNECTIONBROKEN came {len(trial.deaths)} times')


@must('6.15.1', 'agvActions of the factsheet has all actions that the vehicle supports',
      Start.NOTHING)
def _all_actions(trial: Trial) -> None:
    sheets = trial.master.messages.get('factsheet')
    if not sheets:
        raise NotTried('no factsheet came')
    expect('protocolFeatures' in sheets[-1], 'the factsheet has no protocolFeatures')
    known = {found['actionType'] for found in sheets[-1]['protocolFeatures']['agvActions']}
    done = {action.get('actionType') for state in trial.master.messages.get('state', ())
            for action in state['actionStates'] if action['actionStatus'] == 'FINISHED'}
    missing = sorted(found for found in done - known if found)
    expect(not missing, f'executed, but not in the list: {", ".join(missing)}')


@must('6.2', 'connection is sent with QoS 1', Start.NOTHING)
def _quality(trial: Trial) -> None:
    found = trial.master.qualities.get('connection')
    if not found:
        raise NotTried('no message on connection came')
    expect(found == {1}, f'QoS is {sorted(found)}')


@must('6.4, 6.10', 'every message is as the standard has it', Start.NOTHING)
def _messages(trial: Trial) -> None:
    violations = trial.master.checker.violations
    expect(not violations, f'{len(violations)} broken: ' + '; '.join(violations))
