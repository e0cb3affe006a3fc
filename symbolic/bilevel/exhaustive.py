"""The paper's strategy: exhaust one abstract plan by backtracking, then the next."""

import numpy as np

from bpns.symbolic.bilevel.refinement import Refiner
from bpns.symbolic.bilevel.strategy import Refined, TaskSearch


def exhaustive(search: TaskSearch) -> Refined | None:
    """Refine one abstract plan after the other, in the planner's order.

    Source: Silver et al. 2022, section 4; spec, algorithm.md section 8.
    """
    budget, refining = search.budget, search.refining
    rng = np.random.default_rng(search.seed)
    plans = search.planner.plans(search.problem, rng, search.limit, search.record)
    while search.tried < budget.abstract_plans and not search.over:
        abstract = next(plans, None)
        search.watch.charge("search")
        if abstract is None:
            break
        search.tried += 1
        refiner = Refiner(
            search.environment,
            search.tried,
            search.ground_skills(abstract),
            abstract.atoms,
            budget.samples_per_step,
            min(budget.samples, refining.samples + budget.samples_per_plan),
            search.limit,
            np.random.default_rng(search.seed),
            refining,
        )
        steps = next(refiner.refine(search.task.init), None)
        search.watch.charge("refinement")
        if steps is not None:
            return abstract, steps
    return None
