"""Commands for tasks, task lists, macros and routes."""
from __future__ import annotations

from omron_ld90_sim.behaviour import activities, map_scripts, tasks
from omron_ld90_sim.behaviour.instant_tasks import INSTANT
from omron_ld90_sim.behaviour.states import ActivityFailure
from omron_ld90_sim.behaviour.task import BadTask, RobotTask
from omron_ld90_sim.interface.commands.driving import check_drivable, find_goal
from omron_ld90_sim.interface.commands.table import CommandCall, CommandFailed, NotReady, command


def _task(text: str) -> RobotTask:
    try:
        return tasks.parse(text)
    except BadTask as error:
        raise CommandFailed(str(error)) from error


@command('doTask', 'does a task', '<task> <argument>', 1)
def do_task(call: CommandCall) -> None:
    """Carries out one task."""
    task = _task(call.rest)
    check_drivable(call)
    call.reply(f'Will do task {task}')
    call.robot.start(tasks.single(call.robot, task))


@command('doTaskInstant', "does an instant task (doesn't interrupt modes)", '<task> <argument>', 1)
def do_task_instant(call: CommandCall) -> None:
    """Carries out an instant task."""
    task = _task(call.rest)
    if task.name.lower() not in INSTANT:
        raise CommandFailed(f"Task '{task.name}' is not an instant task")
    try:
        INSTANT[task.name.lower()](call.robot, task)
    except ActivityFailure as failure:
        raise CommandFailed(str(failure)) from failure
    call.reply(f'Completed doing instant task {task}')


@command('listStart', 'Starts a task list', '[name]')
def list_start(call: CommandCall) -> None:
    """Begins a new, empty list."""
    call.session.task_list = []
    call.reply('List being cleared')
    call.reply('Making new list')


@command('listAdd', 'Adds a task to the task list', '<task> <argument>', 1)
def list_add(call: CommandCall) -> None:
    """Adds a task to the list."""
    if call.session.task_list is None:
        raise NotReady('You need to start a list before you can add to it.')
    task = _task(call.rest)
    call.session.task_list.append(task)
    call.reply(f"Added task '{task}' to the list")


@command('listExecute', 'Executes the task list')
def list_execute(call: CommandCall) -> None:
    """Carries out the list."""
    if call.session.task_list is None:
        raise NotReady('You need to start a list before you can execute it.')
    check_drivable(call)
    call.robot.start(tasks.task_list(call.robot, list(call.session.task_list)))


@command('waitTaskState', 'Gets the state of the wait task')
def wait_task_state(call: CommandCall) -> None:
    """Answers the state of the wait task."""
    status = call.robot.tasks.waiting
    call.reply(f'WaitState: Waiting with status "{status}"' if status
               else 'WaitState: Not waiting')


@command('waitTaskCancel', 'Cancels the wait task')
def wait_task_cancel(call: CommandCall) -> None:
    """Ends a running wait; an announcement informs all clients."""
    if call.robot.tasks.waiting:
        call.robot.tasks.waiting = ''
    else:
        call.reply('WaitState: Not waiting')


@command('pauseTaskState', 'Gets the state of the pause task')
def pause_task_state(call: CommandCall) -> None:
    """Answers the state of the pause task."""
    call.reply('PauseTask: pausing' if call.robot.tasks.pausing else 'PauseTask: not pausing')


@command('pauseTaskCancel', 'Cancels the pause task')
def pause_task_cancel(call: CommandCall) -> None:
    """Ends a running pause; an announcement informs all clients."""
    if call.robot.tasks.pausing:
        call.robot.tasks.pausing = False
    else:
        call.reply('PauseTask: not pausing')


@command('getMacros', 'gets a list of macros')
def get_macros(call: CommandCall) -> None:
    """Lists the map's macros."""
    for name in map_scripts.macros(call.robot.document):
        call.reply(f'Macro: {name}')
    call.reply('End of macros')


@command('executeMacro', 'executes a given macro', '<macro_name>', 1)
def execute_macro(call: CommandCall) -> None:
    """Carries out one of the map's macros; its name has no quotes and may contain blanks."""
    known = {name.lower(): (name, steps)
             for name, steps in map_scripts.macros(call.robot.document).items()}
    if call.text.lower() not in known:
        raise CommandFailed(f"No macro '{call.text}'")
    name, steps = known[call.text.lower()]
    for step in steps:
        _task(str(step))
    check_drivable(call)
    call.robot.start(tasks.macro(call.robot, name, steps))


@command('getRoutes', 'gets a list of routes')
def get_routes(call: CommandCall) -> None:
    """Lists the map's routes."""
    call.reply('Routes')
    for route in map_scripts.routes(call.robot.document):
        call.reply(f'Route: {route.name}')
    call.reply('End of routes')


def _route(call: CommandCall, name: str) -> map_scripts.MapRoute:
    for route in map_scripts.routes(call.robot.document):
        if route.name.lower() == name.lower():
            for task in (task for tasks_there in route.tasks.values() for task in tasks_there):
                _task(str(task))
            return route
    raise CommandFailed(f"Bad route '{name}'")


@command('patrol', 'Patrols a route', '<route_name>', 1)
def patrol(call: CommandCall) -> None:
    """Drives along a route endlessly."""
    route = _route(call, call.text)
    check_drivable(call)
    call.robot.start(map_scripts.patrol(call.robot, route, once=False))


@command('patrolOnce', 'Patrols a route one time', '<route_name> [index]', 1)
def patrol_once(call: CommandCall) -> None:
    """Drives along a route once, from the goal with the given index."""
    route = _route(call, call.arguments[0])
    first = int(call.number(1, 0.0))
    if not 0 <= first < len(route.goals):
        raise CommandFailed(f'Bad index {first}')
    check_drivable(call)
    call.robot.start(map_scripts.patrol(call.robot, route, once=True, first=first))


@command('patrolResume', 'Resumes a patrol', '<route_name>', 1)
def patrol_resume(call: CommandCall) -> None:
    """Continues a route that was stopped."""
    route = _route(call, call.text)
    first = call.robot.tasks.patrol_places.get(route.name.lower(), 0)
    check_drivable(call)
    call.robot.start(map_scripts.patrol(call.robot, route, once=True, first=first))


@command('gotoRouteGoal', 'Goes to a goal in a route', '<route> <goal>', 2)
def goto_route_goal(call: CommandCall) -> None:
    """Drives directly to a goal that a route lists."""
    route = _route(call, call.arguments[0])
    goal = find_goal(call, call.arguments[1])
    if goal.name.lower() not in (listed.lower() for listed in route.goals):
        raise CommandFailed(f"No goal '{goal.name}'")
    check_drivable(call)
    call.robot.start(activities.go_to_goal(call.robot, goal))
