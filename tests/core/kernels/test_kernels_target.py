"""The code gives the same bits on all processors: with vectors or without, and on arm64."""

from __future__ import annotations

import ctypes
import math
import struct
import threading
from itertools import product
from typing import Any

import numpy as np
import pytest

from tauto_core.kernels import entry, machine_code
from tauto_core.kernels.entries import structure_of, unpacker
from tauto_core.kernels.translation import Program
from tauto_core.motion.lanes import combined, fma, largest, row_of, square_root, store, total


def of_lanes(rows: Any, x: float) -> Any:
    a, b = row_of(rows, 0), row_of(rows, 1)
    c = fma(a, x, square_root(b * b + 1.0) / (a - 3.0))
    store(rows, 1, c)
    return total(c), largest(c), total(combined(rows, 0, a))


def text_of(kernel: Any, *args: Any) -> tuple[str, Any]:
    program = Program(kernel, [structure_of(arg) for arg in args], 'entry_of_a_test')
    return str(program.module), program.result


def test_a_processor_without_vectors_gives_the_same_bits():
    """Optimised or not. On plain x86-64 the C library's fma replaces the instruction."""
    if not machine_code.processor()[0].startswith('x86_64'):
        pytest.skip('x86-64 alone has processors that differ so much')
    rows = np.random.default_rng(1).normal(size=(9, 8))
    text, layout = text_of(of_lanes, rows, 0.7)
    plain = machine_code.processor()[0], 'x86-64', ''
    found = []
    made = product((machine_code.processor(), plain), machine_code.Effort)
    for number, (processor, effort) in enumerate(made):
        name = f'entry_{number}'
        code = machine_code.object_code(text.replace('entry_of_a_test', name), processor, effort)
        call, (words, unpack) = machine_code.loaded(code, name), unpacker(layout)
        mine, back = rows.copy(), (ctypes.c_int64 * words)()
        assert call(struct.pack('qd', id(mine), 0.7), back) == 0
        found.append((unpack(back), mine.tobytes()))
    assert len(found) == 4
    assert all(each == found[0] for each in found)


def test_code_for_arm64_can_be_made():
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    text, _ = text_of(of_lanes, np.ones((9, 8)), 0.7)
    code = machine_code.object_code(text, ('aarch64-unknown-linux-gnu', 'generic', ''))
    assert code[:4] == b'\x7fELF'
    assert int.from_bytes(code[18:20], 'little') == 183  # EM_AARCH64


def arithmetic(a: float, b: float, i: int, j: int) -> Any:
    return a / b + i, i / j, i // j, i % j, -i // 3, a**5, 0.25**j, a**-2, max(a, b), min(i, j)


def library(a: float, b: float) -> Any:
    one = math.sin(a), math.cos(b), math.exp(a), math.atan2(a, b), math.hypot(a, b), math.asin(b)
    return one, math.asinh(a), math.copysign(a, -b), round(a), math.floor(a), int(a), abs(a)


def loops(values: Any, n: int) -> Any:
    total, low, last = 0.0, 1, 0
    for i in range(n):
        if values[i] < 0.0:
            continue
        total += values[i] * values[i] + 0.1
        low = low * 3 % 1001
        last = i if total < 5.0 else last
    while low > 7:
        low //= 2
    return total, low, last


@pytest.mark.parametrize(
    ('kernel', 'args'),
    [
        (arithmetic, (1.7, -0.3, 17, 5)),
        (arithmetic, (-1e200, 1e-200, -17, 3)),
        (library, (2.5, 0.3)),
        (library, (-0.1, -0.9)),
        (loops, (np.random.default_rng(2).normal(size=100), 100)),
    ],
    ids=lambda x: getattr(x, '__name__', ''),
)
def test_numba_gives_the_same_bits(kernel, args):
    """numba is an independent compiler of the same language."""
    numba = pytest.importorskip('numba')
    theirs = numba.njit(error_model='numpy')(kernel)(*args)
    assert np.array_equal(_flat(entry(kernel)(*args)), _flat(theirs))


def _flat(x: Any) -> list[float]:
    return [each for item in x for each in _flat(item)] if isinstance(x, tuple) else [float(x)]


def test_kernels_of_two_threads_run_at_the_same_time():
    """Each kernel waits for the other, which a lock would prevent."""

    @entry
    def meet(flags: Any, mine: int, other: int) -> bool:
        flags[mine] = 1
        for _ in range(1 << 33):
            if flags[other] == 1:
                return True
            flags[2] += 1
        return False

    flags, met = np.zeros(3, np.int64), []
    threads = [
        threading.Thread(target=lambda pair=pair: met.append(meet(flags, *pair)))
        for pair in ((0, 1), (1, 0))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert met == [True, True]
