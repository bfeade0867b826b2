"""Transcripts: driving, docking, localizing, patrols, tasks (form as in `transcripts_state`)."""
from __future__ import annotations

UNDOCKED = 'DockingState: Undocked ForcedState: Unforced ChargeState: Not'

IMMEDIATE = {
    'queryDockStatus': [['queryDockStatus'], [UNDOCKED]],
    'queryMotors': [['queryMotors'], ['Motors enabled']],
    'enableMotors': [['enableMotors'], ['Motors are enabled']],
    **{name: [[name], [f'CommandError: {name}', 'CommandErrorDescription: '
                       f'{name} is not simulated: no source describes its answer']]
       for name in ('go', 'stay', 'follow', 'modeLock', 'modeUnlock', 'etaRequest',
                    'goalDistanceRemaining', 'trackSectors', 'scanStart', 'scanStop',
                    'scanAddGoal')},
    'queueShowRobotLocal': [['queueShowRobotLocal hello', 'abds door a b', 'qsrl'], [
        'QueueRobot: "robot" Available Available hello', 'EndQueueShowRobot',
        'QueueRobot: "robot" UnAvailable FaultDriving ""', 'EndQueueShowRobot']],
    'queueQueryLocal': [['queueQueryLocal status inprogress'], ['EndQueueQuery']],
    'listStart': [['listStart'], ['List being cleared', 'Making new list']],
    'listAdd': [['listAdd wait 1', 'listStart', 'listAdd wait 1', 'listAdd dance'],
                ['SetUpError: You need to start a list before you can add to it.',
                 'List being cleared', 'Making new list', "Added task 'wait 1' to the list",
                 'CommandError: listAdd dance', "CommandErrorDescription: No task 'dance'"]],
    'waitTaskState': [['waitTaskState', 'doTask wait 10', 'waitTaskState'], [
        'WaitState: Not waiting', 'Will do task wait 10', 'Doing task wait 10',
        'WaitState: Waiting 10 seconds with status "Waiting"',
        'WaitState: Waiting with status "Waiting"']],
    'pauseTaskState': [['pauseTaskState'], ['PauseTask: not pausing']],
    'doTaskInstant': [['doTaskInstant sayInstant "Enabling motors."', 'doTaskInstant say 1'], [
        'Completed doing instant task sayInstant "Enabling motors."',
        'CommandError: doTaskInstant say 1',
        "CommandErrorDescription: Task 'say' is not an instant task"]],
}

# commands that take a while, with all lines up to their last line
LASTING = {
    'goto': [['goto west'], ['Going to West', 'Arrived at West']],
    'gotoPoint': [['gotoPoint -2000 500 90'], ['Going to point', 'Arrived at point']],
    'gotoRouteGoal': [['gotoRouteGoal Round west'], ['Going to West', 'Arrived at West']],
    'stop': [['stop'], ['Stopping', 'Stopped']],
    'queueDropoff': [['queueDropoff west 22 y4rt'], [
        'queuedropoff attempting to queue goal "West" with priority 22',
        'queuedropoff goal "West" with priority 22, id DROPOFF1 and job_id y4rt successfully '
        'queued',
        '/QueueUpdate: DROPOFF1 y4rt 22 Pending None Goal "West" "robot" .* None None 0/',
        '/QueueUpdate: DROPOFF1 y4rt 22 InProgress Driving Goal "West" "robot" .* None None 0/',
        'Going to West', 'Arrived at West']],
    'dock': [['dock'], [
        UNDOCKED, 'DockingState: Docking ForcedState: Unforced ChargeState: Not',
        'DockingState: Docking ForcedState: Unforced ChargeState: Bulk',
        'DockingState: Docked ForcedState: Unforced ChargeState: Bulk',
        'DockingState: Docked ForcedState: Unforced ChargeState: Overcharge']],
    'undock': [['undock'], [UNDOCKED, 'Stopping', 'Stopped']],
    'localizeToPoint': [['localizeToPoint -2900 0 5'],
                        ['Localizing at point', 'Localized to point']],
    'localizeAtGoal': [['localizeAtGoal West 3000 180'],
                       ['Localizing at goal West', 'Localized to goal West']],
    'patrol': [['patrol Round', 'stop'], [
        'Patrolling route Round', 'Interrupted: Patrolling route Round', 'Stopping', 'Stopped']],
    'patrolOnce': [['patrolOnce Round'], [
        'Patrolling route Round once', 'Finished patrolling route Round']],
    'patrolResume': [['patrolOnce Round 0', 'stop', 'patrolResume Round'], [
        'Patrolling route Round once', 'Interrupted: Patrolling route Round once', 'Stopping',
        'Stopped', 'Patrolling route Round once', 'Finished patrolling route Round']],
    'doTask': [['doTask say "hello"'], [
        'Will do task say "hello"', 'Doing task say "hello"', 'Completed doing task say "hello"']],
    'executeMacro': [['executemacro greeting'], [
        'Executing macro Greeting', 'WaitState: Waiting 2 seconds with status "Waiting"',
        'WaitState: Waiting completed', 'Completed macro Greeting']],
    'listExecute': [['listStart', 'listAdd move 200', 'listExecute'], [
        'List being cleared', 'Making new list', "Added task 'move 200' to the list",
        'Executing list', 'Successfully finished task list']],
    'waitTaskCancel': [['doTask wait 10', 'waitTaskCancel'], [
        'Will do task wait 10', 'Doing task wait 10',
        'WaitState: Waiting 10 seconds with status "Waiting"', 'WaitState: Waiting cancelled',
        'Completed doing task wait 10']],
    'pauseTaskCancel': [['doTask pause', 'pauseTaskState', 'pauseTaskCancel'], [
        'Will do task pause', 'Doing task pause', 'PauseTask: pausing', 'PauseTask: pausing',
        'PauseTask: cancelled', 'Completed doing task pause']],
}
