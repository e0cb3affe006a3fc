"""Learn skills from demonstrations."""

import gc
import os
import platform
import shlex
import sys
import time
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

import click

import envs
from bpns import __version__
from cli._options import MAX_SEED, overwrite_option, progress_bar
from learning.demonstrations import read_demonstrations, read_environment_name
from learning.saved import check_model_output, entry_of, write_model
from symbolic.describe import operator_text
from symbolic.environment import domain_of
from symbolic.pddl.write import model_names


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
@click.option("--workers", type=click.IntRange(1), default=1, show_default=True, help="Processes.")
@overwrite_option
def command(
    demonstrations: Path,
    out: Path,
    environment: str | None,
    seed: int | None,
    preset: str,
    workers: int,
    overwrite: bool,
) -> None:
    """Learn operators, policies and samplers from DEMONSTRATIONS, and save them as a model folder."""
    load = environment or read_environment_name(demonstrations)
    world = envs.load(load)
    data = read_demonstrations(demonstrations, world)
    seed = data.seed if seed is None else seed
    check_model_output(out, overwrite)
    model_names(domain_of(world, ()))  # before minutes of training: will this be fit for PDDL?
    from learning.skills import SkillConfig, learn_skills  # torch: slow to import

    gc.freeze()  # what was read stays: looking through it again and again takes seconds
    config = SkillConfig.paper() if preset == "paper" else SkillConfig()
    start, start_cpu = time.perf_counter(), _cpu_seconds()
    with progress_bar("training") as progress:
        learned = learn_skills(world, data, config, seed, workers, progress)
    seconds, cpu = time.perf_counter() - start, _cpu_seconds() - start_cpu
    count = len(data.demonstrations)
    header = (
        f"Skills of environment {world.name}, learned by bpns {__version__} from {count} demonstrations\n"
        f"(demonstrations of seed {data.seed}, learning with seed {seed}). You may edit this file: keep the\n"
        "operators' names and the types of their parameters."
    )
    run = {
        **_program(),
        "preset": preset,
        "settings": asdict(config),
        "seed": seed,
        "demonstrations": {"seed": data.seed, "asked": data.asked, "given": count},
        "seconds": round(seconds, 3),
        "cpu_seconds": round(cpu, 3),
    }
    skills = [(one.skill, entry_of(one.skill, one.segments, one.demonstrations, one.fits)) for one in learned]
    write_model(out, world, load, seed, skills, run, header)
    for one in learned:
        support = f"(from {one.demonstrations} demonstrations, {one.segments} segments)"
        click.echo(f"{operator_text(one.skill.operator)}\n  {support}")
        if not one.skill.operator.preconditions:
            click.echo("  no preconditions: do the predicates name every object that matters?")
        click.echo()
    click.echo(f"learned {len(learned)} skills in {seconds:.1f} s: {out}")


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
