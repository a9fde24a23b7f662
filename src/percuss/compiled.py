"""How functions are compiled, and what their cache on disk is valid for.

Five decorators. `entry`: called from Python; its machine code, with that of all it calls, is kept in numba's cache.
`inner`: called from compiled functions only, so that it needs neither a wrapper for Python, nor a cache of its own, nor
machine code (`Whole`).
`inlined`: an `inner` that is copied into its callers, as a record of many arrays takes long to hand over. LLVM decides
which
others are; numba by itself would hand the copying down from a function to those that it is the first to call.
`summed`, `inlined_sums`: the same of functions whose sums may be reordered; NaN and infinity keep their meaning.

All of them work in arrays that the caller owns and make none. So numba is told not to count references to arrays: the
counting, atomic because of threads, took three quarters of the time of an impact. A function without a wrapper cannot
be called from Python: that would end the process. A test compiles it once more for itself, `njit(function.py_func)`.
"""

from __future__ import annotations

import gc
import hashlib
import operator
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from types import FunctionType
from typing import Any, ClassVar

from numba import njit
from numba.core import codegen, compiler, compiler_machinery, ir, ir_utils, types

# ---- Machine code made once, of a function that Python calls together with all that it calls
#
# By itself numba optimises each function with all that it calls, and makes machine code of it, even where only other
# compiled functions call it, in which it is then optimised again. And these copies can be seen under one name: which of
# them ran, each with another order in its sums, depended on what had been compiled or loaded before in the process, and
# the last digits of a result with it.
#
# Here a *part* is lowered and no more. A *whole* takes up its parts, their parts and so on, each once, hides them, and
# is optimised as one; hidden functions may be changed freely, so that members of a record that nobody reads are not
# handed over. Numbers are in `design/simulation-speed.md`.
#
# All this rests on inner names of numba. Where they are missing, `pipelines` is empty, and numba compiles as ever.

_llvm: Any = codegen
_Library: Any = codegen.JITCodeLibrary
_Compiler: Any = compiler.Compiler
_Pass: Any = compiler_machinery.FunctionPass
_registered: Any = compiler_machinery.register_pass
_ir: Any = ir
_guarded: Any = ir_utils.guard
_Function: Any = types.Function
_asked: Any = _Function.get_call_type

_IDLE = {
    "with_lifting", "inline_closure_likes", "rewrite_dynamic_raises", "make_function_op_code_to_jit_function",
    "inline_inlinables", "find_literally", "literal_unroll", "LiteralPropagation", "inline_overloads",
    "nopython_rewrites", "nopython_supported_feature_validation", "dump_parfor_diagnostics",
}  # fmt: skip
"""Passes for what no function here has: closures, contexts, raised errors, expressions of whole arrays."""

_KNOWN = (
    "_ensure_finalized", "_finalize_final_module", "_get_compiled_object", "_get_module_for_linking",
    "_optimize_final_module", "_optimize_functions", "_raise_if_finalized", "finalize", "get_pointer_to_function",
    "serialize_using_object_code",
)  # fmt: skip


class _Quiet:
    """The code generator for one whose functions have no address: nobody tells it where their environments are."""

    def __init__(self, generator: Any) -> None:
        self._generator = generator

    def __getattr__(self, name: str) -> Any:
        return getattr(self._generator, name)

    def set_env(self, env_name: str, env: Any) -> None:
        """Nothing: the functions of a part neither raise nor have constants that are objects."""


class _Own(_Library):  # type: ignore[misc]
    """A library of one function."""

    def _optimize_functions(self, module: Any) -> None:
        """Passes over single functions, with one manager for all of them, and not for those that are only named."""
        module.data_layout = self._codegen._data_layout
        manager, builder = self._codegen._function_pass_manager()
        for function in module.functions:
            if not function.is_declaration:
                manager.run(function, builder)


class _Part(_Own):
    """A function that only compiled ones call: neither optimised as a whole nor made into machine code."""

    @property
    def codegen(self) -> Any:
        return _Quiet(self._codegen)

    def finalize(self) -> None:
        self._raise_if_finalized()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    def alone(self) -> Any:
        """Its module, without those that it calls."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """With them, for a caller that is compiled in numba's own way."""
        module = self.alone().clone()
        for library in _all_of(self._linking_libraries):
            module.link_in(_module(library), preserve=True)
        return module


class _Whole(_Own):
    """A function that Python calls, with all that it calls."""

    def finalize(self) -> None:
        self._raise_if_finalized()
        module = self._final_module
        own = {function.name for function in module.functions if not function.is_declaration}
        for library in _all_of(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            module.link_in(_module(library), preserve=True)
        for function in module.functions:
            if not function.is_declaration and function.name not in own:
                function.linkage = "internal"
        self._optimize_final_module()
        module.verify()
        self._finalize_final_module()

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """For the cache: machine code, and names in place of the text it was made from, which takes longer to read."""
        self._ensure_finalized()
        module = self._final_module
        there = [one.name for one in (*module.functions, *module.global_variables) if not one.is_declaration]
        names = _llvm.ll.parse_assembly("\n".join(f'@"{name}" = global i8 0' for name in there))
        return self.name, "object", (self._get_compiled_object(), names.as_bitcode())


def _module(library: Any) -> Any:
    return library.alone() if isinstance(library, _Part) else library._get_module_for_linking()


def _all_of(libraries: Iterable[Any]) -> Iterable[Any]:
    """Libraries and, where they are parts, theirs, each once."""
    found: dict[int, Any] = {}
    waiting = list(libraries)
    while waiting:
        library = waiting.pop()
        if id(library) not in found:
            found[id(library)] = library
            waiting += library._linking_libraries if isinstance(library, _Part) else ()
    return found.values()


@_registered(mutates_CFG=False, analysis_only=False)
class _TellNone(_Pass):  # type: ignore[misc]
    """Numba prunes behind `is None` of arguments that are None; with this also of those that are known not to be."""

    _name = "percuss_tell_none"

    def __init__(self) -> None:
        _Pass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Puts the answers in place of the questions."""
        known, perhaps = state.func_ir._definitions, (types.NoneType, types.Optional, types.Omitted)
        for block in state.func_ir.blocks.values():
            for line in block.find_insts(_ir.Assign):
                asked = line.value
                if getattr(asked, "op", "") != "binop" or asked.fn not in (operator.is_, operator.is_not):
                    continue
                given, none = (
                    _guarded(ir_utils.get_definition, state.func_ir, side) for side in (asked.lhs, asked.rhs)
                )
                if not isinstance(given, _ir.Arg) or getattr(none, "value", 0) is not None:
                    continue
                if not isinstance(state.args[given.index], perhaps):
                    line.value = _ir.Const(asked.fn is operator.is_not, line.loc)
                    lines = known[line.target.name]
                    lines[lines.index(asked)] = line.value
        return True


class _Pipeline(_Compiler):  # type: ignore[misc]
    """numba's way from Python to machine code, with a library of ours."""

    library: ClassVar[type[_Own]]

    def define_pipelines(self) -> list[Any]:
        """numba's passes, without those that our functions give nothing to do: they take a fifth of the time."""
        found: list[Any] = super().define_pipelines()
        for manager in found:
            manager.passes = [one for one in manager.passes if one[0].name() not in _IDLE]
            pruned = [i for i, one in enumerate(manager.passes) if one[0].name() == "dead_branch_prune"]
            for i in reversed(pruned[1:]):
                del manager.passes[i]
            manager.passes.insert(pruned[0], (_TellNone, "what is not None"))
            manager.finalize()
        return found

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        if self.state.library is None:
            self.state.library = self.library(self.state.targetctx.codegen(), func.__qualname__)
            self.state.library.enable_object_caching()
        return super().compile_extra(func)


class _PartPipeline(_Pipeline):
    library = _Part


class _WholePipeline(_Pipeline):
    library = _Whole

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        with _swiftly():
            return super().compile_extra(func)


@contextmanager
def _swiftly() -> Iterator[None]:
    """Python looks for cycles among its objects, of which a compilation makes many, seldom; types are found once."""
    before = gc.get_threshold()
    gc.set_threshold(100_000, 50, 100)
    _Function.get_call_type = _remembered
    try:
        yield
    finally:
        _Function.get_call_type = _asked
        gc.set_threshold(*before)


def _remembered(function: Any, context: Any, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
    """The types of a call of an operator or a function of mathematics, for which numba tries all that it has anew."""
    if kws:
        return _asked(function, context, args, kws)
    known = function.__dict__.setdefault("_known_calls", {})
    if args not in known:
        known[args] = _asked(function, context, args, kws)
    return known[args]


def pipelines() -> tuple[dict[str, Any], dict[str, Any]]:
    """Options of numba's decorators for parts and for wholes; none where numba has not what they need."""
    if not all(hasattr(_Library, name) for name in _KNOWN):
        return {}, {}
    return {"pipeline_class": _PartPipeline}, {"pipeline_class": _WholePipeline}


# ---- How functions are compiled, and what their cache on disk is valid for

_compile: Callable[..., Any] = njit  # with options that its types do not know
_PART, _WHOLE = pipelines()
_COMMON: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False}
# where nothing is said of fastmath or of inlining, numba takes it from the caller that happens to be compiled first
_INNER: dict[str, Any] = {
    "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "fastmath": False, "forceinline": False, **_COMMON, **_PART
}  # fmt: skip
_SUMS = {"reassoc", "contract", "nsz"}

inner: Callable[[Any], Any] = _compile(**_INNER)  # compile a function that only compiled functions call

inlined: Callable[[Any], Any] = _compile(**(_INNER | {"forceinline": True}))
"""Compile a function that is copied into those that call it: records of arrays are costly to pass."""

summed: Callable[[Any], Any] = _compile(**(_INNER | {"fastmath": _SUMS}))
"""Compile a function that only compiled functions call, and whose sums may be reordered."""


inlined_sums: Callable[[Any], Any] = _compile(**(_INNER | {"fastmath": _SUMS, "forceinline": True}))
"""Compile a function that is copied into those that call it, and whose sums may be reordered."""


def entry(function: Callable[..., Any]) -> Any:
    """Compile a function that Python calls, cached for as long as none of its sources changes."""
    # By itself numba looks at the date of the function's own file only, not at what it calls.
    dispatcher = _compile(cache=True, no_cfunc_wrapper=True, **_COMMON, **_WHOLE)(function)
    if not hasattr(dispatcher, "_cache"):  # the compiler is switched off
        return dispatcher
    file, digest = dispatcher._cache._cache_file, sources_digest(Path(function.__code__.co_filename))
    file._source_stamp = digest
    # The version is all that is read of an index before its types are: those of other sources may be gone.
    file._version = f"{file._version} {digest}"
    if hasattr(dispatcher._cache, "_load_overload"):
        dispatcher._cache.load_overload = partial(_loaded, dispatcher._cache)
    return dispatcher


def _loaded(kept: Any, signature: Any, target: Any) -> Any:
    """What is kept for a signature, or None; numba itself first gets ready to compile: that is slow."""
    with kept._guard_against_spurious_io_errors():
        found = _brought(kept._cache_file).load(kept._index_key(signature, _Baseline)) if _serves() else None
        return kept._load_overload(signature, target) if found is None else kept._impl.rebuild(target, found)


# ---- Machine code that a wheel brings, made where it is built, for a baseline that most processors have

BASELINE = "x86-64-v3"
"""The name that LLVM and the psABI of x86-64 have for it: vectors of four numbers, products and sums in one."""

BROUGHT = Path(__file__).parent / "machine_code"
_HAS = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sse4.2")


class _Baseline:
    """What numba asks a code generator for when it makes a key of its cache."""

    @staticmethod
    def magic_tuple() -> tuple[str, str, str]:
        return _llvm.ll.get_process_triple(), BASELINE, ""


@cache
def _serves() -> bool:
    """Whether there is machine code of the baseline, and this processor has it."""
    if not (BROUGHT.is_dir() and _llvm.ll.get_process_triple().startswith("x86_64")):
        return False
    try:
        has = _llvm.ll.get_host_cpu_features()
    except RuntimeError:  # LLVM cannot tell
        return False
    return all(has.get(name, False) for name in _HAS)


def _brought(file: Any) -> Any:
    """The same index among what the wheel brought, which holds for the numba and the sources that it was made with."""
    found = type(file)(str(BROUGHT), file._index_name.removesuffix(".nbi"), file._source_stamp)
    found._version = file._version
    return found


def is_compiled(function: Any) -> bool:
    """Whether there is machine code of an `entry` for this processor; false where that cannot be told."""
    from numba.core.registry import cpu_target

    try:  # what numba calls its own; a test sees to it that this still answers
        file, own = function._cache._cache_file, cpu_target.target_context.codegen().magic_tuple()
        kept = [(file, own), *([(_brought(file), _Baseline.magic_tuple())] if _serves() else [])]
        return any(key[1] == machine for index, machine in kept for key in index._load_index())
    except Exception:
        return False


_TWINS: dict[Any, Any] = {}


def twin(function: Any) -> Any:
    """The compiled form, an `inner`, of a plain function and all it calls: one source, interpreted and compiled."""
    if function not in _TWINS:
        names = dict(function.__globals__)
        _TWINS[function] = inner(FunctionType(function.__code__, names, function.__name__, function.__defaults__))
        for name in function.__code__.co_names:
            called = names.get(name)
            if isinstance(called, FunctionType) and called.__module__.startswith("percuss."):
                names[name] = twin(called)
    return _TWINS[function]


_ROOM = "kernels"  # name of a folder of compiled functions
_BESIDE = ("kernels", "flight", "series", "records")


@cache
def sources_digest(own: Path) -> str:
    """SHA-256 of the sources that a compiled function may consist of."""
    # Of one in a room of kernels: the files of that room. Of another: its own file, those beside it whose names end
    # like those of kernels, the flow, and the room of the simulation. And this file, for all.
    here = Path(__file__)
    if own.parent.name == _ROOM:
        sources = [*own.parent.glob("*.py")]
    else:
        beside = [path for end in _BESIDE for path in own.parent.glob(f"*_{end}.py")]
        sources = [
            own,
            *beside,
            here.parent / "mechanics" / "flow.py",
            *(here.parent / "simulate" / _ROOM).glob("*.py"),
        ]
    files = {path.resolve() for path in (here, *sources)}
    found = hashlib.sha256()
    for path in sorted(files):
        found.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return found.hexdigest()
