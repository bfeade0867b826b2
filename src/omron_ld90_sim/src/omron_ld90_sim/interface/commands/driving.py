"""Commands that move, stop or localize the robot."""
from __future__ import annotations

from omron_ld90_sim.behaviour import activities, instant_tasks, task
from omron_ld90_sim.behaviour.states import DockingPhase, MotorState
from omron_ld90_sim.interface.commands.table import CommandCall, CommandFailed, command
from omron_ld90_sim.motion.kinematics import SimPose, normalise
from omron_ld90_sim.motion.planner import NoWay
from omron_map import MapObject

LOCALIZING = 1.0    # s between the two lines of localizeToPoint


def check_drivable(call: CommandCall) -> None:
    """Refuses a driving command if the motors are off, the robot is lost, or driving is blocked."""
    robot = call.robot
    if robot.permission.motors is not MotorState.ENABLED:
        raise CommandFailed(robot.permission.motors.value)
    if robot.localization.lost:
        raise CommandFailed('Robot lost')
    if robot.permission.blocked_by:
        _, name = robot.permission.blocked_by[0]
        raise CommandFailed(f'Driving blocked by {name}')


def find_goal(call: CommandCall, name: str) -> MapObject:
    """Returns the goal with that name, ignoring case."""
    goal = task.find_goal(call.robot.document, name)
    if goal is None:
        raise CommandFailed(f"No goal '{name}'")
    return goal


@command('goto', 'Goes to a goal', '<goal> [heading]', 1)
def goto(call: CommandCall) -> None:
    """Drives to a goal; leaves the dock first if necessary."""
    arguments = call.arguments
    goal = find_goal(call, arguments[0])
    heading = normalise(call.number(1)) if len(arguments) > 1 else None
    check_drivable(call)
    call.robot.start(activities.go_to_goal(call.robot, goal, heading))


@command('gotoPoint', 'Goes to a point', '<X> <Y> [heading]', 2)
def goto_point(call: CommandCall) -> None:
    """Drives to a pose in mm and degrees."""
    x, y = call.number(0), call.number(1)
    heading = normalise(call.number(2)) if len(call.arguments) > 2 else None
    check_drivable(call)
    call.robot.start(activities.go_to_point(call.robot, x, y, heading))


@command('stop', 'Stops the robot')
def stop(call: CommandCall) -> None:
    """Ends the activity."""
    call.robot.stop()


@command('go', 'Lets the robot go on')
@command('stay', 'Lets the robot stay')
@command('follow', 'Lets the robot follow')
@command('modeLock', 'Locks the mode')
@command('modeUnlock', 'Unlocks the mode')
@command('etaRequest', 'Requests the time of arrival')
@command('goalDistanceRemaining', 'Gets the distance to the goal')
@command('trackSectors', 'Lists the sectors')
@command('scanStart', 'Starts a scan')
@command('scanStop', 'Stops a scan')
@command('scanAddGoal', 'Adds a goal to a scan')
def known_by_name(call: CommandCall) -> None:
    """Refuses a command that real robots list in their help, but that no source describes."""
    raise CommandFailed(f'{call.line.split()[0]} is not simulated: no source describes its answer')


@command('dock', 'Sends the robot to the dock')
def dock(call: CommandCall) -> None:
    """Drives to the nearest dock and into it; a docked robot stays."""
    robot = call.robot
    station = activities.nearest_dock(robot)
    if station is None:
        raise CommandFailed('No dock')
    check_drivable(call)
    if robot.docking.state is DockingPhase.DOCKED:
        call.reply(robot.docking.line)
    else:
        robot.start(activities.dock(robot, station))


@command('undock', 'Undocks the robot')
def undock(call: CommandCall) -> None:
    """Backs out of the dock."""
    check_drivable(call)
    call.robot.start(activities.undock(call.robot))


@command('queryDockStatus', 'Gets the docking/charging status')
def query_dock_status(call: CommandCall) -> None:
    """Answers the docking state."""
    call.robot.docking.update()
    call.reply(call.robot.docking.line)


@command('enableMotors', 'Enables the motors so the robot can drive again')
def enable_motors(call: CommandCall) -> None:
    """Switches the motors on again; the answers are those of ARCL manual I617-E-02 p. 79."""
    call.reply('Motors are enabled' if call.robot.permission.enable_motors()
               else 'Estop pressed cannot enable motors')


@command('queryMotors', 'Queries the state of the motors')
def query_motors(call: CommandCall) -> None:
    """Answers the motors' state."""
    call.reply(call.robot.permission.motors.value)


@command('localizeToPoint', 'Localizes to a point', '<X> <Y> <T> [xySpread angleSpread]', 3)
def localize_to_point(call: CommandCall) -> None:
    """Searches for the robot around a pose."""
    pose = SimPose(call.number(0), call.number(1), normalise(call.number(2)))
    _localize(call, pose, call.number(3, -1.0), call.number(4, -1.0), 'point')


@command('localizeAtGoal', 'Localizes at a goal', '<goal> [xySpread angleSpread]', 1)
def localize_at_goal(call: CommandCall) -> None:
    """Searches for the robot around a goal, with the goal's heading. If the goal has no heading,
    the robot's true heading is used.
    """
    goal = find_goal(call, call.arguments[0])
    heading = goal.theta if goal.has_heading else call.robot.true_pose.theta
    _localize(call, SimPose(goal.x, goal.y, heading), call.number(1, -1.0), call.number(2, -1.0),
              f'goal {goal.name}')


def _localize(call: CommandCall, pose: SimPose, xy_spread: float, angle_spread: float,
              what: str) -> None:
    robot, session = call.robot, call.session
    session.send(f'Localizing at {what}')

    def localized() -> None:
        instant_tasks.localize(robot, pose, xy_spread, angle_spread)
        session.send(f'Localized to {what}')

    robot.clock.after(LOCALIZING, localized)


@command('distanceBetween', 'Gets the distance between two goals', '<goal> <goal>', 2)
def distance_between(call: CommandCall) -> None:
    """Answers the length of the path from one goal to another."""
    first, second = (find_goal(call, name) for name in call.arguments[:2])
    length = _length(call, SimPose(first.x, first.y, first.theta), second)
    call.reply(f'DistanceBetween: {length:.0f} "{first.name}" "{second.name}"')


@command('distanceFromHere', 'Gets the distance from here to a goal', '<goal>', 1)
def distance_from_here(call: CommandCall) -> None:
    """Answers the length of the path to a goal, in the form that clients of real robots read."""
    goal = find_goal(call, call.arguments[0])
    call.reply(f'DistanceFromHere: {_length(call, call.robot.pose, goal):.0f} "{goal.name}"')


def _length(call: CommandCall, start: SimPose, goal: MapObject) -> float:
    try:
        return call.robot.navigation.planner.plan(start, goal.x, goal.y).length
    except NoWay as error:
        raise CommandFailed('Cannot find path') from error


@command('applicationBlockDrivingSet', 'Sets an application blockDriving',
         '<name> <shortDesc> <longDesc>', 3, 'abds')
def block_driving(call: CommandCall) -> None:
    """Forbids driving and cancels a drive; no source describes an answer."""
    call.robot.permission.block('application', call.arguments[0])


@command('applicationBlockDrivingClear', 'Clears an application blockDriving', '<name>', 1, 'abdc')
def unblock_driving(call: CommandCall) -> None:
    """Allows driving again."""
    if not call.robot.permission.unblock('application', call.arguments[0]):
        raise CommandFailed(f"No block '{call.arguments[0]}'")
