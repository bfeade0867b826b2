"""A robot in a place that needs a door, a zone or a station is the only one with that resource.

A claim is stored before a request is sent to the device. The claim ends only when no place needs
the resource, never after a time limit. So the device stays open for each robot that may be in it.
This holds for any number of robots, places and resources. A resource of capacity n counts as n
resources; a robot claims a free one. In `test_door_yard.py`, requests come late.
"""
from __future__ import annotations

from induction import Action, Formula, Relations, System, proof_of, z3

Robot, Place, Resource = map(z3.DeclareSort, ('Robot', 'Place', 'Resource'))
needs = z3.Function('needs', Place, Resource, z3.BoolSort())
r, s = z3.Consts('r s', Robot)
p = z3.Const('p', Place)
d = z3.Const('d', Resource)
robot, place = z3.Const('the robot', Robot), z3.Const('the place', Place)
resource = z3.Const('the resource', Resource)


def has_its_claims(places, claims) -> Formula:
    return z3.ForAll([r, p, d], z3.Implies(z3.And(places(r, p), needs(p, d)), claims(r, d)))


def has_one_holder(claims) -> Formula:
    return z3.ForAll([r, s, d], z3.Implies(z3.And(claims(r, d), claims(s, d)), r == s))


def contains(outer, inner, thing) -> Formula:
    return z3.ForAll([r, thing], z3.Implies(inner(r, thing), outer(r, thing)))


def invariants(of: Relations):
    return {
        'an allocated place has its claims': has_its_claims(of['allocation'], of['claim']),
        'a stored place has its stored claims': has_its_claims(of['journal'], of['stored_claim']),
        'a robot holds what its place needs': has_its_claims(of['at'], of['claim']),
        'a device is open for an allocated place': has_its_claims(of['allocation'],
                                                                  of['open_for']),
        'a device is open for a stored place': has_its_claims(of['journal'], of['open_for']),
        'a claim has one holder': has_one_holder(of['claim']),
        'a stored claim has one holder': has_one_holder(of['stored_claim']),
        'a claim is stored': contains(of['stored_claim'], of['claim'], d),
        'sent is in allocation': contains(of['allocation'], of['sent'], p),
        'sent is in journal': contains(of['journal'], of['sent'], p),
        'at is in allocation': contains(of['allocation'], of['at'], p),
        'at is in journal': contains(of['journal'], of['at'], p),
    }


SYSTEM = System({'allocation': (Robot, Place), 'journal': (Robot, Place), 'sent': (Robot, Place),
                 'at': (Robot, Place), 'claim': (Robot, Resource),
                 'stored_claim': (Robot, Resource), 'open_for': (Robot, Resource)}, invariants)
before, after = SYSTEM.before, SYSTEM.after


def no_place_needs_it(relation: str) -> Formula:
    return z3.ForAll([p], z3.Implies(before[relation](robot, p), z3.Not(needs(p, resource))))


ACTIONS = {
    'claim, stored and then asked for': Action(
        {'no other robot has it in the journal': z3.ForAll([s], z3.Implies(
            s != robot, z3.Not(before['stored_claim'](s, resource))))},
        SYSTEM.with_changes(claim=SYSTEM.adding('claim', robot, resource),
                            stored_claim=SYSTEM.adding('stored_claim', robot, resource))),
    'grant, stored and sent': Action(
        {'the robot holds every claim that the place needs': z3.ForAll([d], z3.Implies(
            needs(place, d), before['claim'](robot, d))),
         'the device is open for the robot': z3.ForAll([d], z3.Implies(
             needs(place, d), before['open_for'](robot, d)))},
        SYSTEM.with_changes(**{name: SYSTEM.adding(name, robot, place)
                               for name in ('allocation', 'journal', 'sent')})),
    'robot moves': Action(
        {'it keeps inside its order': z3.ForAll([p], z3.Implies(
            after['at'](robot, p), z3.Or(before['at'](robot, p), before['sent'](robot, p))))},
        SYSTEM.with_arbitrary('at', only=robot)),
    'report frees a place': Action(
        {'the robot is not there': z3.Not(before['at'](robot, place)),
         'no order to it is under way': z3.Not(before['sent'](robot, place))},
        SYSTEM.with_changes(**{name: SYSTEM.removing(name, robot, place)
                               for name in ('allocation', 'journal')})),
    'claim ends': Action(
        {'no allocated place needs it': no_place_needs_it('allocation'),
         'no stored place needs it': no_place_needs_it('journal')},
        SYSTEM.with_changes(claim=SYSTEM.removing('claim', robot, resource),
                            stored_claim=SYSTEM.removing('stored_claim', robot, resource))),
    'device opens for a robot': Action(
        {}, SYSTEM.with_changes(open_for=SYSTEM.adding('open_for', robot, resource))),
    'device closes for a robot': Action(
        {'the robot does not claim it by the journal': z3.Not(
            before['stored_claim'](robot, resource))},
        SYSTEM.with_changes(open_for=SYSTEM.removing('open_for', robot, resource))),
    'restart from the journal': Action(
        {}, SYSTEM.with_changes(allocation=before['journal'], claim=before['stored_claim'])),
}
NEEDED_FOR = {
    'no other robot has it in the journal': 'a stored claim has one holder',
    'the robot holds every claim that the place needs': 'an allocated place has its claims',
    'the device is open for the robot': 'a device is open for an allocated place',
    'the robot does not claim it by the journal': 'a device is open for an allocated place',
    'it keeps inside its order': 'at is in allocation',
    'the robot is not there': 'at is in allocation',
    'no order to it is under way': 'sent is in allocation',
    'no allocated place needs it': 'an allocated place has its claims',
    'no stored place needs it': 'a stored place has its stored claims',
}

TestClaims = proof_of(SYSTEM, ACTIONS, NEEDED_FOR)
