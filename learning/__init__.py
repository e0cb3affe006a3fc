"""From demonstrations to skills; the only layer that may use torch.

The rooms, in the order in which learning goes through them: ``data`` (demonstrations, cut into segments),
``operators`` (of segments that are alike), ``networks`` (policies and samplers, and how they are trained) and
``models`` (all of this together, saved, loaded and used). Beside them: ``graphs`` (networks that act without
a planner), ``approaches`` (what can be learned, by name) and ``experiments`` (how well it does).
"""
