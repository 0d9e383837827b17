"""How kernels become machine code. Numba optimises and emits every function on its own, those too that only kernels
call; here those are lowered once, and become machine code as part of the entries that call them."""

from __future__ import annotations

from typing import Any, ClassVar

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering

from .compile_notice import compiling


class InnerLibrary(JITCodeLibrary):
    """LLVM's code of a kernel that only kernels call: it is never finished on its own."""

    def _ensure_finalized(self) -> None:
        pass

    def add_linking_library(self, library: Any) -> None:
        library._ensure_finalized()
        self._linking_libraries.append(library)

    def own_module(self) -> Any:
        """The module without what it calls; its functions may stand in several entries."""
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage.name == "external":
                function.linkage = "linkonce_odr"
        return self._final_module

    def _get_module_for_linking(self) -> Any:
        """The module with all that it calls, for functions that numba compiles in its usual way."""
        if self._shared_module is None:
            self._shared_module = self.own_module().clone()
            for library in _all_called(self._linking_libraries):
                if library is not self:
                    self._shared_module.link_in(_module_of(library), preserve=True)
        return self._shared_module


class EntryLibrary(JITCodeLibrary):
    """The library of a kernel that Python calls, with all that it calls."""

    def finalize(self) -> None:
        called = _all_called(self._linking_libraries)
        self._linking_libraries = []
        for library in called:
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(_module_of(library), preserve=True)
        super().finalize()

    def _optimize_final_module(self) -> None:
        """Once, and without vectors: matrices are too small for these, and to look for them takes a fifth of all."""
        passes, builder = self._codegen._module_pass_manager(opt=1, loop_vectorize=False, slp_vectorize=False)
        passes.run(self._final_module, builder)


def _module_of(library: Any) -> Any:
    return library.own_module() if isinstance(library, InnerLibrary) else library._get_module_for_linking()


def _all_called(libraries: list[Any]) -> list[Any]:
    """The libraries, and those they call that are not finished, each once and after all that call it. LLVM leaves out a
    function that nothing linked so far asks for."""
    finished: dict[Any, None] = {}

    def visit(library: Any) -> None:
        if library not in finished:
            for called in library._linking_libraries if isinstance(library, InnerLibrary) else []:
                visit(called)
            finished[library] = None

    for library in libraries:
        visit(library)
    return list(reversed(finished))


class SharedFlags(Flags):
    """Flags of which equal ones are one object: numba looks them up a hundred thousand times, and compares all their
    values each time."""

    __slots__ = ()
    __eq__, __hash__ = object.__eq__, object.__hash__
    known: ClassVar[dict[str, SharedFlags]] = {}

    def copy(self) -> SharedFlags:
        return self.known.setdefault(self.summary(), SharedFlags(self))


@register_pass(mutates_CFG=True, analysis_only=False)
class InnerLowering(NativeLowering):
    """Lowers, and leaves it at that."""

    _name = "inner_lowering"

    def run_pass(self, state: Any) -> bool:
        library = state.library = InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        super().run_pass(state)
        # What numba knows the function by is a builtin, each its own; nobody can call it.
        lowered = state["cr"] = state["cr"]._replace(cfunc=[library].index)
        state.targetctx.insert_user_function(lowered.cfunc, lowered.fndesc, [library])
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class EntryLowering(NativeLowering):
    _name = "entry_lowering"

    def run_pass(self, state: Any) -> bool:
        state.library = EntryLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return bool(super().run_pass(state))


class EntryCompiler(CompilerBase):
    lowering: Any = EntryLowering

    def compile_extra(self, function: Any) -> Any:
        if self.lowering is EntryLowering:
            compiling(function.__name__)
        return super().compile_extra(function)

    def _compile_core(self) -> Any:
        self.state.flags = SharedFlags(self.state.flags)
        return super()._compile_core()

    def define_pipelines(self) -> list[Any]:
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.passes = [(self.lowering if p is NativeLowering else p, words) for p, words in manager.passes]
        manager.finalize()
        return [manager]


class InnerCompiler(EntryCompiler):
    lowering = InnerLowering

    def _compile_core(self) -> Any:
        self.state.flags.no_compile = True
        return super()._compile_core()
