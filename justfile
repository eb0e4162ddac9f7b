# Short names for what is run often; every recipe is a plain command that also works by hand.

bin := ".venv/bin"

# What there is
default:
    @just --list

# A virtual environment with everything in it
setup:
    python3.11 -m venv .venv
    {{bin}}/pip install -e '.[all,dev]'

# Style and common mistakes
lint:
    {{bin}}/ruff check

# Types
types:
    {{bin}}/mypy

# Imports that point the wrong way
layers:
    {{bin}}/lint-imports

# Tests; arguments go to pytest
test *args:
    {{bin}}/pytest {{args}}

# Thousands of random inputs, hundreds of kills: minutes long, and not part of the plain suite
slow *args:
    {{bin}}/pytest -m slow {{args}}

# Everything that has to pass before a commit is shared
check: lint types layers test

# What CI does, on the commit at hand
ci:
    bash .ci/run

# How long the command line takes to start, and what a row of a trace costs
bench:
    {{bin}}/python benchmarks/cli_start.py
    {{bin}}/python benchmarks/trace_overhead.py

# The paper's hardest map in physics
hard:
    {{bin}}/colonysim run scenarios/hard.yaml --backend bullet
