"""Templates of missions: stops in which parameters stand for places and for texts of steps.

The fleet manager fills a template in when it accepts a mission, and stores the stops. So the
mission stays the same if the work file changes later, even if the request is sent again. The sender
needs no work file: only the fleet manager reads it. The fleet manager also runs the timetables.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, Iterable, Iterator, Mapping, Tuple

from fleet_core.work.stops import Condition, StopKind, WorkStep, WorkStop

PARAMETER = '$'
"""A text that begins with this sign names a parameter."""


@dataclass(frozen=True)
class TemplateStop:
    """A stop of a template.

    at    -- the name of a station, the id or the label of a vertex, or a parameter
    steps -- the values in their `parameters` may be parameters of the template
    """

    at: str
    kind: StopKind = StopKind.VISIT
    steps: Tuple[WorkStep, ...] = ()
    condition: Condition = Condition.ALWAYS


@dataclass(frozen=True)
class Template:
    """A mission that is sent with arguments for its parameters."""

    name: str
    parameters: Tuple[str, ...]
    stops: Tuple[TemplateStop, ...]
    on_cancel: Tuple[TemplateStop, ...] = ()


def parameters_in(stop: TemplateStop) -> Iterator[str]:
    """Returns the names of the parameters that a stop uses."""
    texts = (stop.at, *(value for step in stop.steps for _, value in step.parameters))
    return (text[len(PARAMETER):] for text in texts if text.startswith(PARAMETER))


class WrongArguments(ValueError):
    """Arguments that do not fit a template. The text is a clause that says why and what to do."""


def check_arguments(template: Template, names: Iterable[str]) -> None:
    """Raises WrongArguments unless there is one argument for each parameter."""
    given = list(names)
    told = f'template {template.name} has the parameters ' \
           f'{", ".join(template.parameters) or "none"}'
    for name in given:
        if name not in template.parameters:
            raise WrongArguments(f'{name!r} is no parameter: {told}')
        if given.count(name) > 1:
            raise WrongArguments(f'{name!r} is given twice: {told}')
    for name in template.parameters:
        if name not in given:
            raise WrongArguments(f'{name!r} is not given: {told}')


def filled(stops: Iterable[TemplateStop], arguments: Mapping[str, str],
           place: Callable[[str], int],
           group: Callable[[str], str] = lambda _: '') -> Tuple[WorkStop, ...]:
    """Returns the stops with arguments in place of their parameters.

    place -- returns the vertex for the word of a stop, or raises an error, which is passed on
    group -- returns the group that the word of a stop names; empty: it names none
    """
    def text(word: str) -> str:
        return arguments[word[len(PARAMETER):]] if word.startswith(PARAMETER) else word

    def step(one: WorkStep) -> WorkStep:
        return replace(one, parameters=tuple((name, text(value))
                                             for name, value in one.parameters))
    return tuple(WorkStop(place(text(stop.at)), stop.kind, tuple(map(step, stop.steps)),
                          stop.condition, group(text(stop.at))) for stop in stops)
