"""A saved model is a folder: domain.pddl, skills.safetensors, skills.json, run.json.

``domain.pddl`` is the truth for the symbolic part: a person may edit it and plan again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError
from safetensors import SafetensorError
from safetensors.numpy import load_file, save

from bpns.learning.graphs.reactive import GraphModel
from bpns.learning.graphs.saved import GraphEntry, graph_tensors, read_graph
from bpns.learning.networks.network import Array32, Network, Scaling
from bpns.learning.networks.policies import Changing, LearnedPolicy, PassThrough
from bpns.learning.networks.samplers import LearnedSampler
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import check_output, read_json, replacing_folder, write_json
from bpns.symbolic.pddl.read import read_domain
from bpns.symbolic.pddl.write import model_names, write_domain
from bpns.symbolic.skills.environment import Environment, domain_of
from bpns.symbolic.skills.skill import GivenPolicy, Policy, Skill, never
from bpns.symbolic.structs import Domain, LiftedAtom, Object, Operator, Variable

FORMAT = "bpns model 2"
FILES = ("domain.pddl", "skills.json", "skills.safetensors", "run.json")


class GivenEntry(BaseModel):
    """Which of the environment's given skills a skill uses, and the parameters that it gets."""

    model_config = ConfigDict(extra="forbid")
    skill: str
    arguments: list[str]


class SkillEntry(BaseModel):
    """What skills.json says of one skill."""

    model_config = ConfigDict(extra="forbid")
    parameters: list[tuple[str, str]]  # name, type
    subgoal: list[tuple[str, str]]  # parameter, feature: what a subgoal changes
    max_actions: int | None  # in one roll-out; null: the environment's limit alone
    segments: int  # that it was learned from
    demonstrations: int  # that these segments are of
    training: dict[str, tuple[float, int]]  # network -> best loss, iterations
    given: GivenEntry | None = None  # instead of learned networks
    pass_through: bool = False  # the sampler proposes actions, and the policy hands them on


class ModelFile(BaseModel):
    """skills.json."""

    model_config = ConfigDict(extra="forbid")
    format: str
    approach: str
    environment: str
    load: str  # how to ask for the environment: its name or MODULE:ATTRIBUTE
    seed: int
    skills: dict[str, SkillEntry]
    graph: GraphEntry | None = None  # chooses skills, or actions


@dataclass(frozen=True, slots=True, eq=False)
class SavedModel:
    """A model as loaded."""

    approach: str
    environment: Environment
    seed: int
    domain: Domain
    skills: Mapping[str, Skill]
    entries: Mapping[str, SkillEntry]
    graph: GraphModel | None = None


# --------------------------------------------------------------------------------------------- save


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
) -> None:
    """Write a model folder in one piece, in the place of one that may be there.

    ``load`` is how to ask for the environment: its name, or ``module:attribute``. ``run`` goes to run.json as
    it is; the other files hold nothing that changes from run to run. Raises InputError as
    ``check_model_output``.
    """
    check_model_output(folder, overwrite=True)
    with replacing_folder(folder) as temporary:
        domain = domain_of(environment, (skill.operator for skill, _ in skills))
        comments = {
            skill.operator.name: f"learned from {e.demonstrations} demonstrations, {e.segments} segments"
            for skill, e in skills
        }
        (temporary / "domain.pddl").write_text(write_domain(domain, header, comments), encoding="utf-8")
        tensors = {n: t for skill, entry in skills if not entry.given for n, t in _tensors(skill).items()}
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
        )
        write_json(temporary / "skills.json", file.model_dump(mode="json"))
        write_json(temporary / "run.json", run)


def check_model_output(folder: Path, overwrite: bool) -> None:
    """Raise InputError where a model cannot be written; a folder with anything but a model stays as it is."""
    check_output(folder, overwrite, folder=True)
    if folder.exists():
        found = sorted(p.name for p in folder.iterdir()) if folder.is_dir() else ["a file"]
        others = [name for name in found if name not in FILES]
        if others:
            raise InputError(
                f"{folder} holds more than a model ({', '.join(others[:3])}): "
                "move that away, or give another --out"
            )


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


# --------------------------------------------------------------------------------------------- load


def read_model_file(folder: Path) -> ModelFile:
    """Return skills.json, checked; raise InputError where the folder is no model or incomplete."""
    if not folder.is_dir():
        raise InputError(f"no model folder {folder}: make one with 'bpns learn'")
    for name in FILES[:3]:
        if not (folder / name).is_file():
            raise InputError(f"{folder} is no complete model: {name} is missing: learn it again")
    try:
        file = ModelFile.model_validate(read_json(folder / "skills.json"))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"])) or "the whole file"
        raise InputError(
            f"{folder / 'skills.json'}: {place}: {first['msg']}: learn the model again"
        ) from error
    if file.format != FORMAT:
        raise InputError(
            f"{folder / 'skills.json'}: format '{file.format}' is not '{FORMAT}': learn it again"
        )
    return file


def read_model(folder: Path, environment: Environment) -> SavedModel:
    """Load a model; raise InputError where its files do not fit each other or the environment."""
    file = read_model_file(folder)
    if file.environment != environment.name:
        raise InputError(f"{folder} was learned in '{file.environment}', not in '{environment.name}'")
    path = folder / "domain.pddl"
    names = model_names(domain_of(environment, ())) | {name.lower(): name for name in file.skills}
    domain = read_domain(path, names)
    if domain.name != environment.name:
        raise InputError(
            f"{path}: the domain is called '{domain.name}', not '{environment.name}': rename it, "
            "or put back the file of this model"
        )
    operators = bind_operators(domain, environment, path)
    by_name = {operator.name: operator for operator in operators}
    have = ", ".join(file.skills)
    for name in by_name:
        if name not in file.skills:
            raise InputError(
                f"{path}: operator '{name}' has no weights (skills.json has: {have}): "
                "give it one of these names, or remove it"
            )
    for name in file.skills:
        if name not in by_name:
            raise InputError(
                f"{folder / 'skills.json'}: weights of '{name}' have no operator in domain.pddl: put the "
                f"operator back{'' if file.graph and name in file.graph.skills else ', or remove this entry'}"
            )
    try:
        tensors = load_file(folder / "skills.safetensors")
    except (SafetensorError, OSError) as error:
        raise InputError(
            f"{folder / 'skills.safetensors'}: broken: {error}: learn the model again"
        ) from error
    skills = {n: _skill(by_name[n], file.skills[n], tensors, environment, folder) for n in by_name}
    own_domain = domain_of(environment, operators)
    graph = None
    if file.graph is not None:
        graph = read_graph(file.graph, operators, len(environment.action_low), tensors, folder)
    return SavedModel(file.approach, environment, file.seed, own_domain, skills, file.skills, graph)


def bind_operators(domain: Domain, environment: Environment, path: Path) -> tuple[Operator, ...]:
    """Return a PDDL domain's operators over an environment's own types and predicates."""
    types = {t.name: t for t in domain_of(environment, ()).types}
    predicates = {p.name: p for p in environment.classifiers}
    for predicate in domain.predicates:
        own = predicates.get(predicate.name)
        if own is None or [t.name for t in own.types] != [t.name for t in predicate.types]:
            have = ", ".join(p.signature for p in predicates.values())
            raise InputError(
                f"{path}: predicate {predicate.signature} is none of environment '{environment.name}' "
                f"(have: {have})"
            )
    if domain.constants:
        raise InputError(f"{path}: a model's operators cannot mention constants: use parameters")

    def bind(operator: Operator) -> Operator:
        for variable in operator.parameters:
            if variable.type.name not in types:
                raise InputError(
                    f"{path}: {operator.name}: type '{variable.type.name}' is none of environment "
                    f"'{environment.name}' (have: {', '.join(types)})"
                )
        variables = {v: Variable(v.name, types[v.type.name]) for v in operator.parameters}

        def atoms(lifted: frozenset[LiftedAtom]) -> frozenset[LiftedAtom]:
            return frozenset(
                LiftedAtom(
                    predicates[a.predicate.name],
                    tuple(t if isinstance(t, Object) else variables[t] for t in a.terms),
                )
                for a in lifted
            )

        return Operator(
            operator.name,
            tuple(variables.values()),
            atoms(operator.preconditions),
            atoms(operator.add_effects),
            atoms(operator.delete_effects),
            atoms(operator.negative_preconditions),
        )

    return tuple(bind(operator) for operator in domain.operators)


def _skill(
    operator: Operator,
    entry: SkillEntry,
    tensors: Mapping[str, Array32],
    environment: Environment,
    folder: Path,
) -> Skill:
    """Put a skill together from its three files."""
    wanted = [kind for _, kind in entry.parameters]
    found = [v.type.name for v in operator.parameters]
    if wanted != found:
        raise InputError(
            f"{folder / 'domain.pddl'}: {operator.name} has parameters of types ({', '.join(found)}), "
            f"but its weights need ({', '.join(wanted)}): restore them, or learn again"
        )
    if entry.given is not None:
        return _given(operator, entry, entry.given, environment, folder)
    changing = _changing(operator, entry, folder)
    size = sum(len(v.type.features) for v in operator.parameters) + 1
    actions = len(environment.action_low)
    dimension = actions if entry.pass_through else len(changing)

    def take(name: str, *shape: int) -> Array32:
        tensor = tensors.get(f"{operator.name}.{name}")
        if tensor is None or tensor.shape != shape:
            what = "missing" if tensor is None else f"of shape {tensor.shape}, not {shape}"
            raise InputError(
                f"{folder / 'skills.safetensors'}: {operator.name}.{name} is {what}: learn the model again"
            )
        return tensor

    def scaling(name: str, columns: int) -> Scaling:
        return Scaling(take(f"{name}.shift", columns), take(f"{name}.scale", columns))

    def network(part: str, columns: int, outputs: int) -> Network:
        prefix = f"{operator.name}.{part}."
        depth = sum(n.startswith(prefix) and n.endswith(".weights") for n in tensors)
        widths = [len(tensors.get(f"{prefix}{i}.biases", ())) for i in range(depth)]
        sizes = [columns, *widths[:-1], outputs]
        layers = tuple(
            (take(f"{part}.{i}.weights", b, a), take(f"{part}.{i}.biases", b))
            for i, (a, b) in enumerate(pairwise(sizes))
        )
        linear = take(f"{part}.linear", outputs, columns) if f"{prefix}linear" in tensors else None
        return Network(scaling(f"{part}.inputs", columns), layers, linear)

    box = environment.action_low, environment.action_high
    policy: Policy = PassThrough(*box)
    if not entry.pass_through:
        network_of_policy = network("policy", size + dimension, actions)
        policy = LearnedPolicy.of(changing, network_of_policy, scaling("policy.outputs", actions), box)
    names = [name for name in entry.training if name.startswith("generator-")]
    generators = tuple(network(name, size, 2 * dimension) for name in names)
    discriminator = None
    if "discriminator" in entry.training:
        discriminator = network("discriminator", size + dimension, 1)
    sampler = LearnedSampler.of(dimension, generators, scaling("generator.outputs", dimension), discriminator)
    terminal = never if entry.pass_through else None
    return Skill(operator, policy, sampler, terminal, entry.max_actions)


def _given(
    operator: Operator, entry: SkillEntry, chosen: GivenEntry, environment: Environment, folder: Path
) -> Skill:
    """Put a skill together whose policy is given; parameters count by place, as in ``_changing``."""
    path = folder / "skills.json"
    given = next((g for g in environment.given_skills if g.name == chosen.skill), None)
    if given is None:
        have = ", ".join(g.name for g in environment.given_skills) or "none"
        raise InputError(
            f"{path}: {operator.name}: '{chosen.skill}' is no given skill of '{environment.name}' "
            f"(have: {have})"
        )
    names = [name for name, _ in entry.parameters]
    if not set(chosen.arguments) <= set(names):
        raise InputError(f"{path}: {operator.name}: arguments of {chosen.skill} are not among its parameters")
    arguments = tuple(operator.parameters[names.index(name)] for name in chosen.arguments)
    fits = len(arguments) == len(given.types)
    if not fits or not all(v.type.is_a(t) for v, t in zip(arguments, given.types, strict=True)):
        raise InputError(
            f"{path}: {operator.name}: {chosen.skill} does not take ({', '.join(chosen.arguments)})"
        )
    return Skill.of_given(operator, given, arguments)


def _changing(operator: Operator, entry: SkillEntry, folder: Path) -> Changing:
    """Return the changing features by number; parameters count by place, so that they may be renamed."""
    places = {name: place for place, (name, _) in enumerate(entry.parameters)}
    found = []
    for name, feature in entry.subgoal:
        if name not in places or feature not in operator.parameters[places[name]].type.features:
            raise InputError(f"{folder / 'skills.json'}: {operator.name}: no feature {name}.{feature}")
        place = places[name]
        found.append((place, operator.parameters[place].type.features.index(feature)))
    return tuple(found)
