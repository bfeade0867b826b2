"""The executive: carries out one activity at a time, and steps the base while it moves.

An activity's script is a generator (`states.ScriptedActivity`). It yields a number of seconds to
wait, or `STANDING` to wait until the base stands.

    event                             no activity       an activity runs
    `run`                             it begins         the base brakes, and the new one begins
    the wait is over; the base stands -                 the script goes on
    the script ends                   -                 no activity is left
    the script fails                  -                 no activity is left; the base brakes
    `drop`                            -                 no activity is left; the base goes on

Invariants: there is at most one script, and it waits for at most one event. A script must not end
itself while it runs. So `outside` delays an action that may do this until the script's next pause.
"""
from __future__ import annotations

from typing import Callable, List, Optional

from omron_ld90_sim.behaviour.states import ActivityFailure, ScriptedActivity, Standing
from omron_ld90_sim.clock import SimClock, Timer
from omron_ld90_sim.motion.base import STEP
from omron_ld90_sim.motion.navigation import Navigation
from omron_ld90_sim.motion.track import Manoeuvre


class Executive:
    """Runs the activity of one robot on the clock.

    Its attributes are the running script and the event for which the script waits.
    """

    def __init__(self, clock: SimClock, navigation: Navigation, stepping: Callable[[], None],
                 failed: Callable[[ActivityFailure], None]) -> None:
        """`stepping` is called before every step of the base, `failed` when a script fails."""
        self.activity: Optional[ScriptedActivity] = None
        self._clock, self._navigation, self._base = clock, navigation, navigation.base
        self._stepping, self._failed = stepping, failed
        self._step_timer: Optional[Timer] = None
        self._wait_timer: Optional[Timer] = None
        self._when_still: Optional[Callable[[], None]] = None
        self._in_script = False
        self._afterwards: List[Callable[[], None]] = []

    # -- activities --------------------------------------------------------------------------

    def run(self, activity: ScriptedActivity) -> None:
        """Begins an activity. The base brakes, unless the script sets a course at once."""
        if self._wait_timer is not None:
            self._wait_timer.cancel()
        self.brake()
        self.activity = activity
        self._resume()

    def drop(self) -> None:
        """Ends the activity silently; the base moves on. A script must call this with `outside`."""
        if self._wait_timer is not None:
            self._wait_timer.cancel()
        self._when_still = None
        activity, self.activity = self.activity, None
        if activity is not None:
            activity.script.close()

    def outside(self, action: Callable[[], None]) -> None:
        """Runs an action that may end the activity: at once if it comes from outside the script,
        otherwise at the next pause of the script."""
        if self._in_script:
            self._afterwards.append(action)
        else:
            action()

    def _resume(self) -> None:
        activity = self.activity
        if activity is None:
            return
        self._in_script = True
        try:
            request = next(activity.script)
        except StopIteration:
            self.activity = None
        except ActivityFailure as failure:
            self.activity = None
            self.brake()
            self._failed(failure)
        else:
            if isinstance(request, Standing):
                self._when_still = self._resume
                self._keep_stepping()
            else:
                self._wait_timer = self._clock.after(request, self._resume)
        finally:
            self._in_script = False
        actions, self._afterwards = self._afterwards, []
        for action in actions:
            action()

    # -- the base ----------------------------------------------------------------------------

    def brake(self, deceleration: Optional[float] = None,
              then: Optional[Callable[[], None]] = None, at_least: float = 0.0) -> None:
        """Brings the base to rest, like `Base.brake`, and calls `then` when it stands.

        at_least -- s until `then` is called if the base stands already
        """
        self._base.brake(deceleration)
        if self._base.still and then is not None and at_least:
            self._wait_timer = self._clock.after(at_least, then)
            return
        if self._base.still and then is not None:
            then()
            return
        self._when_still = then
        self._keep_stepping()

    def set_course(self, x: float, y: float, heading: Optional[float]) -> None:
        """Sends the base to a place, like `Navigation.set_course`."""
        self._navigation.set_course(x, y, heading)
        self._keep_stepping()

    def follow(self, manoeuvres: List[Manoeuvre]) -> None:
        """Makes the standing base carry out manoeuvres."""
        self._base.follow(manoeuvres)
        self._keep_stepping()

    def _keep_stepping(self) -> None:
        if self._step_timer is None or not self._step_timer.waiting:
            self._step_timer = self._clock.after(STEP, self._step)

    def _step(self) -> None:
        self._stepping()
        self._base.step(STEP)
        if self._navigation.blocked_ahead():
            self._base.brake()
        if not self._base.still:
            self._keep_stepping()
            return
        then, self._when_still = self._when_still, None
        if then is not None:
            then()
