"""Whether the simulator can be used at once, or would be compiled first."""

from __future__ import annotations


def compiled() -> bool:
    """Whether numba's cache holds the kernels for this processor, so that using them takes a moment and not a minute.

    False too where that cannot be told, such as with numba's compiler switched off.
    """
    from numba.core.registry import cpu_target

    from percuss.simulate.kernels.motion import follow

    try:  # what numba calls its own; a test sees to it that this still answers
        index = follow._cache._cache_file._load_index()
        machine = cpu_target.target_context.codegen().magic_tuple()
        return any(key[1] == machine for key in index)
    except Exception:
        return False
