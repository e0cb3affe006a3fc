"""The words of PDDL: those that we read, and those that we refuse by name."""

import re

NAME = re.compile(r"[a-z][a-z0-9_-]*\Z")  # in lower case
REQUIREMENTS = frozenset(
    """:strips :typing :negative-preconditions :constants :equality :adl :disjunctive-preconditions
    :existential-preconditions :universal-preconditions :quantified-preconditions :conditional-effects
    :action-costs :fluents :numeric-fluents :object-fluents :goal-utilities :derived-predicates
    :durative-actions :timed-initial-literals :preferences :constraints""".split()
)
DOMAIN_SECTIONS = (":requirements", ":types", ":constants", ":predicates", ":action")
PROBLEM_SECTIONS = (":domain", ":requirements", ":objects", ":init", ":goal")
ACTION_KEYS = (":parameters", ":precondition", ":effect")
UNSUPPORTED_SECTIONS = frozenset(
    """:functions :constraints :durative-action :derived :metric :axiom :length :process :event :timeless
    :situation :safety""".split()
)
UNSUPPORTED_FORMULAS = frozenset(
    """or imply forall exists when = increase decrease assign scale-up scale-down preference oneof
    < > <= >=""".split()
)
NO_PREDICATES = UNSUPPORTED_FORMULAS | {"and", "not"}  # words that begin a formula
