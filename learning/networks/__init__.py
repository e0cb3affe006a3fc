"""Neural networks of skills: policies, samplers, and how both are trained."""
