"""Trains a policy for a colony's agents; nothing that runs one needs what is here.

`trainer` is the whole training: first `imitation` of the rule, then `ppo` on what `rollout` gathers, both on the places
of `places`. `network` is the network in PyTorch, and how it becomes the plain layers that the policy `learned` runs.
"""
