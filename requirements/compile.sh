#!/bin/sh
# Compile the pins from pyproject.toml: `make pins`, or with uv on the path: sh requirements/compile.sh
# The files carry no hash and no address, hold for every Python from 3.11 on, and agree with each other.
set -eu
cd "$(dirname "$0")/.."

compile() {
    uv pip compile pyproject.toml --extra plot --extra io --extra cluster --extra web "$@" --upgrade --universal --python-version 3.11 \
        --fork-strategy fewest --no-header --no-annotate --no-emit-index-url --no-emit-find-links --quiet
}

compile --output-file requirements/run.txt
compile --group dev --constraint requirements/run.txt --output-file requirements/dev.txt
