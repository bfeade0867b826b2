"""Allocations of any number of robots never exclude each other, and they are always stored.

The proof holds for any relation of exclusion. A grant is made in memory, then stored, perhaps
together with entries of other robots, and then sent.
The model of numbered orders shows how one robot obeys its orders.
"""
from __future__ import annotations

from induction import Action, Formula, Relations, System, proof_of, z3

Robot, Place = z3.DeclareSort('Robot'), z3.DeclareSort('Place')
excludes = z3.Function('excludes', Place, Place, z3.BoolSort())
is_stored = z3.Function('is stored in this commit', Robot, z3.BoolSort())
r, s = z3.Consts('r s', Robot)
p, q = z3.Consts('p q', Place)
robot, place = z3.Const('the robot', Robot), z3.Const('the place', Place)

IN_ALLOCATION = ('sent', 'obeyed', 'at')  # the allocation and the journal contain these relations


def are_apart(relation) -> Formula:
    return z3.ForAll([r, s, p, q], z3.Implies(
        z3.And(r != s, relation(r, p), relation(s, q)), z3.Not(excludes(p, q))))


def contains(outer, inner) -> Formula:
    return z3.ForAll([r, p], z3.Implies(inner(r, p), outer(r, p)))


def invariants(of: Relations):
    found = {'allocations are apart': are_apart(of['allocation']),
             'journal entries are apart': are_apart(of['journal'])}
    for outer in ('allocation', 'journal'):
        for inner in IN_ALLOCATION:
            found[f'{inner} is in {outer}'] = contains(of[outer], of[inner])
    return found


SYSTEM = System(dict.fromkeys(('allocation', 'journal', *IN_ALLOCATION), (Robot, Place)),
                invariants)
before, after = SYSTEM.before, SYSTEM.after


def exclude_each_other(one, other) -> Formula:
    return z3.Or(excludes(one, other), excludes(other, one))


ACTIONS = {
    'grant': Action(
        {'no other allocation excludes the place': z3.ForAll([s, q], z3.Implies(
            z3.And(s != robot, before['allocation'](s, q)),
            z3.Not(exclude_each_other(place, q))))},
        SYSTEM.with_changes(allocation=SYSTEM.adding('allocation', robot, place))),
    'commit of some robots': Action(
        {'robots whose old entries exclude a new one are stored too': z3.ForAll(
            [r, s, p, q], z3.Implies(
                z3.And(r != s, is_stored(r), z3.Not(is_stored(s)), before['allocation'](r, p),
                       before['journal'](s, q)),
                z3.Not(exclude_each_other(p, q))))},
        SYSTEM.with_changes(journal=lambda x, y: z3.If(
            is_stored(x), before['allocation'](x, y), before['journal'](x, y)))),
    'send': Action(
        {'the place is allocated': before['allocation'](robot, place),
         'the place is stored': before['journal'](robot, place)},
        SYSTEM.with_changes(sent=SYSTEM.adding('sent', robot, place))),
    'order arrives': Action(
        {'it was sent': z3.ForAll([p], z3.Implies(
            after['obeyed'](robot, p),
            z3.Or(before['obeyed'](robot, p), before['sent'](robot, p))))},
        SYSTEM.with_arbitrary('obeyed', only=robot)),
    'robot moves': Action(
        {'it keeps inside its order': z3.ForAll([p], z3.Implies(
            after['at'](robot, p), z3.Or(before['at'](robot, p), before['obeyed'](robot, p))))},
        SYSTEM.with_arbitrary('at', only=robot)),
    'order is lost': Action({}, SYSTEM.with_changes(sent=SYSTEM.removing('sent', robot, place))),
    'report frees a place': Action(
        {'the robot is not there': z3.Not(before['at'](robot, place)),
         'it obeys no order to it': z3.Not(before['obeyed'](robot, place)),
         'no order to it is under way': z3.Not(before['sent'](robot, place))},
        SYSTEM.with_changes(allocation=SYSTEM.removing('allocation', robot, place))),
    'restart from the journal': Action({}, SYSTEM.with_changes(allocation=before['journal'])),
}
NEEDED_FOR = {
    'no other allocation excludes the place': 'allocations are apart',
    'robots whose old entries exclude a new one are stored too': 'journal entries are apart',
    'the place is allocated': 'sent is in allocation',
    'the place is stored': 'sent is in journal',
    'it was sent': 'obeyed is in allocation',
    'it keeps inside its order': 'at is in allocation',
    'the robot is not there': 'at is in allocation',
    'it obeys no order to it': 'obeyed is in allocation',
    'no order to it is under way': 'sent is in allocation',
}

TestAllocations = proof_of(SYSTEM, ACTIONS, NEEDED_FOR)
