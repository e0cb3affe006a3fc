"""Learn skills from demonstrations."""

import gc
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import click

import bpns
from bpns.cli._options import MAX_SEED, check_unused, overwrite_option, progress_bar
from bpns.learning import approaches
from bpns.learning.models.files import check_model_output


@click.command()
@click.argument("demonstrations", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Model folder.")
@click.option("--environment", help="Name or MODULE:ATTRIBUTE (default: the one named in the file).")
@click.option("--seed", type=click.IntRange(0, MAX_SEED), help="(default: the demonstrations' own)")
@click.option(
    "--preset",
    type=click.Choice(["default", "paper"]),
    default="default",
    show_default=True,
    help="Context objects and short training, or the paper's operators and training, which takes minutes.",
)
@click.option("--approach", default="bpns", show_default=True, help="See 'bpns approaches'.")
@click.option(
    "--min-share",
    type=click.FloatRange(0, 1),
    help="Share of all segments below which an operator is dropped; 0: no filter.  [default: 0.01]",
)
@click.option(
    "--device", default="auto", show_default=True, help="For graph networks: cpu, cuda; auto: a GPU if any."
)
@click.option("--workers", type=click.IntRange(1), default=1, show_default=True, help="Processes.")
@overwrite_option
def command(
    demonstrations: Path,
    out: Path,
    environment: str | None,
    seed: int | None,
    preset: Literal["default", "paper"],
    approach: str,
    min_share: float | None,
    device: str,
    workers: int,
    overwrite: bool,
) -> None:
    """Learn operators, policies and samplers from DEMONSTRATIONS, and save them as a model folder.

    With --approach: whatever that approach learns in their place.
    """
    chosen = approaches.load(approach)
    if chosen.learn is None:
        raise click.UsageError(f"'{approach}' learns nothing: {chosen.summary}")
    if not chosen.skills:
        check_unused(["min_share"], f"'{approach}' learns no operators")
    world = bpns.load_environment(environment) if environment else bpns.world_of(demonstrations)
    data = bpns.read_demonstrations(demonstrations, world)
    check_model_output(out, overwrite)
    command = shlex.join(["bpns", *sys.argv[1:]])
    with progress_bar("training") as progress, _frozen():
        model = bpns.learn(world, data, approach, seed, preset, min_share, device, workers, progress, command)
    model.save(out, overwrite=True)
    for name, operator in model.operators.items():
        entry = model.entries[name]
        support = f"(from {entry.demonstrations} demonstrations, {entry.segments} segments)"
        click.echo(f"{operator}\n  {support}")
        if not operator.preconditions and (operator.add_effects or operator.delete_effects):
            click.echo("  no preconditions: do the predicates name every object that matters?")
        click.echo()
    if model.graph is not None:
        loss, epochs = model.training
        kind = "chooses among them" if model.graph.skills else "gives the actions"
        click.echo(f"a graph network {kind} (loss on held-out examples {loss:.4g}, {epochs} epochs)")
    click.echo(f"learned {len(model.skills)} skills in {model.run['seconds']:.1f} s: {out}")


@contextmanager
def _frozen() -> Iterator[None]:
    """Keep what was read out of garbage collections: looking through it again and again takes seconds."""
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
