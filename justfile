# Short names for what is run often; every recipe is a plain command that also works by hand.

bin := ".venv/bin"

# What there is
default:
    @just --list

# A virtual environment with everything in it
setup:
    python3 -m venv .venv
    {{bin}}/pip install -c constraints.txt -e '.[all,dev]'

# Writes constraints.txt, from which tests and CI install, with today's newest versions; then run the tests
lock:
    {{bin}}/pip install --quiet uv
    {{bin}}/uv pip compile pyproject.toml --all-extras --universal --python-version 3.11 --upgrade --quiet \
        --no-annotate --custom-compile-command "just lock" --output-file constraints.txt

# Tests in a new environment with the newest versions of everything; `just newest torch==2.13.0` says which PyTorch
newest torch="torch":
    rm -rf .venv-newest
    python3 -m venv .venv-newest
    .venv-newest/bin/pip install '{{torch}}'
    .venv-newest/bin/pip install -e '.[all,dev]'
    .venv-newest/bin/ruff check
    .venv-newest/bin/mypy
    .venv-newest/bin/lint-imports
    .venv-newest/bin/pytest -n auto

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
    {{bin}}/pytest -n auto {{args}}

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

# The documentation site, in site/; `just docs --serve` shows it and follows changes
docs *args:
    {{bin}}/python docs/build.py {{args}}

# The pictures and replay pages of the gallery, anew
gallery *args:
    {{bin}}/python docs/gallery/make.py {{args}}

# Executes docs/notebooks and stores their outputs
notebooks *names:
    {{bin}}/python tests/notebooks/executing.py {{names}}

# The paper's hardest map in physics
hard:
    {{bin}}/colonysim run scenarios/hard.yaml --backend physics
