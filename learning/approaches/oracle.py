"""The environment's own skills, written by hand. Source: spec, baselines.md section 10."""

from bpns.learning.approaches import Approach

APPROACH = Approach(
    "Oracle", "plans with the environment's own skills: --oracle ENVIRONMENT in place of MODEL"
)
