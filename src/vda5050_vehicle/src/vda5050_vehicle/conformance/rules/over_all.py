"""Rules for all that a vehicle said in a run."""
from __future__ import annotations

from typing import TYPE_CHECKING

from vda5050_vehicle.conformance.rules.rule import NotTried, expect, rule

if TYPE_CHECKING:
    from vda5050_vehicle.conformance.bench import Bench


@rule('6.2, 6.14', 'the broker is lost: the base is driven; then ONLINE and a fresh state')
def _broker_lost(bench: Bench) -> None:
    if bench.loss is None:
        raise NotTried('needs --own-broker')
    expect(bench.loss.back_after <= 5.0, f'ONLINE came after {bench.loss.back_after:.1f} s')
    expect(bench.loss.drove_on, 'the vehicle did not drive on without the broker')


@rule('6.10', 'a state comes at least every 30 s')
def _interval(bench: Bench) -> None:
    times = bench.master.arrivals['state']
    longest = max((after - before for before, after in zip(times, times[1:])), default=0.0)
    expect(longest <= 30.0, f'{longest:.1f} s went by without one')


@rule('all', 'every message is as the standard has it')
def _messages(bench: Bench) -> None:
    violations = bench.master.checker.violations
    expect(not violations, f'{len(violations)} broken: ' + '; '.join(violations[:5]))
