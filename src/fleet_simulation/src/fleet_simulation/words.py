"""Describes the results of a study in words. Leaves out differences that may be chance."""
from __future__ import annotations

import math
from typing import Sequence, Tuple

from fleet_simulation.figures import Use
from fleet_simulation.hold_ups import Bottleneck
from fleet_simulation.statistics import (
    KEPT_UP,
    WORTH,
    Band,
    Side,
    SizeResults,
    bottlenecks_of,
    gain,
    knee,
    quantile,
    served_share,
    sizes,
    waiting_by_drawn_edge,
)
from fleet_simulation.study import Study

_WORDS = ('no', 'one', 'two', 'three', 'four', 'five', 'six', 'seven', 'eight', 'nine', 'ten',
          'eleven', 'twelve')
_FEW_MINUTES = 0.6  # minutes of waiting per hour and robot (1 %); less is not worth a sentence


def in_words(study: Study) -> str:
    """Returns the results of the study as one paragraph."""
    found = sizes(study.runs)
    if not found:
        return 'No run was completed.'
    best = knee(found)
    sentences = (_throughput_in_words(best), _demand_in_words(study, best),
                 _more_robots_in_words(found, best), _waiting_in_words(study, best),
                 _bottleneck_in_words(best), _deadlines_in_words(best),
                 _proposal_in_words(study), _failures_in_words(best))
    return ' '.join(filter(None, sentences))


def _throughput_in_words(best: SizeResults) -> str:
    lead_time = ''
    if best.leads:
        lead_time = (', 95 % of them with a lead time of up to '
                     f'{time_in_words(quantile(best.leads, 0.95))}')
    return (f'{_count(best.robots, "robot")} {"serve" if best.robots != 1 else "serves"} '
            f'{best.per_hour} missions per hour{lead_time}.')


def _demand_in_words(study: Study, best: SizeResults) -> str:
    if study.site.demand.saturated:
        return ''
    served, demand = served_share(best), f'the demand of {best.requested:.0f} missions per hour'
    side = served.side(KEPT_UP)
    if side is Side.ABOVE:
        return f'This serves {demand}.'
    missing = percent(Band(1.0 - served.mean, served.half))
    if side is Side.BELOW:
        return f'It does not serve {demand}: {missing} of the missions are missing.'
    return (f'{_seeds(best)} too few to decide whether this serves {demand}: {missing} of the '
            'missions are missing.')


def _more_robots_in_words(found: Sequence[SizeResults], best: SizeResults) -> str:
    """Returns a sentence about what the next larger simulated fleet gains over the best fleet."""
    larger = next((size for size in found if size.robots > best.robots), None)
    if larger is None:
        return ('This is the largest simulated fleet: a larger one may serve more.'
                if len(found) > 1 else '')
    number, more = larger.robots - best.robots, gain(best, larger)
    subject, verb = ('One more', 'adds') if number == 1 else (_count(number, 'more'), 'add')
    if more.side() is Side.ABOVE:
        return f'{subject} {verb} {percent(more)}.'
    if more.side() is Side.BELOW:
        return f'With {subject.lower()} it is {percent(Band(-more.mean, more.half))} less.'
    if more.side(WORTH * number) is Side.BELOW:
        each = '' if number == 1 else ' each'
        return f'{subject} {verb} less than {100 * WORTH:.0f} %{each}.'
    return f'{_seeds(best)} too few to decide what {subject.lower()} {verb}: {percent(more)}.'


def _seeds(size: SizeResults) -> str:
    number = len({run.seed for run in size.runs})
    return f'{_count(number, "seed")} {"is" if number == 1 else "are"}'


def percent(share: Band) -> str:
    """Returns a share (0..1) with its band."""
    return str(Band(100.0 * share.mean, 100.0 * share.half)) + ' %'


def _waiting_in_words(study: Study, best: SizeResults) -> str:
    edges = list(waiting_by_drawn_edge(best, study.site.graph).items())[:2]
    if not edges or best.use[Use.WAITING] <= 0.01:
        return ''
    share = 100 * sum(part for _, part in edges)
    ids = ' and '.join(str(id) for id, _ in edges)
    subject, verb = ('edges', 'cause') if len(edges) > 1 else ('edge', 'causes')
    return (f'A robot spends {100 * best.use[Use.WAITING]:.0f} % of its time waiting; '
            f'{subject} {ids} {verb} {share:.0f} % of this waiting.')


def _bottleneck_in_words(best: SizeResults) -> str:
    found = bottlenecks_of(best)
    if not found:
        return ''
    first = found[0]
    if first.minutes < _FEW_MINUTES * best.robots:
        return 'No robot waits long for a station, a device or a charger.'
    told = (f'Of all stations, devices and chargers, {first.resource} is the bottleneck: robots '
            f'wait {_minutes(first.minutes)} per hour for it, mostly for {_main_reason(first)}, '
            f'and {100 * first.occupied:.0f} % of it is occupied')
    if len(found) == 1 or found[1].minutes < _FEW_MINUTES * best.robots:
        return f'{told}.'
    return f'{told}; for {found[1].resource} they wait {_minutes(found[1].minutes)}.'


def _main_reason(one: Bottleneck) -> str:
    return max(one.waiting, key=lambda why: one.waiting[why]).value


def _minutes(minutes: float) -> str:
    return f'{minutes:.0f} robot minutes' if minutes >= 9.5 else f'{minutes:.1f} robot minutes'


def _deadlines_in_words(best: SizeResults) -> str:
    deadlines, missed = deadlines_of(best)
    if not deadlines:
        return ''
    return f'{missed} of {deadlines} deadlines were missed in the runs of this fleet.'


def deadlines_of(size: SizeResults) -> Tuple[int, int]:
    """Returns the number of deadlines, and the number of missed deadlines."""
    return sum(run.deadlines for run in size.runs), sum(run.missed for run in size.runs)


def _proposal_in_words(study: Study) -> str:
    good = [one for one in study.proposals if one.gain.side() is Side.ABOVE]
    if not good:
        return ''
    return f'Best proposal: {good[0].what}. It adds {good[0].gain} missions per hour.'


def _failures_in_words(best: SizeResults) -> str:
    failed = sum(sum(run.failures.values()) for run in best.runs)
    return f'{_count(failed, "mission")} failed in the runs of this fleet.' if failed else ''


def _count(number: int, what: str) -> str:
    word = _WORDS[number] if number < len(_WORDS) else str(number)
    return f'{word[0].upper()}{word[1:]} {what}' + ('s' if number != 1 and what != 'more' else '')


def time_in_words(seconds: float) -> str:
    """Returns a time in s or minutes; a dash for an unknown time."""
    if not math.isfinite(seconds):
        return '-'
    return f'{seconds:.0f} s' if seconds < 100.0 else f'{seconds / 60.0:.1f} minutes'


def several(number: int, what: str) -> str:
    """Returns `1 seed`, `3 seeds`."""
    return f'{number} {what}' + ('s' if number != 1 else '')
