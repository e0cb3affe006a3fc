"""The attributes of an environment: there, of the right kind, and fitting each other."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import fields
from inspect import getattr_static
from typing import cast

import numpy as np

from bpns.symbolic.environment_check.findings import Remarks, fault, kind_of, raised
from bpns.symbolic.errors import InputError
from bpns.symbolic.pddl.write import model_names
from bpns.symbolic.skills.environment import Budget, Environment, domain_of
from bpns.symbolic.skills.skill import GivenPolicy, GivenSkill, Skill
from bpns.symbolic.structs import OBJECT, Object, Predicate, Type

NAMES = sorted(name for name in dir(Environment) if not name.startswith("_"))


def attributes(subject: object) -> Remarks:
    """Look for every attribute of the protocol; each fault is about one of them."""
    for name in NAMES:
        if _left_open(subject, name):
            yield fault(f"{name} is missing: symbolic/environment.py says what it is", name)
            continue
        try:
            value = getattr(subject, name)
        except Exception as error:
            yield fault(f"{name} cannot be read: {raised(error, subject)}", name)
            continue
        for wrong in _KINDS[name](value):
            yield fault(f"{name} {wrong}", name)
            break
    if not _bounds_fit(subject):
        yield fault("action_low must have the shape of action_high and be at most as high", "action_high")
    return f"all {len(NAMES)} are there"


def _left_open(subject: object, name: str) -> bool:
    """Say whether an attribute is missing, or only the protocol's own (in a subclass of it)."""
    written = getattr_static(subject, name, None)
    return written is vars(Environment)[name] or (written is None and not hasattr(subject, name))


def _bounds_fit(subject: object) -> bool:
    """Say whether the lower bounds are below the upper ones, unless either is faulty by itself."""
    low, high = getattr(subject, "action_low", None), getattr(subject, "action_high", None)
    if any(_bound(low)) or any(_bound(high)):
        return True
    return np.shape(low) == np.shape(high) and bool(np.all(np.less_equal(low, high)))  # type: ignore[arg-type]


# ------------------------------------------------- one function a kind; each gives what is wrong


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"a {kind_of(value)}"


def _text(value: object) -> Iterable[str]:
    if not isinstance(value, str) or not value:
        yield f"is {_shown(value)}: give a text, fit for a PDDL name"


def _types(value: object) -> Iterable[str]:
    if not isinstance(value, tuple) or not value or not all(isinstance(v, Type) for v in value):
        yield f"is {_shown(value)}: give a tuple of bpns.symbolic.structs.Type, at least one"
        return
    for kind in value:
        if not isinstance(kind.features, tuple) or len(set(kind.features)) < len(kind.features):
            yield f"has {kind.name} with features {kind.features!r}: give a tuple of different names"


def _classifiers(value: object) -> Iterable[str]:
    if not isinstance(value, Mapping) or not value:
        yield f"is {_shown(value)}: give a mapping from Predicate to a function (state, objects) -> bool"
        return
    for predicate, classifier in value.items():
        if not isinstance(predicate, Predicate):
            yield f"has the key {_shown(predicate)}: give a bpns.symbolic.structs.Predicate"
        elif not callable(classifier):
            yield f"has no function for {predicate.name}, but {_shown(classifier)}"


def _predicates(value: object) -> Iterable[str]:
    if not isinstance(value, frozenset) or not value or not all(isinstance(v, Predicate) for v in value):
        yield f"is {_shown(value)}: give a frozenset of bpns.symbolic.structs.Predicate, at least one"


def _skills(value: object) -> Iterable[str]:
    if not isinstance(value, tuple) or not all(isinstance(v, Skill) for v in value):
        yield f"is {_shown(value)}: give a tuple of bpns.symbolic.skills.skill.Skill"
        return
    for skill in value:
        name, dimension = skill.operator.name, getattr(skill.sampler, "dimension", None)
        if not callable(getattr(skill.policy, "begin", None)):
            yield f"has {name}, whose policy has no method 'begin'"
        if not callable(getattr(skill.sampler, "sample", None)) or not _is_count(dimension, 0):
            yield f"has {name}, whose sampler has no method 'sample' or no whole number 'dimension'"
        if skill.terminal is not None and not callable(skill.terminal):
            yield f"has {name}, whose terminal is {_shown(skill.terminal)}, not a function or None"
        if skill.max_actions is not None and not _is_count(skill.max_actions, 1):
            yield f"has {name}, whose max_actions is {_shown(skill.max_actions)}, not a positive int or None"


def _given(value: object) -> Iterable[str]:
    if not isinstance(value, tuple) or not all(isinstance(v, GivenSkill) for v in value):
        yield f"is {_shown(value)}: give a tuple of bpns.symbolic.skills.skill.GivenSkill, mostly ()"
        return
    names = [skill.name for skill in value]
    if len(set(names)) < len(names):
        yield f"has several of one name: {', '.join(map(str, names))}"
    for skill in value:
        if not callable(getattr(skill.policy, "begin", None)):
            yield f"has {skill.name}, whose policy has no method 'begin'"


def _bound(value: object) -> Iterable[str]:
    if not isinstance(value, np.ndarray):
        yield f"is {_shown(value)}: give a numpy array"
    elif value.dtype != np.float32 or value.ndim != 1 or not value.size:
        yield f"is {value.dtype} of shape {value.shape}: give float32 of shape (A,)"
    elif np.isnan(value).any():
        yield "has NaN: give a number or an infinity for each component"


def _is_count(value: object, least: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= least


def _positive(value: object) -> Iterable[str]:
    if not _is_count(value, 1):
        yield f"is {_shown(value)}: give a positive int"


def _budget(value: object) -> Iterable[str]:
    if not isinstance(value, Budget):
        yield f"is {_shown(value)}: give a bpns.symbolic.skills.environment.Budget"
        return
    for field in fields(value):
        if not _is_count(getattr(value, field.name), 1):
            yield f"has {field.name} = {_shown(getattr(value, field.name))}: give a positive int"


def _function(value: object) -> Iterable[str]:
    if not callable(value):
        yield f"is {_shown(value)}: write a method"


_KINDS: Mapping[str, Callable[[object], Iterable[str]]] = {
    "name": _text,
    "types": _types,
    "classifiers": _classifiers,
    "goal_predicates": _predicates,
    "contact_predicates": _predicates,
    "oracle_skills": _skills,
    "given_skills": _given,
    "action_low": _bound,
    "action_high": _bound,
    "horizon": _positive,
    "rollout_limit": _positive,
    "budget": _budget,
    "simulate": _function,
    "sample_task": _function,
    "draw": _function,
}

# ------------------------------------------------------------------------- do they fit each other?


def symbols(subject: object, broken: Collection[str]) -> Remarks:
    """Compare what uses types and predicates with those that the environment has."""
    environment = cast(Environment, subject)
    for predicate in environment.classifiers:
        for kind in predicate.types:
            if not _known(kind, environment.types):
                yield fault(
                    f"classifiers: {predicate.signature} is over {kind.name}, which is not in types: add it"
                )
    for name in ("goal_predicates", "contact_predicates"):
        if name not in broken:
            for predicate in sorted(getattr(environment, name), key=lambda p: str(p.name)):
                if predicate not in environment.classifiers:
                    yield fault(f"{name} has {predicate.signature}, which has no classifier: add one")
    if "given_skills" not in broken:
        for given in environment.given_skills:
            for kind in given.types:
                if not _known(kind, environment.types):
                    yield fault(
                        f"given skill {given.name} is over {kind.name}, which is not in types: add it"
                    )
    if "oracle_skills" not in broken:
        for skill in environment.oracle_skills:
            yield from _operator(environment, skill)
            if "given_skills" not in broken and isinstance(skill.policy, GivenPolicy):
                given = skill.policy.given
                if given not in environment.given_skills:
                    yield fault(
                        f"oracle skill {skill.operator.name} uses given skill {given.name}, "
                        "which is not in given_skills: add it"
                    )
    return f"{len(environment.types)} types, {len(environment.classifiers)} predicates"


def _operator(environment: Environment, skill: Skill) -> Remarks:
    operator = skill.operator
    for variable in operator.parameters:
        if not _known(variable.type, environment.types):
            yield fault(f"operator {operator.name}: the type of {variable} is not in types: add it")
    parts = (operator.preconditions, operator.negative_preconditions)
    effects = (operator.add_effects, operator.delete_effects)
    terms = {term for part in (*parts, *effects) for atom in part for term in atom.terms}
    for predicate in sorted({a.predicate for part in (*parts, *effects) for a in part}, key=lambda p: p.name):
        if predicate not in environment.classifiers:
            yield fault(
                f"operator {operator.name} uses {predicate.signature}, which has no classifier: add one"
            )
    for term in sorted(terms, key=str):
        if isinstance(term, Object):
            yield fault(
                f"operator {operator.name} names the object {term.name}: make it a parameter, tasks differ"
            )
        elif term not in operator.parameters:
            yield fault(
                f"operator {operator.name} uses {term.name}, which is not among its parameters: add it"
            )
    return ""


def _known(kind: Type, types: Iterable[Type]) -> bool:
    """Say whether some type of the environment is ``kind`` or a kind of it."""
    return kind == OBJECT or any(own.is_a(kind) for own in types)


def names(subject: object) -> Remarks:
    """Ask whether PDDL can hold all names and tell them apart."""
    environment = cast(Environment, subject)
    try:
        model_names(domain_of(environment, (skill.operator for skill in environment.oracle_skills)))
    except InputError as error:
        yield fault(str(error))
    return "PDDL can hold them and tell them apart"
