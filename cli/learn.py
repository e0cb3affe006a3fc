"""Learn skills from demonstrations."""

import platform
import sys
import time
from importlib.metadata import version
from pathlib import Path

import click

import envs
from bpns import __version__
from cli._options import overwrite_option, progress_bar
from learning.demonstrations import read_demonstrations, read_environment_name
from learning.saved import check_model_output, entry_of, write_model
from symbolic.describe import operator_text


@click.command()
@click.argument("demonstrations", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Model folder.")
@click.option("--environment", help="Name or MODULE:ATTRIBUTE (default: the one named in the file).")
@click.option("--seed", type=click.IntRange(0), help="(default: the demonstrations' own)")
@click.option("--full", is_flag=True, help="The paper's training: all iterations, no early stop; minutes.")
@click.option("--workers", type=click.IntRange(1), default=1, show_default=True, help="Processes.")
@overwrite_option
def command(
    demonstrations: Path,
    out: Path,
    environment: str | None,
    seed: int | None,
    full: bool,
    workers: int,
    overwrite: bool,
) -> None:
    """Learn operators, policies and samplers from DEMONSTRATIONS, and save them as a model folder."""
    from learning.skills import SkillConfig, learn_skills  # torch: slow to import

    world = envs.load(environment or read_environment_name(demonstrations))
    data = read_demonstrations(demonstrations, world)
    seed = data.seed if seed is None else seed
    check_model_output(out, overwrite)
    start, start_cpu = time.perf_counter(), time.process_time()
    with progress_bar("training") as progress:
        learned = learn_skills(
            world,
            data,
            SkillConfig.full() if full else SkillConfig(),
            seed,
            workers,
            progress,
        )
    seconds, cpu = time.perf_counter() - start, time.process_time() - start_cpu
    count = len(data.demonstrations)
    header = (
        f"Skills of environment {world.name}, learned by bpns {__version__} from {count} demonstrations\n"
        f"(demonstrations of seed {data.seed}, learning with seed {seed}). You may edit this file: keep the\n"
        "operators' names and the types of their parameters."
    )
    run = {
        "command": " ".join(["bpns", *sys.argv[1:]]),
        "bpns": __version__,
        "python": platform.python_version(),
        **{package: version(package) for package in ("numpy", "torch", "safetensors", "h5py")},
        "preset": "full" if full else "default",
        "seed": seed,
        "demonstrations": {"seed": data.seed, "asked": data.asked, "given": count},
        "seconds": round(seconds, 3),
        "cpu_seconds": round(cpu, 3) if workers == 1 else None,
    }
    skills = [(one.skill, entry_of(one.skill, one.segments, one.fits)) for one in learned]
    write_model(out, world, seed, skills, run, header)
    for one in learned:
        click.echo(f"{operator_text(one.skill.operator)}\n  (from {one.segments} segments)\n")
    click.echo(f"learned {len(learned)} skills in {seconds:.1f} s: {out}")
