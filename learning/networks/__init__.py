"""Neural networks of skills: policies, samplers, and how both are trained.

Read ``policies`` and ``samplers``: the examples that segments give, and what is made of trained networks.
These are ``network``: numpy only, so that planning never imports torch. Fitting them is ``training``, with
``settings`` (how), ``rows`` (to what), ``losses`` and ``perceptron`` (the network while it changes).
"""
