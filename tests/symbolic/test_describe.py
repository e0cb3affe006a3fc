from bpns.symbolic.compare.description import operator_markdown, operators_json
from bpns.symbolic.pddl.read import parse_domain
from tests.symbolic._texts import DOMAIN

PICK, FILL = parse_domain(DOMAIN).operators


def test_the_papers_notation() -> None:
    assert str(PICK) == (
        "pick:\n"
        "  Parameters: [?r:robot, ?x:item]\n"
        "  Preconditions: [hand-empty(?r:robot), not done()]\n"
        "  Add Effects: [holding(?r:robot, ?x:item)]\n"
        "  Delete Effects: [hand-empty(?r:robot)]"
    )


def test_markdown_is_a_heading_and_a_table() -> None:
    assert operator_markdown(PICK) == (
        "### pick\n\n"
        "| parameters | `?r - robot`, `?x - item` |\n"
        "|---|---|\n"
        "| preconditions | `hand-empty(?r)`, `not done()` |\n"
        "| add effects | `holding(?r, ?x)` |\n"
        "| delete effects | `hand-empty(?r)` |"
    )
    assert operator_markdown(FILL).endswith(
        "| add effects | `done()`, `filled(?c)` |\n| delete effects | none |"
    )


def test_json_has_every_part() -> None:
    assert operators_json([PICK]) == [
        {
            "name": "pick",
            "parameters": [["?r", "robot"], ["?x", "item"]],
            "preconditions": [["hand-empty", "?r"]],
            "negative_preconditions": [["done"]],
            "add_effects": [["holding", "?r", "?x"]],
            "delete_effects": [["hand-empty", "?r"]],
        }
    ]
