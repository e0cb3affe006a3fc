"""PDDL texts, and ways to read, change and mark them."""

from pathlib import Path

from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.read import parse_domain, parse_problem, read_domain, read_problem
from bpns.symbolic.pddl.write import model_names, write_domain, write_problem

DOMAIN = """\
(define (domain kitchen)
  (:requirements :strips :typing :negative-preconditions)
  (:types robot item - object cup jug - item)
  (:constants robby - robot)
  (:predicates (hand-empty ?r - robot) (holding ?r - robot ?x - item) (filled ?c - cup) (done))
  ; a comment (with a parenthesis
  (:action pick :parameters (?r - robot ?x - item)
    :precondition (and (hand-empty ?r) (not (done)))
    :effect (and (holding ?r ?x) (not (hand-empty ?r))))
  (:action fill :parameters (?c - cup)
    :precondition (holding robby ?c)
    :effect (and (filled ?c) (done))))
"""
PROBLEM = """\
(define (problem breakfast) (:domain kitchen)
  (:objects c1 c2 - cup j1 - jug)
  (:init (hand-empty robby))
  (:goal (and (filled c1) (not (filled c2)))))
"""


def read_back(domain: Domain, problem: Problem | None = None) -> tuple[Domain, Problem | None]:
    names = model_names(domain, problem)
    text = write_domain(domain)
    if problem is None:
        return parse_domain(text, names=names), None
    written = write_problem(problem, domain)
    return parse_domain(text, names=names), parse_problem(written, domain, names=names)


def read_case(data: Path, number: str) -> tuple[Domain, Problem]:
    (folder,) = (data / "pddl-cases").glob(f"{number}-*")
    domain = read_domain(folder / "domain.pddl")
    return domain, read_problem(folder / "problem.pddl", domain)


def replaced(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1
    return text.replace(old, new)


def marked(text: str, old: str, new: str) -> tuple[str, str]:
    """Put ``new`` for ``old``; return the text without the mark ``@``, and its place as line:column."""
    before, after = replaced(text, old, new).split("@")
    return before + after, f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"
