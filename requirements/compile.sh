#!/bin/sh
# Compile the pins from pyproject.toml: `make pins`, or with uv on the path: sh requirements/compile.sh
# `sh requirements/compile.sh --keep` keeps the versions that stand there, and writes what is missing.
# The files carry a hash of every file of a package and no address, hold for every Python from 3.11 on, and agree with
# each other.
set -eu
cd "$(dirname "$0")/.."
upgrade=--upgrade
if [ "${1:-}" = --keep ]; then upgrade=; fi

compile() {
    uv pip compile "$@" $upgrade --generate-hashes --universal --python-version 3.11 \
        --fork-strategy fewest --no-header --no-annotate --no-emit-index-url --no-emit-find-links --quiet
}

extras="--extra plot --extra report --extra io --extra cluster --extra web"
compile pyproject.toml $extras --output-file requirements/run.txt
compile pyproject.toml $extras --group dev --constraint requirements/run.txt --output-file requirements/dev.txt
# What checks the page's JavaScript: node with npm, a linter.
compile --group page --output-file requirements/page.txt
# What installs the rest: pip itself, and what builds percuss (build-system.requires, and editables for 'install -e').
printf '%s\n' pip setuptools 'hatchling>=1.27' editables |
    compile - --constraint requirements/dev.txt --allow-unsafe --output-file requirements/build.txt

# TypeScript and prettier: the versions of requirements/package.json, with the hash of each and no address.
if command -v npm >/dev/null; then
    npm install --package-lock-only --omit-lockfile-registry-resolved --no-fund --silent --prefix requirements
    python3 -c 'import json, sys
lock = json.load(open(sys.argv[1]))
for package in lock["packages"].values():
    package.pop("funding", None)
print(json.dumps(lock, indent=2), file=open(sys.argv[1], "w"))' requirements/package-lock.json
else
    echo "npm is not there (make lint brings it: .venv/bin/npm): requirements/package-lock.json stays as it is" >&2
fi
