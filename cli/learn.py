"""Learn skills from demonstrations."""

import gc
import os
import platform
import shlex
import sys
import time
from dataclasses import asdict, replace
from importlib.metadata import version
from pathlib import Path

import click

from bpns import __version__, envs
from bpns.cli._options import MAX_SEED, check_unused, overwrite_option, progress_bar
from bpns.learning import approaches
from bpns.learning.approaches import Learning
from bpns.learning.data.demonstrations import read_demonstrations, read_environment_name
from bpns.learning.graphs.saved import graph_entry
from bpns.learning.models.saved import check_model_output, entry_of, write_model
from bpns.symbolic.compare.description import operator_text
from bpns.symbolic.pddl.write import model_names
from bpns.symbolic.skills.environment import domain_of


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
    preset: str,
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
    learn = chosen.learn
    if learn is None:
        raise click.UsageError(f"'{approach}' learns nothing: {chosen.summary}")
    if not chosen.skills:
        check_unused(["min_share"], f"'{approach}' learns no operators")
    load = environment or read_environment_name(demonstrations)
    world = envs.load(load)
    data = read_demonstrations(demonstrations, world)
    seed = data.seed if seed is None else seed
    check_model_output(out, overwrite)
    model_names(domain_of(world, ()))  # before minutes of training: will this be fit for PDDL?
    from bpns.learning.graphs.training import GraphTraining, device_of  # torch: slow to import
    from bpns.learning.models.learn import SkillConfig

    device = str(device_of(device))
    gc.freeze()  # what was read stays: looking through it again and again takes seconds
    config = SkillConfig.paper() if preset == "paper" else SkillConfig()
    if min_share is not None:
        config = replace(config, min_share=min_share)
    graphs = GraphTraining() if preset == "paper" else GraphTraining.fast()
    start, start_cpu = time.perf_counter(), _cpu_seconds()
    with progress_bar("training") as progress:
        learned = learn(world, data, Learning(config, graphs, seed, workers, device, progress))
    seconds, cpu = time.perf_counter() - start, _cpu_seconds() - start_cpu
    count = len(data.demonstrations)
    header = (
        f"Skills of environment {world.name}, learned by bpns {__version__} from {count} demonstrations\n"
        f"(demonstrations of seed {data.seed}, learning with seed {seed}). You may edit this file: keep the\n"
        "operators' names and the types of their parameters."
    )
    run = {
        **_program(),
        "approach": approach.replace("-", "_"),
        "preset": preset,
        "settings": asdict(config),
        "graphs": {**asdict(graphs), "device": device},
        "seed": seed,
        "demonstrations": {"seed": data.seed, "asked": data.asked, "given": count},
        "seconds": round(seconds, 3),
        "cpu_seconds": round(cpu, 3),
    }
    skills = [
        (one.skill, entry_of(one.skill, one.segments, one.demonstrations, one.fits)) for one in learned.skills
    ]
    graph = None if learned.graph is None else (learned.graph, graph_entry(learned.graph, learned.fit))
    write_model(out, world, load, seed, skills, run, header, approach.replace("-", "_"), graph)
    for one in learned.skills:
        support = f"(from {one.demonstrations} demonstrations, {one.segments} segments)"
        click.echo(f"{operator_text(one.skill.operator)}\n  {support}")
        operator = one.skill.operator
        if not operator.preconditions and (operator.add_effects or operator.delete_effects):
            click.echo("  no preconditions: do the predicates name every object that matters?")
        click.echo()
    if learned.graph is not None:
        loss, epochs = learned.fit
        kind = "chooses among them" if learned.graph.skills else "gives the actions"
        click.echo(f"a graph network {kind} (loss on held-out examples {loss:.4g}, {epochs} epochs)")
    click.echo(f"learned {len(learned.skills)} skills in {seconds:.1f} s: {out}")


def _program() -> dict[str, str]:
    """Return the command and the versions that made a model."""
    packages = ("numpy", "torch", "safetensors", "h5py")
    return {
        "command": shlex.join(["bpns", *sys.argv[1:]]),
        "bpns": __version__,
        "python": platform.python_version(),
        **{package: version(package) for package in packages},
    }


def _cpu_seconds() -> float:
    """Return the processor time of this process and of its workers that have ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system
