"""Write a model as PDDL: the domain and some problems."""

from pathlib import Path

import click

from bpns.cli._options import MAX_SEED, environment_option, load_subject, oracle_option, overwrite_option
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import check_output, read_text, write_text
from bpns.symbolic.pddl.rewriting.portable import portable
from bpns.symbolic.pddl.write import write_domain, write_problem
from bpns.symbolic.skills.environment import domain_of, problem_of, sample_tasks


@click.command()
@click.argument("model", type=click.Path(path_type=Path), required=False)
@oracle_option
@environment_option
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder.")
@click.option("--problems", type=click.IntRange(0), default=10, show_default=True)
@click.option(
    "--seed", type=click.IntRange(0, MAX_SEED), help="Of the evaluation tasks (default: the model's)."
)
@click.option(
    "--positive", is_flag=True, help="Compile negative conditions away, for planners that lack them."
)
@overwrite_option
def command(
    model: Path | None,
    oracle: str | None,
    environment: str | None,
    out: Path,
    problems: int,
    seed: int | None,
    positive: bool,
    overwrite: bool,
) -> None:
    """Write domain.pddl and p01.pddl, p02.pddl, ... (the first evaluation tasks) of MODEL.

    Every name is used once, over types, predicates, operators and objects, as some planners need it.
    """
    subject = load_subject(model, oracle, environment)
    world = subject.environment
    seed = subject.seed if seed is None else seed
    domain = domain_of(world, (skill.operator for skill in subject.skills.values()))
    source = f"{subject.label}: environment {subject.asked}"
    own_text = write_domain(domain, source) if model is None else read_text(model / "domain.pddl")
    texts = {"domain.pddl": own_text}
    digits = max(2, len(str(problems)))
    for index, task in enumerate(sample_tasks(world, "test", problems, seed)):
        name = f"p{index + 1:0{digits}}"
        task_of = portable(domain, problem_of(world, task, name), negation=not positive, equality=True)
        header = f"evaluation task {index} of seed {seed}, environment {subject.asked}"
        texts[f"{name}.pddl"] = write_problem(task_of.problem, task_of.domain, header)
        text = write_domain(task_of.domain, source)
        if text != write_domain(domain, source):  # the model's own text has its comments
            if texts["domain.pddl"] not in (own_text, text):
                raise InputError("these problems need different domains: export them one by one")
            texts["domain.pddl"] = text
    if (out / "skills.json").exists():
        raise InputError(
            f"{out} is a model folder, and its domain.pddl is the model's own: give another --out"
        )
    for name in texts:
        check_output(out / name, overwrite)
    for name, text in texts.items():
        write_text(out / name, text)
    click.echo(f"domain.pddl and {problems} problems: {out}")
