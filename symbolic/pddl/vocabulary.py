"""The words of PDDL: those that we read, and those that we refuse by name, with what to do about them."""

import re

NAME = re.compile(r"[a-z][a-z0-9_-]*\Z")  # in lower case
TITLE = re.compile(r"[a-z0-9_][a-z0-9_.-]*\Z")  # people call problems 5-4.1; it means nothing
NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)\Z")
REQUIREMENTS = frozenset(
    """:strips :typing :negative-preconditions :constants :equality :adl :disjunctive-preconditions
    :existential-preconditions :universal-preconditions :quantified-preconditions :conditional-effects
    :action-costs :fluents :numeric-fluents :object-fluents :goal-utilities :derived-predicates
    :durative-actions :duration-inequalities :continuous-effects :timed-initial-literals :time :preferences
    :constraints :domain-axioms :subgoal-through-axioms :action-expansions :foreach-expansions
    :dag-expansions :safety-constraints :expression-evaluation :fact-expansions :ucpop :non-deterministic
    :probabilistic-effects :rewards :mdp :hierarchy :method-preconditions :multi-agent
    :unfactored-privacy :factored-privacy""".split()
)
UNSUPPORTED_REQUIREMENTS = {  # those that change what the rest of the file means
    ":open-world": "what is not listed as true must be false here",
    ":true-negation": "what is not listed as true must be false here",
    ":partial-observability": "everything must be known here",
    ":contingent": "everything must be known here",
}
DOMAIN_SECTIONS = (":requirements", ":types", ":constants", ":predicates", ":action")
PROBLEM_SECTIONS = (":domain", ":requirements", ":objects", ":init", ":goal")
ACTION_KEYS = (":parameters", ":precondition", ":effect")
UNSUPPORTED_ACTION_KEYS = {
    ":vars": "variables beside the parameters: make them parameters",
    ":expansion": "hierarchies of tasks: only actions are read",
    ":only-in-expansions": "hierarchies of tasks: only actions are read",
    ":duration": "time: leave it out, or use a temporal planner",
    ":condition": "time: leave it out, or use a temporal planner",
    ":observe": "observations: everything must be known here",
    ":agent": "several agents: make the agent a parameter",
    ":cost": "numbers and costs: leave them out, every step costs one",
}
_NUMBERS = "numbers and costs: leave them out, every step costs one"
_TIME = "time: leave it out, or use a temporal planner"
_AXIOM = "derived predicates: let the actions change the predicate"
_CONSTRAINT = "constraints on the way to the goal: leave them out"
UNSUPPORTED_SECTIONS = {
    ":functions": _NUMBERS,
    ":metric": _NUMBERS,
    ":durative-action": _TIME,
    ":process": _TIME,
    ":event": _TIME,
    ":derived": _AXIOM,
    ":axiom": _AXIOM,
    ":constraints": _CONSTRAINT,
    ":safety": _CONSTRAINT,
    ":timeless": "atoms that always hold: list them in the problems' :init",
    ":domain-variables": "variables of a domain: use objects",
    ":situation": "a named initial state: list its atoms in :init",
    ":task": "hierarchies of tasks: only actions are read",
    ":method": "hierarchies of tasks: only actions are read",
    ":htn": "hierarchies of tasks: only actions are read",
    ":observe": "observations: everything must be known here",
}
UNSUPPORTED_FORMULAS = {
    "or": "a disjunction: write one action for each case",
    "imply": "an implication: write one action for each case",
    "forall": "a quantifier: write the atoms out",
    "exists": "a quantifier: make its variables parameters of the action",
    "when": "a conditional effect: write one action for each case",
    "increase": _NUMBERS,
    "decrease": _NUMBERS,
    "assign": _NUMBERS,
    "scale-up": _NUMBERS,
    "scale-down": _NUMBERS,
    "<": _NUMBERS,
    ">": _NUMBERS,
    "<=": _NUMBERS,
    ">=": _NUMBERS,
    "preference": "a soft goal: make it a goal, or leave it out",
    "oneof": "chance: an effect must be certain",
    "probabilistic": "chance: an effect must be certain",
}
NO_PREDICATES = frozenset(UNSUPPORTED_FORMULAS) | {"and", "not", "="}  # words that begin a formula
