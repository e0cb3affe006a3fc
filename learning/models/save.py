"""Writing a model folder."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from safetensors.numpy import save

from bpns.learning.graphs.reactive import GraphModel
from bpns.learning.graphs.saved import GraphEntry, graph_tensors
from bpns.learning.models.files import FORMAT, GivenEntry, ModelFile, SkillEntry, check_model_output
from bpns.learning.networks.network import Array32
from bpns.learning.networks.policies import Changing, LearnedPolicy, PassThrough
from bpns.learning.networks.samplers import LearnedSampler
from bpns.symbolic.files import replacing_folder, write_json
from bpns.symbolic.pddl.write import write_domain
from bpns.symbolic.skills.environment import Environment, domain_of
from bpns.symbolic.skills.skill import GivenPolicy, Skill


def write_model(
    folder: Path,
    environment: Environment,
    load: str,
    seed: int,
    skills: Sequence[tuple[Skill, SkillEntry]],
    run: Mapping[str, Any],
    header: str,
    approach: str = "bpns",
    graph: tuple[GraphModel, GraphEntry] | None = None,
    modules: Path | None = None,
) -> None:
    """Write a model folder in one piece, in the place of one that may be there.

    ``load`` is how to ask for the environment: its name, or ``module:attribute``. ``run`` goes to run.json;
    the other files hold nothing that changes from run to run. ``modules`` is the folder of the user's
    modules, if the model needs any. Raises InputError as ``check_model_output``.
    """
    check_model_output(folder, overwrite=True)
    with replacing_folder(folder) as temporary:
        domain = domain_of(environment, (skill.operator for skill, _ in skills))
        comments = {skill.operator.name: _comment(entry) for skill, entry in skills}
        (temporary / "domain.pddl").write_text(write_domain(domain, header, comments), encoding="utf-8")
        tensors = {
            n: t
            for skill, entry in skills
            if not (entry.given or entry.own)
            for n, t in _tensors(skill).items()
        }
        tensors |= graph_tensors(graph[0]) if graph else {}
        (temporary / "skills.safetensors").write_bytes(save(tensors))
        entries = {skill.operator.name: entry for skill, entry in skills}
        file = ModelFile(
            format=FORMAT,
            approach=approach,
            environment=environment.name,
            load=load,
            seed=seed,
            skills=entries,
            graph=graph[1] if graph else None,
            folder=os.path.relpath(modules, folder) if modules else None,
        )
        write_json(temporary / "skills.json", file.model_dump(mode="json"))
        write_json(temporary / "run.json", {**run, "folder": str(modules)} if modules else run)


def _comment(entry: SkillEntry) -> str:
    """Return what domain.pddl says above an operator."""
    if entry.own:
        return f"{entry.own}, not learned"
    return f"learned from {entry.demonstrations} demonstrations, {entry.segments} segments"


def entry_of(
    skill: Skill, segments: int, demonstrations: int, training: Mapping[str, tuple[float, int]]
) -> SkillEntry:
    """Describe a learned skill for skills.json."""
    parameters = skill.operator.parameters
    changing: Changing = ()
    given = None
    if isinstance(skill.policy, GivenPolicy):
        arguments = [parameters[place].name for place in skill.policy.places]
        given = GivenEntry(skill=skill.policy.given.name, arguments=arguments)
    elif isinstance(skill.policy, LearnedPolicy):
        changing = skill.policy.changing
    return SkillEntry(
        parameters=[(v.name, v.type.name) for v in parameters],
        subgoal=[(parameters[p].name, parameters[p].type.features[f]) for p, f in changing],
        max_actions=skill.max_actions,
        segments=segments,
        demonstrations=demonstrations,
        training=dict(training),
        given=given,
        pass_through=isinstance(skill.policy, PassThrough),
    )


def entry_of_own(skill: Skill, name: str) -> SkillEntry:
    """Describe a user's own skill, which is ``name``, MODULE:ATTRIBUTE."""
    return SkillEntry(
        parameters=[(v.name, v.type.name) for v in skill.operator.parameters],
        subgoal=[],
        max_actions=skill.max_actions,
        segments=0,
        demonstrations=0,
        training={},
        own=name,
    )


def _tensors(skill: Skill) -> dict[str, Array32]:
    """Return a skill's arrays by name: OPERATOR.PART.NAME."""
    policy, sampler = skill.policy, skill.sampler
    assert isinstance(sampler, LearnedSampler)
    found: dict[str, Array32] = {}
    parts = {"discriminator": sampler.discriminator}
    outputs = {"generator": sampler.subgoals}
    if isinstance(policy, LearnedPolicy):
        parts["policy"], outputs["policy"] = policy.network, policy.actions
    parts |= {f"generator-{number}": network for number, network in enumerate(sampler.generators)}
    for part, network in parts.items():
        if network is not None:
            found[f"{part}.inputs.shift"] = network.inputs.shift
            found[f"{part}.inputs.scale"] = network.inputs.scale
            for number, (weights, biases) in enumerate(network.layers):
                found[f"{part}.{number}.weights"] = weights
                found[f"{part}.{number}.biases"] = biases
            if network.linear is not None:
                found[f"{part}.linear"] = network.linear
    for part, scaling in outputs.items():
        found[f"{part}.outputs.shift"] = scaling.shift
        found[f"{part}.outputs.scale"] = scaling.scale
    return {f"{skill.operator.name}.{n}": np.ascontiguousarray(t, np.float32) for n, t in found.items()}
