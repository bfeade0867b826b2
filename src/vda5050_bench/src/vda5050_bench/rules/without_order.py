"""Rules for a vehicle without an order: the connection, and instant actions."""
from __future__ import annotations

from vda5050_bench.master import status_of
from vda5050_bench.rules.rule import ONLY_3, SINCE_2_1, Start, must, should
from vda5050_bench.trial import ANSWER, ENDED, Trial, new_errors, references
from vda5050_bench.verdicts import expect


@must('6.14', 'a vehicle that comes online sends ONLINE', Start.NOTHING)
def _online(trial: Trial) -> None:
    found = trial.master.wait(lambda m: True, ANSWER, 'a message on connection', 'connection')
    expect(found.get('connectionState') == 'ONLINE', f'it is {found.get("connectionState")}')


@must('6.14', 'all messages on connection are retained', Start.NOTHING, SINCE_2_1)
@should('6.14', 'all messages on connection are retained', Start.NOTHING, ('2.0',))
def _retained(trial: Trial) -> None:
    expect(trial.master.is_retained('connection'), 'a client that connects later receives none')


@must('6.8.1', 'stateRequest makes the vehicle send a state', Start.ANYWHERE)
def _state_request(trial: Trial) -> None:
    master, before = trial.master, trial.master.count()
    master.act('stateRequest')
    master.wait(lambda s: True, ANSWER, 'a state', after=before)


@must('6.8.2', 'stateRequest is FINISHED when the state has been communicated', Start.ANYWHERE)
def _state_request_finished(trial: Trial) -> None:
    ended = trial.master.ended(trial.master.act('stateRequest'), ANSWER)
    expect(ended['actionStatus'] == 'FINISHED', f'it is {ended["actionStatus"]}')


@must('6.15', 'the master can request the factsheet by factsheetRequest', Start.ANYWHERE, SINCE_2_1)
def _factsheet(trial: Trial) -> None:
    master, before = trial.master, trial.master.count('factsheet')
    action_id = master.act('factsheetRequest')
    master.wait(lambda m: True, ANSWER, 'a factsheet', 'factsheet', before)
    status = master.ended(action_id, ANSWER)['actionStatus']
    expect(status == 'FINISHED', f'factsheetRequest is {status}')


@must('6.15', 'all messages on factsheet are retained', Start.ANYWHERE, SINCE_2_1)
def _factsheet_retained(trial: Trial) -> None:
    trial.master.act('factsheetRequest')
    trial.needed(lambda: trial.master.wait(lambda m: True, ANSWER, 'a factsheet', 'factsheet'))
    expect(trial.master.is_retained('factsheet'), 'a client that connects later receives none')


@must('6.11', 'a vehicle represents every action that it receives in its actionStates',
      Start.ANYWHERE)
def _every_action(trial: Trial) -> None:
    action_id = trial.master.act('noSuchAction')
    trial.master.wait(lambda s: status_of(s, action_id), ANSWER,
                      'an actionState of an unknown instant action')


@must('6.11, table 2', 'an action that could not be finished for whatever reason is FAILED',
      Start.ANYWHERE)
def _unknown_action(trial: Trial) -> None:
    action_id = trial.master.act('noSuchAction')
    trial.needed(lambda: trial.master.wait(
        lambda s: status_of(s, action_id), ANSWER, 'the actionState of an unknown action'))
    ended = trial.master.ended(action_id, ANSWER)
    expect(ended['actionStatus'] == 'FAILED', f'an unknown action is {ended["actionStatus"]}')


@must('3.0: 6.6.5', 'INVALID_INSTANT_ACTION stays until a new instant action is accepted',
      Start.ANYWHERE, versions=ONLY_3)
def _invalid_action(trial: Trial) -> None:
    master = trial.master
    action_id = master.act('noSuchAction')
    master.wait(lambda s: _names(s, action_id), ANSWER, 'INVALID_INSTANT_ACTION with the actionId')
    good = master.act('stateRequest')
    master.ended(good, ANSWER)
    master.wait(lambda s: not _names(s, action_id), ANSWER,
                'no INVALID_INSTANT_ACTION any more after a stateRequest')


def _names(state: object, action_id: str) -> bool:
    errors = state['errors'] if isinstance(state, dict) else []
    return any(error.get('typeOf3') == 'INVALID_INSTANT_ACTION'
               and action_id in references(error).values() for error in errors)


@must('3.0: 6.2.1', 'an instant action stays in the state until clearInstantActions',
      Start.ANYWHERE, versions=ONLY_3)
def _kept(trial: Trial) -> None:
    asked = _ended_request(trial)
    trial.ordered(trial.ahead.part(0, 0))
    expect(status_of(trial.fetch(), asked) in ENDED,
           'a stateRequest that has ended vanishes when an order is accepted')


@must('3.0: 6.2.3.2', 'clearInstantActions removes the instant actions that have ended',
      Start.ANYWHERE, versions=ONLY_3)
def _clear(trial: Trial) -> None:
    asked = _ended_request(trial)
    cleared = trial.master.ended(trial.master.act('clearInstantActions'), ANSWER)
    expect(cleared['actionStatus'] == 'FINISHED', f'it is {cleared["actionStatus"]}')
    expect(status_of(trial.fetch(), asked) is None, 'a stateRequest that has ended remains')


def _ended_request(trial: Trial) -> str:
    asked = trial.master.act('stateRequest')
    trial.needed(lambda: trial.master.ended(asked, ANSWER))
    return asked


@must('6.6.3.2', 'cancelOrder without an order is reported as FAILED')
def _nothing_to_cancel(trial: Trial) -> None:
    ended = trial.master.ended(trial.master.act('cancelOrder'), ANSWER)
    expect(ended['actionStatus'] == 'FAILED', f'it is {ended["actionStatus"]}')


@must('6.6.3.2', 'cancelOrder without an order: noOrderToCancel, WARNING, with the actionId')
def _no_order_to_cancel(trial: Trial) -> None:
    master = trial.master
    was, before = master.state, master.count()
    action_id = master.act('cancelOrder')
    state = master.wait(lambda s: new_errors(was, s), ANSWER, 'a new error', after=before)
    error = new_errors(was, state)[0]
    expect(error['errorType'] == 'noOrderToCancel', f'the error is {error["errorType"]}')
    expect(error['errorLevel'] == 'WARNING', f'the errorLevel is {error["errorLevel"]}')
    expect(action_id in references(error).values(), 'errorReferences have no actionId')
