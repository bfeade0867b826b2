"""One device: its holders, the mode that it shows, and the output that it must have.

State: the newest request of each requester (`obeyed`), whether a holder may be unknown
(`is_memory_lost`), whether the device is closing, and its last readings. The stage follows from
this state:

    | stage   | is it held?                        | output        |
    |---------|------------------------------------|---------------|
    | HELD    | yes, by a requester                | on            |
    | FOUND   | perhaps: the memory is lost        | as it is      |
    | CLOSING | no, and a claim was given back     | off           |
    | LEFT    | no                                 | as it is      |

    | event                             | in      | then                                           |
    |-----------------------------------|---------|------------------------------------------------|
    | start with the memory             |         | HELD if a requester holds it; if not, LEFT     |
    | start without the memory          |         | FOUND                                          |
    | OPEN with a new number            | any     | HELD                                           |
    | CLOSED; others hold the device    | HELD    | HELD                                           |
    | CLOSED; no other holds the device | any     | CLOSING; FOUND if the memory is lost           |
    | CLOSED of `unknown`               | FOUND   | CLOSING                                        |
    | reads closed `STEADY` times       | CLOSING | LEFT                                           |
    | reads closed `STEADY` times       | any     | the memory is not lost any more, because a     |
    |                                   |         | closed device has no robot in it               |
    | a number that is not new          | any     | no change: the request is a repetition         |

The device is read by *exchanges*, one after the other. If the output is not as it must be, an
exchange also sets it. So a held device is opened again after a wrong reading, after another program
has switched it, and after it has lost its power. Neither time nor the silence of a requester ends a
use: a requester that does not run any more holds the device until a person gives the device back,
or until the requester runs again and gives it back.

    | readings                                                        | mode                       |
    |-----------------------------------------------------------------|----------------------------|
    | none yet                                                        | UNKNOWN                    |
    | none for `offline_after`                                        | OFFLINE (NOT_READ)         |
    | `STEADY` times output and input equal, as the stage needs them  | OPEN or CLOSED             |
    | anything else                                                   | MOVING                     |
    | anything else for longer than the device's timeout              | UNKNOWN (TIMED_OUT)        |

Invariants (`test_device_states.py` checks them in all states, and fails if a rule is left out):

NEVER CLOSES ON A HOLDER  the output is set to off only while no requester holds the device, and
                          only after a claim was given back since the start
OPEN IS NEW     a report that says OPEN shows a request only if an exchange with a reading began
                after the request was taken; the last `STEADY` readings were open, and the last
                reading is not older than `offline_after`
NUMBERS GROW    the number of a requester's newest request never falls, also across restarts with
                the memory
HELD IS OPENED  while a requester holds the device, each exchange sets the output to on, unless
                the last reading shows that it is on
LIVE            a device that works again becomes OPEN for its holder, and CLOSED if the last claim
                was given back
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, NamedTuple, Optional, Tuple

from route_protocol.devices import (
    UNKNOWN_REQUESTER,
    DeviceFault,
    DeviceMode,
    DeviceReport,
    DeviceRequest,
    DeviceUse,
)

STEADY = 2          # number of equal readings in a row that are needed: an input may flicker
MOST_HOLDERS = 100  # maximum number of requesters that hold one device
KEPT = 50           # number of requesters that hold nothing, but whose last numbers are kept

_SETTLED = {True: DeviceMode.OPEN, False: DeviceMode.CLOSED}


class DeviceLimits(NamedTuple):
    """Times of a device (s).

    timeout       -- how long it may take to open or to close
    offline_after -- how long it may have no reading before it is OFFLINE
    """

    timeout: float
    offline_after: float


class Reading(NamedTuple):
    """A reading of a device: whether its output is on, and whether its input says open."""

    output: bool
    is_open: bool


@dataclass(frozen=True)
class DeviceMemory:
    """The stored data of a device. `is_lost`: there may be a holder that is not in `obeyed`."""

    obeyed: Tuple[DeviceUse, ...] = ()
    is_lost: bool = False


LOST = DeviceMemory(is_lost=True)


class Exchange(NamedTuple):
    """The task of a driver: set the output (None: leave it as it is), then read the device."""

    number: int
    output: Optional[bool]


class Stage(Enum):
    """The stage of a device, which describes its holders."""

    HELD = 'held open'
    FOUND = 'perhaps held: the memory is lost'
    CLOSING = 'given back'
    LEFT = 'without a holder'


_OUTPUT = {Stage.HELD: True, Stage.FOUND: None, Stage.CLOSING: False, Stage.LEFT: None}


@dataclass(frozen=True)
class Taken:
    """A use, with the number of exchanges that had begun when it was taken."""

    use: DeviceUse
    begun: int


@dataclass(frozen=True)
class DeviceMachine:
    """The device that the module describes. `now` is in s of a clock that never steps back.

    begun       -- number of exchanges that have begun
    is_awaited  -- whether the last exchange has not ended
    read        -- number of the last exchange that had a reading; 0: none had
    read_at     -- when that exchange began
    output      -- the output in the last reading; None: it must be set again
    settled     -- the last reading: True: open, False: closed, None: neither
    alike       -- how many of the newest readings have the value `settled`; at most STEADY.
                   Readings of exchanges before the stage are left out
    stage_from  -- number of exchanges that had begun when the stage began
    moving_from -- since when the device is not as it must be
    mode, since -- the mode that the device shows, and since when
    problem     -- why the last exchange had no reading; empty: it had one

    It has many attributes because the mode follows from several facts of the last exchanges.
    """

    limits: DeviceLimits
    since: float
    obeyed: Tuple[Taken, ...] = ()
    is_memory_lost: bool = False
    is_closing: bool = False
    begun: int = 0
    is_awaited: bool = False
    begun_at: float = 0.0
    read: int = 0
    read_at: Optional[float] = None
    output: Optional[bool] = None
    settled: Optional[bool] = None
    alike: int = 0
    stage_from: int = 0
    moving_from: float = 0.0
    mode: DeviceMode = DeviceMode.UNKNOWN
    fault: DeviceFault = DeviceFault.NONE
    problem: str = ''

    @classmethod
    def start(cls, limits: DeviceLimits, memory: DeviceMemory, now: float) -> DeviceMachine:
        """Returns the device after a start with its stored memory, or with LOST."""
        return cls(limits, now, tuple(Taken(use, 0) for use in memory.obeyed),
                   is_memory_lost=memory.is_lost, moving_from=now)

    @property
    def stage(self) -> Stage:
        """The stage of the device."""
        if any(taken.use.holds for taken in self.obeyed):
            return Stage.HELD
        if self.is_memory_lost:
            return Stage.FOUND
        return Stage.CLOSING if self.is_closing else Stage.LEFT

    @property
    def memory(self) -> DeviceMemory:
        """The data that must be stored before anything else happens."""
        return DeviceMemory(tuple(taken.use for taken in self.obeyed), self.is_memory_lost)

    @property
    def is_urgent(self) -> bool:
        """Whether the device answers, and a use was taken after its last reading began."""
        return not self.problem and not all(map(self._is_read, self.obeyed))

    def refusal(self, request: DeviceRequest) -> str:
        """Returns why a request cannot be taken, as a clause; empty: it can be taken."""
        others = sum(one.use.holds for one in self.obeyed if one.use.requester != request.requester)
        if request.mode is DeviceMode.OPEN and others >= MOST_HOLDERS:
            return f'{MOST_HOLDERS} others hold it already'
        return ''

    # --- events -----------------------------------------------------------------------------------

    def ask(self, request: DeviceRequest, now: float, stamp: float) -> DeviceMachine:
        """Returns the device after a request; the same object if the request changes nothing.

        stamp -- the time that is noted as the beginning of the use
        The caller must store `memory` before it does or reports anything.
        """
        if request.requester == UNKNOWN_REQUESTER:
            return self._with(now, is_memory_lost=False, is_closing=True) if (
                self.is_memory_lost and request.mode is DeviceMode.CLOSED) else self
        before = next((taken.use for taken in self.obeyed
                       if taken.use.requester == request.requester), None)
        if self.refusal(request) or before is not None and not self._is_new(request, before):
            return self
        use = DeviceUse(request.requester, request.mode, request.number, stamp)
        others = tuple(taken for taken in self.obeyed if taken.use is not before)
        return self._with(now, obeyed=_kept((*others, Taken(use, self.begun))),
                          is_closing=not use.holds)

    def begin(self, now: float) -> Tuple[DeviceMachine, Exchange]:
        """Returns the device at the beginning of an exchange, and the exchange.

        The exchange before it must have ended.
        """
        wanted = _OUTPUT[self.stage]
        number = self.begun + 1
        return (replace(self, begun=number, begun_at=now, is_awaited=True),
                Exchange(number, None if wanted == self.output else wanted))

    def end(self, reading: Optional[Reading], problem: str, now: float) -> DeviceMachine:
        """Returns the device after the end of the exchange.

        reading -- None: there was none, because of `problem`

        An exchange without a reading may still have an effect, so the output must be set again.
        """
        if reading is None:
            return replace(self, is_awaited=False, output=None, problem=problem).tick(now)
        settled = reading.is_open if reading.is_open == reading.output else None
        alike = min(self.alike + 1, STEADY) if self._continues(settled) else 1
        if self.begun <= self.stage_from:
            alike = 0
        return replace(self, is_awaited=False, read=self.begun, read_at=self.begun_at,
                       output=reading.output, settled=settled, alike=alike, problem='').tick(now)

    def tick(self, now: float) -> DeviceMachine:
        """Returns the device after some time, with the mode that it shows now."""
        mode, fault = self._shown(now)
        after = self
        if mode is DeviceMode.OFFLINE:  # earlier readings do not count any more
            after = replace(after, alike=0, output=None)
        elif self._is_steady() and self.settled is False:
            after = replace(after, is_closing=False, is_memory_lost=False)
        if mode is DeviceMode.MOVING and self.mode is not DeviceMode.MOVING:
            after = replace(after, moving_from=now)
        if (mode, fault) != (self.mode, self.fault):
            after = replace(after, mode=mode, fault=fault, since=now)
        return after

    # --- what it shows ----------------------------------------------------------------------------

    def report(self, name: str) -> DeviceReport:
        """Returns the report on the device, without run and count."""
        shown = [taken for taken in self.obeyed
                 if self.mode is not DeviceMode.OPEN or self._is_read(taken)]
        obeyed = tuple(taken.use for taken in shown)
        if self.is_memory_lost:
            obeyed += (DeviceUse(UNKNOWN_REQUESTER, DeviceMode.OPEN, 0, 0.0),)
        return DeviceReport(name, self.mode, self.since, self.read_at, obeyed, self.fault,
                            self._reason())

    def _reason(self) -> str:
        if self.fault is DeviceFault.NOT_READ:
            return self.problem or 'it does not answer'
        if self.fault is DeviceFault.NONE:
            return ''
        wanted = _OUTPUT[self.stage]
        aim = 'come to rest' if wanted is None else ('open' if wanted else 'close')
        return f'it does not {aim} within {self.limits.timeout:g} s: {self._readings()}'

    def _readings(self) -> str:
        if self.alike < STEADY:
            return 'its readings change'
        if self.settled is not None:
            return f'it reads {"open" if self.settled else "closed"}'
        return ('its output is on, and it does not read open' if self.output else
                'its output is off, and it reads open')

    def _shown(self, now: float) -> Tuple[DeviceMode, DeviceFault]:
        last = self.since if self.read_at is None else self.read_at
        if now - last > self.limits.offline_after:
            return DeviceMode.OFFLINE, DeviceFault.NOT_READ
        if self.read_at is None:
            return self.mode, self.fault
        if self._is_steady() and _OUTPUT[self.stage] in (None, self.settled):
            assert self.settled is not None
            return _SETTLED[self.settled], DeviceFault.NONE
        late = self.mode in (DeviceMode.MOVING, DeviceMode.UNKNOWN)
        if late and now - self.moving_from > self.limits.timeout:
            return DeviceMode.UNKNOWN, DeviceFault.TIMED_OUT
        return DeviceMode.MOVING, DeviceFault.NONE

    # --- rules ------------------------------------------------------------------------------------

    @staticmethod
    def _is_new(request: DeviceRequest, use: DeviceUse) -> bool:
        return request.number > use.number

    def _is_read(self, taken: Taken) -> bool:
        """Returns whether the device was read in an exchange that began after the use was taken."""
        return self.read > taken.begun

    def _continues(self, settled: Optional[bool]) -> bool:
        """Returns whether a reading has the same value as the counted readings before it."""
        return self.alike > 0 and settled == self.settled

    def _is_steady(self) -> bool:
        return self.settled is not None and self.alike >= STEADY

    def _with(self, now: float, **changes: Any) -> DeviceMachine:
        """Returns the device after a change.

        If a new stage begins, its time limit starts, and earlier readings do not count any more.
        """
        after = replace(self, **changes)
        if after.stage is not self.stage:
            after = replace(after, moving_from=now, alike=0, stage_from=self.begun)
        return after.tick(now)


def _kept(obeyed: Tuple[Taken, ...]) -> Tuple[Taken, ...]:
    """Returns all requests that hold the device, and the newest KEPT requests that do not hold it.
    """
    ended = [taken for taken in obeyed if not taken.use.holds]
    forgotten = ended[:-KEPT]
    return tuple(taken for taken in obeyed if taken not in forgotten)
