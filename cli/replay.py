"""Compare a recording with our simulator."""

import json
import sys
from pathlib import Path

import click

import bpns
from bpns.cli._options import json_option


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--environment", help="Name or MODULE:ATTRIBUTE (default: the one named in the file).")
@json_option
def command(file: Path, environment: str | None, as_json: bool) -> None:
    """Check the tasks, demonstrations and transitions in FILE against our simulator.

    Exits with 1 where anything differs.
    """
    result = bpns.replay(file, environment)
    total = result.different.total()
    if as_json:
        counts = {
            kind: {"compared": number, "different": result.different[kind]}
            for kind, number in result.compared.items()
        }
        click.echo(json.dumps({"different": total, "kinds": counts, "first": result.examples[:20]}, indent=2))
    else:
        for kind, number in result.compared.items():
            click.echo(f"{kind:22}{number:7} compared {result.different[kind]:7} different")
        for example in result.examples[:10]:
            click.echo(f"  {example}")
        click.echo(f"{total} differences")
    sys.exit(1 if total else 0)
