"""LLVM for this processor: from a program's text to object code, and into memory."""

from __future__ import annotations

import ctypes
import platform
import sys
from functools import cache
from typing import Any

import llvmlite
import llvmlite.binding as llvm

LEVEL = 3
NO_GATHER = '+prefer-no-gather,+prefer-no-scatter'
"""On x86-64 an instruction that picks lanes from many addresses costs more than as many loads."""


@cache
def processor() -> tuple[str, str, str]:
    """Return the triple, the name and the features of this processor."""
    triple, features = llvm.get_process_triple(), llvm.get_host_cpu_features().flatten()
    if triple.startswith('x86_64'):
        features = f'{features},{NO_GATHER}'
    return triple, llvm.get_host_cpu_name(), features


def versions() -> tuple[str, ...]:
    """Return all that compiled code depends on beside its sources."""
    made_by = llvmlite.__version__, str(llvm.llvm_version_info)
    return (sys.version, platform.machine(), *made_by, *processor())


def _machine(triple: str, name: str, features: str) -> Any:
    # as PyPI's builds of LLVM for Linux on x86-64 load it; elsewhere as LLVM thinks best
    static = triple.startswith('x86_64') and 'linux' in triple
    return llvm.Target.from_triple(triple).create_target_machine(
        cpu=name,
        features=features,
        opt=LEVEL,
        reloc='static' if static else 'default',
        codemodel='jitdefault',
        jit=True,
    )


def object_code(text: str, processor: tuple[str, str, str]) -> bytes:
    """Return the object code of a program for a processor: triple, name, features."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = _machine(*processor)
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = processor[0], str(machine.target_data)
    module.verify()
    tuning = llvm.create_pipeline_tuning_options(speed_level=LEVEL)
    # Kernels say themselves where lanes go. LLVM's own vectors and unrolled loops make a third of
    # the code and of its time, and run no faster.
    tuning.loop_vectorization = tuning.slp_vectorization = tuning.loop_unrolling = False
    passes = llvm.create_pass_builder(machine, tuning)
    passes.getModulePassManager().run(module, passes)
    code: bytes = machine.emit_object(module)
    return code


@cache
def _engine() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.create_mcjit_compiler(llvm.parse_assembly(''), _machine(*processor()))


_KIND = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_char_p, ctypes.c_void_p)


def loaded(code: bytes, name: str) -> Any:
    """Return the entry of object code as a function, which runs without Python's lock."""
    engine = _engine()
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return _KIND(engine.get_function_address(name))
