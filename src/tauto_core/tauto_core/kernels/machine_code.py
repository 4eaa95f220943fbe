"""LLVM for this processor: from a program's text to object code, and into memory.

Code kept on disk needs this module only, not the `translation`.
"""

from __future__ import annotations

import ctypes
import platform
import sys
from enum import Enum
from functools import cache
from typing import Any

import llvmlite
import llvmlite.binding as llvm

NO_GATHER = '+prefer-no-gather,+prefer-no-scatter'
"""On x86-64 gathering lanes from many addresses costs more than as many loads."""


class Effort(Enum):
    """LLVM's effort: code soon, or fast code. Both give the same bits.

    Attributes:
        level: level of LLVM's code generator.
        lines_per_s: lines of LLVM's text compiled per second, on a common machine.
    """

    QUICK = 1, 20_000.0
    OPTIMISED = 3, 8_000.0

    def __init__(self, level: int, lines_per_s: float) -> None:
        self.level, self.lines_per_s = level, lines_per_s


@cache
def processor() -> tuple[str, str, str]:
    """Return the triple, the name and the features of this processor."""
    triple, features = llvm.get_process_triple(), llvm.get_host_cpu_features().flatten()
    if triple.startswith('x86_64'):
        features = f'{features},{NO_GATHER}'
    return triple, llvm.get_host_cpu_name(), features


@cache
def compiler_versions() -> tuple[str, ...]:
    """Return everything that compiled code depends on, except its sources."""
    made_by = llvmlite.__version__, str(llvm.llvm_version_info)
    return (sys.version, platform.machine(), *made_by, *processor())


def _machine(effort: Effort, triple: str, name: str, features: str) -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    # the relocation model of PyPI's LLVM for Linux on x86-64. Elsewhere LLVM's default
    static = triple.startswith('x86_64') and 'linux' in triple
    return llvm.Target.from_triple(triple).create_target_machine(
        cpu=name,
        features=features,
        opt=effort.level,
        reloc='static' if static else 'default',
        codemodel='jitdefault',
        jit=True,
    )


def object_code(
    text: str, processor: tuple[str, str, str], effort: Effort = Effort.OPTIMISED
) -> bytes:
    """Return the object code of a program for a processor: triple, name, features."""
    machine = _machine(effort, *processor)
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = processor[0], str(machine.target_data)
    module.verify()
    tuning = llvm.create_pipeline_tuning_options(speed_level=effort.level)
    # Kernels place their lanes themselves. LLVM's own vectors and unrolled loops make a third of
    # the code and of the compile time, and run no faster.
    tuning.loop_vectorization = tuning.slp_vectorization = tuning.loop_unrolling = False
    builder = llvm.create_pass_builder(machine, tuning)
    if effort is Effort.QUICK:
        passes = llvm.create_new_module_pass_manager()
        # these two passes save the code generator as much time as they take
        passes.add_instruction_combine_pass()
        passes.add_simplify_cfg_pass()
    else:
        passes = builder.getModulePassManager()
    passes.run(module, builder)
    code: bytes = machine.emit_object(module)
    return code


@cache
def _engine() -> Any:
    machine = _machine(Effort.OPTIMISED, *processor())
    return llvm.create_mcjit_compiler(llvm.parse_assembly(''), machine)


_KIND = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_char_p, ctypes.c_void_p)


def loaded(code: bytes, name: str) -> Any:
    """Return the entry of object code as a function that runs without Python's lock."""
    engine = _engine()
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return _KIND(engine.get_function_address(name))
