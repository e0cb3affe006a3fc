"""Skills and the environments that they run in: what planners and learners see of a world."""
