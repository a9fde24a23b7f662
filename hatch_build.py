"""The wheel with machine code of the kernels for a named baseline processor, where PERCUSS_MACHINE_CODE asks for it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

COMPILE = """
import sys
from percuss import Start, Stop, simulate_many
from percuss.case import load_case
from percuss.cli.app import run
from percuss.web.workers import load

asked = ("steady valve-drifter --reach", "steady drill-string", "machine valve-breaker", "blow drill-string --fatigue")
simulate_many(load_case("mini-breaker").system(), Start.rigid(-1.0), keep="everything", stop=Stop(impacts=3))
sys.exit(not load() or any(run(words.split()) for words in asked))
"""


class MachineCode(BuildHookInterface):  # type: ignore[misc]
    """Every kernel is used once in a process of its own; what numba then keeps goes into percuss/machine_code."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Needs percuss and what it runs with installed: `make wheel`."""
        if version == "editable" or not os.environ.get("PERCUSS_MACHINE_CODE"):
            return
        from percuss.compiled import BASELINE

        self.folder = tempfile.mkdtemp(prefix="percuss-machine-code-")
        target = {"NUMBA_CPU_NAME": BASELINE, "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": self.folder}
        subprocess.run(
            [sys.executable, "-c", COMPILE], env={**os.environ, **target}, check=True, stdout=subprocess.DEVNULL
        )
        for file in sorted(Path(self.folder).rglob("*.nb[ci]")):
            build_data["force_include"][str(file)] = f"percuss/machine_code/{file.name}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """What was compiled is in the wheel."""
        if hasattr(self, "folder"):
            shutil.rmtree(self.folder)
