"""Each construct of the kernel language gives the results of plain Python, bit for bit."""

from __future__ import annotations

import inspect
import math
import struct
from typing import Any, NamedTuple

import numpy as np
import pytest

from tauto_core.kernels import KernelError, compiled, entry, inlined

FACTORS = (1.0, -0.5, 0.25, 3.0)
SHIFT, MASK = np.uint64(33), np.uint64(2**40 - 1)


@pytest.fixture(autouse=True, scope='module')
def own_cache(tmp_path_factory):
    """Keep the code of earlier runs away."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('TAUTO_CACHE_DIR', str(tmp_path_factory.mktemp('kernels')))
        yield


def bits(x: Any) -> Any:
    """Each number with its kind and all its bits."""
    if isinstance(x, tuple):
        return tuple(bits(item) for item in x)
    if isinstance(x, np.ndarray):
        return x.dtype.str, x.shape, x.tobytes()
    if isinstance(x, (bool, np.bool_)):
        return 'bool', bool(x)
    if isinstance(x, float):
        return 'nan' if math.isnan(x) else struct.pack('d', x)
    return 'int', None if x is None else int(x)


class Pair(NamedTuple):
    first: Any
    second: Any

    @property
    def total(self) -> Any:
        return self.first + self.second

    def scaled(self, by: Any) -> Any:
        return Pair(by * self.first, by * self.second)


class Other(NamedTuple):
    only: Any


def numbers(a: float, b: float, i: int, j: int) -> Any:
    return a + b, a - b, a * b, a / b, a + i, i - a, i * j, i / j, -a, +a, -i, i + j, i - j


def whole_numbers(i: int, j: int) -> Any:
    return i // j, i % j, i & j, i | j, i ^ j, ~i, i << 3, i >> 2, abs(i), min(i, j), max(i, j)


def divided_by_known(i: int) -> Any:
    return i // 7, i % 7, i // -7, i % -7, -(i + 3) % 10


def unsigned(i: int) -> Any:
    u = np.uint64(i) * np.uint64(0x9E3779B97F4A7C15)
    return np.int64((u >> SHIFT) & MASK), np.int64(u >> np.uint64(1)) * 2.0**-63


def powers(a: float, i: int) -> Any:
    return a**2, a**0, a**1, i**3, 2.0**i, 0.25 ** (3 - i), 2**10


def functions(a: float, b: float) -> Any:
    x = abs(a) + 0.5
    one = math.sqrt(x), math.cos(b), math.exp(a), math.atan2(a, b), math.hypot(a, b)
    two = math.sin(b), math.asin(a / (1.0 + x)), math.asinh(a), math.copysign(a, b), math.tan(a)
    three = math.log(x), math.isfinite(a / b), math.isfinite(a), math.sqrt(2.0)
    return one, two, three, abs(a), min(a, b), max(a, b, 0.0), max(2, 3)


def conversions(a: float, i: int) -> Any:
    one = int(a), float(i), round(a), math.floor(a), math.ceil(a)
    return one, bool(i), int(i > 2), float(a < 1)


def comparisons(a: float, b: float, i: int) -> Any:
    one = a < b, a <= b, a > b, a >= b, a == b, a != b, i < 3, i == 3
    return one, a < b < 2.0, 0 < i <= 3, (a < b) == (i > 0)


def connected(a: float, b: float, i: int) -> Any:
    return (a < b and i > 1), (a < b or i > 1), not (a < b), (True and a < b), (False or i > 1)


def chosen(a: float, i: int) -> Any:
    sign = 1 if a > 0.0 else -1
    pair = (a, i) if a > 0.0 else (-a, 2)
    return sign, pair, (a if i > 2 else 2.0 * a if i > 1 else 3.0 * a)


def branches(a: float, i: int) -> Any:
    kept, whole = 0.0, 0
    if i > 3:
        kept = a
    elif i > 1:
        kept, whole = 2.0 * a, i
    else:
        whole = 7
    return kept, whole


def returns_early(a: float, i: int) -> Any:
    if i < 0:
        return -1.0
    for k in range(i):
        if k * a > 3.0:
            return k
    return a


def counts(n: int) -> Any:
    total, down, back = 0, 0, 0
    for k in range(n):
        total += k * k
    for k in range(2, n, 3):
        down = 2 * down + k
    for k in range(n, -1, -1):
        back = 3 * back - k
    return total, down, back


def carries(n: int) -> Any:
    grown, seen, last = 0.0, False, 1
    for k in range(n):
        grown = grown + k
        seen |= k > 2
        last = -last
    return grown, seen, last


def leaves_loops(n: int) -> Any:
    found, odd = -1, 0
    for k in range(n):
        if k % 2 == 0:
            continue
        odd += k
        if odd > 20:
            found = k
            break
    while odd > 3:
        odd //= 2
        if odd == 5:
            break
    return found, odd


def swaps(a: float, b: float, n: int) -> Any:
    x, y = a, b
    for _ in range(n):
        x, y = y, x + y
    return x, y


def nested_loops(n: int) -> Any:
    total = 0.0
    for i in range(n):
        row = 1.0
        for j in range(i):
            if j == 3:
                continue
            row = row * 0.5 + j
        total += row
    return total


def picks(a: float, i: int) -> Any:
    value = 0.0
    for k in range(3, -1, -1):
        value = value * a + FACTORS[k]
    return value, FACTORS[i % 4], (a, 2.0, -a)[i % 3]


def tuples(a: float, i: int) -> Any:
    pair = a, (i, 2.0 * a)
    first, (second, third) = pair
    joined = pair + (i,)  # noqa: RUF005
    total = 0.0
    for item in (a, 2.0, third):
        total += item
    return first, second, third, joined[2], len(joined), pair[1][0], joined[1:], joined[-1], total


def named(a: float, i: int) -> Any:
    pair = Pair(a, i)
    moved = pair.scaled(2.0).scaled(by=3.0)
    return pair.first, pair.total, moved.second, moved[0], tuple_of(pair), isinstance(pair, Pair)


@compiled
def tuple_of(pair: Any) -> Any:
    first, second = pair
    return second, first


@inlined
def polynomial(x: float, more: Any = None, factor: float = 2.0) -> float:
    if more is not None:
        return factor * x + more
    return factor * x


def called(a: float, i: int) -> Any:
    return polynomial(a), polynomial(a, 1.0), polynomial(a, factor=3.0), polynomial(more=a, x=i)


def power_sum(x: float, terms: int, more: float = 0.5, factor: float = 2.0) -> float:
    total = more
    for _ in range(terms):
        total = factor * total + x
    return total


def called_apart(a: float, i: int) -> Any:
    return power_sum(a, i), power_sum(a, i, 1.0), power_sum(terms=i, factor=a, x=3.0)


def arrays(rows: Any, whole: Any, flags: Any) -> Any:
    rows[0, 1] = 2 * rows[1, 0]
    rows[1, -1] += 0.5
    row = rows[1]
    row[0] -= 1.0
    whole[:] = 3
    whole[1] = whole[0] + len(whole)
    flags[0] = row[0] > 0.0
    flags[1] &= True
    flat = rows.reshape(-1)
    flat[-2:] = 0.25
    return flat[1], rows.shape[0], rows.shape[1], len(flat), flags[0], len(whole[1:])


def swapped_items(rows: Any) -> Any:
    rows[0, 0], rows[1, 1] = rows[1, 1], rows[0, 0]
    return rows[0, 0]


def makes_arrays(n: int) -> Any:
    squares, spare = np.empty(n), np.empty((n, 2), np.int64)
    whole = np.empty_like(spare)
    for i in range(n):
        squares[i] = i * i
        spare[i, 0], spare[i, 1] = i, -i
        whole[i, 0], whole[i, 1] = 2 * i, 3
    return squares[: n - 1], whole, squares[1] + spare[1, 1]


def finds_places(knots: Any, x: float) -> Any:
    return np.searchsorted(knots, x, 'right')


def absent(a: float, term: Any) -> Any:
    if term is None:
        return a
    return a + term[0]


def records(states: Any) -> Any:
    state = states[1]
    state.count += 3
    state.angle = 0.5 * state.angle + states[0].angle
    return state.angle, state.count


SAMPLES = {
    numbers: [(1.5, -0.25, 7, -3), (1e308, 10.0, -9, 4)],
    whole_numbers: [(17, 5), (-17, 5), (17, -5), (-17, -5)],
    divided_by_known: [(23,), (-23,)],
    unsigned: [(12345678901,)],
    powers: [(1.7, 3), (-0.3, 5)],
    functions: [(0.7, -1.3), (-2.5, 0.1), (math.nan, 1.0)],
    conversions: [(2.5, 3), (-3.5, 0), (0.4, -2)],
    comparisons: [(1.0, 2.0, 3), (2.0, 1.0, 4), (math.nan, 1.0, 0)],
    connected: [(1.0, 2.0, 3), (2.0, 1.0, 3), (1.0, 2.0, 0)],
    chosen: [(1.5, 3), (-1.5, 2), (0.0, 1)],
    branches: [(1.5, 4), (1.5, 2), (1.5, 0)],
    counts: [(0,), (1,), (11,)],
    carries: [(0,), (6,)],
    leaves_loops: [(3,), (30,)],
    swaps: [(1.0, 2.0, 0), (1.0, 2.0, 5)],
    nested_loops: [(7,)],
    picks: [(1.3, 5)],
    tuples: [(1.3, 5)],
    named: [(1.3, 5)],
    called: [(1.3, 5)],
    called_apart: [(1.3, 5)],
    makes_arrays: [(4,)],
    finds_places: [(np.array([0.0, 1.0, 1.0, 2.0]), x) for x in (-1.0, 0.0, 1.0, 1.5, 9.0)],
    absent: [(1.5, None), (1.5, (2.0,))],
    swapped_items: [(np.arange(4.0).reshape(2, 2),)],
    arrays: [(np.arange(6.0).reshape(2, 3), np.zeros(3, np.int64), np.array([False, True]))],
}


@pytest.mark.parametrize('kernel', SAMPLES, ids=lambda kernel: kernel.__name__)
def test_a_construct_gives_what_python_gives(kernel):
    fast = entry(kernel)
    for given in SAMPLES[kernel]:
        plain = [x.copy() if isinstance(x, np.ndarray) else x for x in given]
        mine = [x.copy() if isinstance(x, np.ndarray) else x for x in given]
        with np.errstate(over='ignore'):
            expected = kernel(*plain)
        assert bits(fast(*mine)) == bits(expected), given
        assert bits(tuple(mine)) == bits(tuple(plain)), given


def test_a_constant_power_is_a_product():
    def power(a: float) -> Any:
        return a**5, a**-3

    for a in (1.7, -0.3, 1e60):
        assert entry(power)(a) == (a * ((a * a) * (a * a)), 1.0 / (a * (a * a)))


def test_branches_that_return_a_float_or_an_int_return_a_float():
    fast = entry(returns_early)
    for a, i in ((1.5, -1), (1.5, 9), (0.1, 4)):
        found = fast(a, i)
        assert isinstance(found, float)
        assert found == returns_early(a, i)


def test_records_are_read_and_written_by_their_fields():
    kind = np.dtype([('angle', 'f8'), ('count', 'i8')])
    states = np.array([(1.0, 2), (3.0, 4)], kind)
    assert entry(records)(states) == (2.5, 7)
    assert states[1].tolist() == (2.5, 7)
    assert states[0].tolist() == (1.0, 2)


def test_fields_of_a_record_hold_one_number_or_several():
    def moved(state: Any) -> Any:
        places = state.places
        places[1] += state.speed
        state.places[2] = places[0]
        state.late = state.places[1] > 2.0
        return state.places[1]

    kind = np.dtype([('late', '?'), ('places', 'f8', (3,)), ('speed', 'f8')], align=True)
    state = np.array((False, (1.0, 2.0, 3.0), 0.5), kind)
    assert entry(moved)(state) == 2.5
    assert state['places'].tolist() == [1.0, 2.5, 1.0]
    assert state['late']
    with pytest.raises(KernelError, match='only its fields and their items'):
        entry(replaces_a_field)(state)


def replaces_a_field(state: Any) -> None:
    state.places = 1.0


def test_division_by_zero_is_as_in_numpy():
    def divided(a: float, i: int, j: int) -> Any:
        return a / j, i / j, i // j, i % j

    with np.errstate(all='ignore'):
        one, zero = np.array([7]), np.array([0])
        expected = (-math.inf, math.inf, int((one // zero)[0]), int((one % zero)[0]))
    assert entry(divided)(-1.0, 7, 0) == expected


@inlined
def kind_of(x: Any) -> int:
    if x is None:
        return 0
    if isinstance(x, Pair):
        return x.second
    return 2 if isinstance(x, Other) else 3


def test_a_class_test_of_an_argument_leaves_one_branch():
    @entry
    def kinds(pair, other, number):
        return kind_of(None), kind_of(pair), kind_of(other), kind_of(number)

    assert kinds(Pair(1.0, 7), Other(2.0), 1.0) == (0, 7, 2, 3)


class Doubles:
    """A base of a class of numbers."""

    first: float

    @property
    def twice(self) -> float:
        return 2.0 * self.first

    def times(self, factor: float) -> float:
        return self.first * factor


class Inheriting(Pair, Doubles):
    """Numbers, with a method of their own too."""

    def all(self) -> float:
        return self.twice + self.times(10.0) + self.second


def test_a_class_of_numbers_inherits_methods_and_properties():
    numbers = Inheriting(1.5, 7)

    @entry
    def all_of(numbers):
        return numbers.all()

    assert all_of(numbers) == numbers.all() == 25.0


def test_a_record_holds_records_and_arrays_of_them():
    def moved(state: Any, p: int) -> Any:
        state.now.x += 1.0
        places = state.places
        places[p].y = state.now.x
        state.rows[3] = places[0].x
        return places[1].x + places[p].y, len(places)

    point = np.dtype([('x', 'f8'), ('y', 'f8')])
    fields = [('late', '?'), ('now', point), ('places', point, (2,)), ('rows', 'f8', (2, 2))]
    state = np.zeros((), np.dtype(fields, align=True))
    state['now'], state['places'] = (1.0, 2.0), [(3.0, 4.0), (5.0, 6.0)]
    assert entry(moved)(state, 1) == (7.0, 2)
    assert state['places'].tolist() == [(3.0, 4.0), (5.0, 2.0)]
    assert state['rows'].tolist() == [[0.0, 0.0], [0.0, 3.0]]


REFUSED = {
    'an unknown name': (lambda a: a + absentee, 'absentee is not set'),  # type: ignore[name-defined]  # noqa: F821
    'a list': (lambda a: [a], 'List'),
    'a word': (lambda a: 'x' + a, "Add of 'x' and float"),
    'a picked item of many kinds': (lambda a: (a, 1)[int(a)], 'picked'),
    'an unknown function': (lambda a: math.gamma(a), 'cannot call'),
    'a slice with a step': (lambda rows: rows[::2], 'step'),
    'too few arguments': (lambda a: polynomial(), 'takes x'),  # type: ignore[call-arg]
    'a missing field': (lambda a: Pair(a, a).third, 'third'),
    'a power that is not whole': (lambda a: a**0.5, 'no power float'),
    'a search in a tuple': (lambda i: i in (1, 3), 'no In. Compare'),
    'a function that is not there': (lambda a: math.isnan(a), 'cannot call'),
    'two kinds of whole number': (lambda i: np.uint64(i) + i, 'np.int64'),
}


@pytest.mark.parametrize('name', REFUSED)
def test_an_unknown_construct_is_refused_with_its_place(name):
    kernel, words = REFUSED[name]
    argument = {'rows': np.zeros(3), 'i': 1}.get(kernel.__code__.co_varnames[0], 1.0)
    with pytest.raises(KernelError, match=words) as caught:
        entry(kernel)(argument)
    assert f'{__file__}:{kernel.__code__.co_firstlineno}' in str(caught.value)


def sometimes(a):
    if a > 0.0:
        x = 1.0
    return x


def of_two_kinds(a):
    x = None
    if a > 0.0:
        x = a
    return x + 1.0


def in_a_loop(a):
    x = None
    for _ in range(int(a)):
        x = a if x is None else x + a
    return x


def widens(a):
    total: Any = 0
    for k in range(int(a)):
        total += 0.5 * k
    return total


def widens_in_a_tuple(a):
    pair: Any = (a, 0)
    while pair[0] > 0.0:
        pair = (pair[0] - 1.0, 0.5)
    return pair


def deep(a):
    for _ in range(3):
        a = deep(a)
    return a


@pytest.mark.parametrize(
    ('kernel', 'words'),
    [
        (sometimes, 'x may not have been set'),
        (of_two_kinds, 'x is None or float|x is float or None'),
        (in_a_loop, 'x is None before a loop that sets it'),
        (widens, r'total is int before the loop and float at its end. .* 0\.0 in place of 0'),
        (widens_in_a_tuple, 'pair is int before the loop and 0.5 at its end'),
        (deep, 'deep calls itself'),
    ],
)
def test_a_variable_must_have_one_kind_to_be_read(kernel, words):
    with pytest.raises(KernelError, match=words):
        entry(kernel)(1.0)


def test_an_error_names_all_functions_on_its_way():
    @compiled
    def inner(a):
        for _ in range(2):
            a = a + missing  # type: ignore[name-defined]  # noqa: F821
        return a

    def outer(a):
        return inner(a)

    with pytest.raises(KernelError) as caught:
        entry(outer)(1.0)
    line = inspect.getsourcelines(inner)[1]
    places = str(caught.value).splitlines()[1:]
    assert [place.rpartition('.')[2] for place in places] == ['inner', 'outer']
    assert f':{line + 3} in' in places[0]


def test_unsupported_arguments_are_refused_by_name():
    fast = entry(lambda rows: rows[0, 0])
    with pytest.raises(KernelError, match='rows is or holds an array that is not C-contiguous'):
        fast(np.zeros((4, 3)).T)
    with pytest.raises(KernelError, match='float32'):
        fast(np.zeros((2, 2), np.float32))
    with pytest.raises(KernelError, match='list'):
        fast([1.0])
    with pytest.raises(TypeError, match='takes 1 positional argument'):
        fast(np.zeros((2, 2)), 1)
    assert fast(np.ones((2, 2))) == 1.0


def test_each_structure_of_arguments_has_its_own_code():
    @entry
    def half(x):
        return x / 2 if isinstance(x, float) else x // 2

    assert half(7) == 3
    assert half(np.int64(7)) == 3
    assert half(7.0) == half(np.float64(7.0)) == 3.5
    assert len(half._made) == 2
