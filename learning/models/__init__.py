"""Models: learned, saved, loaded and used.

Read ``learn``, the method from demonstrations to skills, with its ``settings``; its networks are trained by
``jobs``. A model folder is described in ``files``, written by ``save`` and read by ``load``, which needs
``binding`` (operators out of text) and ``own`` (skills of the user's own); ``origin`` says where one is from.
``solver`` solves tasks with what was learned.
"""
