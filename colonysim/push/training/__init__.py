"""Trains the push and judges it; nothing that runs a push needs what is here.

`trainer` is Algorithm 1 on the episodes of `episode`, `forest` grows the classifier, `calibration` fits the chance of a
way to the logs of `waylogs`, `evaluation` and `chains` measure success, and `env` is the push for other learners.
"""
