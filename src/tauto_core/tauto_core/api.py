"""The commands as functions, for scripts and notebooks.

Each option of the command line is declared here alone: type and default in the signature, unit and
meaning in the docstring (`tauto_core.cli.calls`). Arguments are checked before anything runs. A
number may be a text with another unit: `reach_rad='60 deg'`. `progress` is called with the share
done, from 0 to 1.
"""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypeGuard, cast

from tauto_core.scene.errors import (
    ABSENT,
    Argument,
    ArgumentText,
    TautoWarning,
    UsageError,
    naming,
)
from tauto_core.scene.times import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tauto_core.bags import BagReport, Recovered
    from tauto_core.ensembles.budget import Budget
    from tauto_core.ensembles.comparison import Comparison
    from tauto_core.ensembles.fleets import Fleet
    from tauto_core.ensembles.trials import TrialAnswers
    from tauto_core.euler import Claim
    from tauto_core.machines import Isochronism
    from tauto_core.machines.design import WheelDesign
    from tauto_core.machines.fluid_pendulum import DescentIsochronism
    from tauto_core.plots.cutting import CamOutline
    from tauto_core.scene import Scene
    from tauto_core.voyage import Voyage

# Each call imports the modules it needs, which keeps `tauto --help` fast.

Quantity: TypeAlias = float | str
"""A number in the unit of the argument, or a text with a unit, such as `5 mm`."""
File: TypeAlias = str | Path
Files: TypeAlias = str | Path | Iterable[str | Path]
Range: TypeAlias = str | tuple[float | str, float | str]
"""Lower and upper bound, or a text such as `42..100`, `42..` or `..100`."""
Progress: TypeAlias = Callable[[float], None]
Counting: TypeAlias = Callable[[float, int], None]

_GONE: list[tuple[str, str, list[str | Argument]]] = [
    (
        *('smooth', 'replay'),
        [
            'no drift in hindsight is estimated any more. Use the estimate at the end, `drift` of '
            'the result, which knows all observations'
        ],
    ),
    ('plot', 'replay', ['the stability is drawn by `plot`. Use that, with `stability`']),
    (
        *('scheduler', 'fleet'),
        ['is no more. Use ', Argument('jobs'), ', or other seeds on other machines'],
    ),
    ('template', 'cam', ['is no longer written. Use ', Argument('svg')]),
    (
        *('wind_draws hull_draws', 'fleet'),
        ['a trial sails each passage once. Draw a hull or a sea with ', Argument('vary')],
    ),
    ('port ocean', 'fleet', ['choose passages by ', Argument('years')]),
    ('local_time_s', 'fleet', ['is not added any more. 4 s are a minute of longitude']),
    (
        *('logs passage harbour_days', 'compare'),
        [
            *('sail it as a trial with ', Argument('compare'), ', or give the scene of a passage'),
            *(' (`tauto logbook`) as ', Argument('ship_of')),
        ],
    ),
    ('page', 'euler', ['is no longer written. Use ', Argument('site')]),
    (
        *('length_unit weight_unit', 'design'),
        ['write the unit behind the number, as in ', Argument('pull', '3N')],
    ),
    ('file', 'trial', ['is not an argument. Use ', Argument('plot')]),
]
GONE = {
    name: (command, ArgumentText(': ', *parts))
    for names, command, parts in _GONE
    for name in names.split()
}
"""Arguments that were taken away: their command, and what to use."""

# -----------------------------------------------------------------------------
# Check the types of arguments from Python.


def whole(name: str, value: object) -> int:
    """Return a whole number, also from NumPy, or raise UsageError."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise UsageError(f'{name} = {value!r}: must be a whole number. Write for example 2')
    return int(value)


def _jobs(value: object) -> int:
    """Return a number of processes, or raise UsageError."""
    jobs = whole('jobs', value)
    if jobs < 1:
        raise UsageError(Argument('jobs', jobs), ': must be at least 1. Use for example 2')
    return jobs


def numbers(name: str, values: object, unit: str = '') -> list[float]:
    """Return a list of numbers, also from a text with commas, see `number`."""
    items = values.split(',') if isinstance(values, str) else values
    if not isinstance(items, Iterable):
        raise UsageError(f'{name} = {values!r}: must be a list of numbers. Write it in [ ]')
    return [number(name, item, unit) for item in items]


def number(name: str, value: object, unit: str = '') -> float:
    """Return a number, converting a text such as `5 mm` to `unit`, or raise UsageError."""
    from tauto_core.scene.units import quantity

    named = Argument(name, repr(value), spaced=True)
    if isinstance(value, str):
        return quantity(value, unit, named)
    if isinstance(value, bool) or not isinstance(value, Real):
        raise UsageError(named, ': is not a number. Write numbers')
    return float(value)


def path(name: str, value: object) -> Path:
    """Return a path, or raise UsageError."""
    if not isinstance(value, str | Path):
        raise UsageError(f'{name} = {value!r}: must be a path. Write it as text')
    return Path(value)


def _plots(plot: Files, argument: str = 'plot') -> list[Path]:
    """Return one or several picture files after checking that each can be written."""
    from tauto_core.files import check_plot

    is_one = isinstance(plot, str | Path) or not isinstance(plot, Iterable)
    files: Iterable[object] = [plot] if is_one else plot  # type: ignore[assignment]
    paths = [path(argument, file) for file in files]
    for picture in paths:
        check_plot(picture, argument)
    return paths


def _draw(files: Iterable[Path], figure: str, *of: object) -> None:
    """Write a figure of `plots.ensembles` to files."""
    for file in files:
        from tauto_core.files import write_figure
        from tauto_core.plots import ensembles

        write_figure(lambda: getattr(ensembles, figure)(*of), file)


def _range(name: str, ends: Range, unit: str = '') -> tuple[float, float]:
    """Return both bounds of a range, or raise UsageError."""
    bounds: object = ends
    if isinstance(ends, str):
        text, dots, upper = ends.partition('..')
        bounds = text or '-inf', (upper or 'inf') if dots else text
    low, high, *others = [*numbers(name, bounds, unit), math.nan, math.nan]
    if len(others) != 2 or not low <= high:
        wrong = ': must be a range from the least to the largest. Write for example 42..100'
        raise UsageError(Argument(name, ends), wrong)
    return low, high


def _origin(scene: File | Scene) -> str:
    from tauto_core.scene.loader import origin_of

    return origin_of(scene)


def _tell(words: str) -> None:
    """Issue a warning, which a command prints on stderr."""
    warnings.warn(words, TautoWarning, stacklevel=3)


def scenes() -> list[str]:
    """List the built-in scenes, for `tauto sail NAME`."""
    from tauto_core.scene import shipped_scenes

    return shipped_scenes()


def load(
    scene: File | Scene,
    *,
    duration: Quantity | None = None,
    accuracy: Quantity | None = None,
    **overrides: object,
) -> Scene:
    """Return a scene.

    Args:
        scene: a built-in name, a YAML file, or a scene already loaded.
        duration: sail this long instead [s].
        accuracy: largest error of the reading for a day of the run [s]; replaces the scene's
            solver.accuracy, solver.tolerance and ship.rate.
        overrides: values that replace the scene's, for example `seed=3` or a whole section such as
            `voyage={…}`. For a key in a section write its path with two underscores per dot:
            `ship__sea__peak_period=8.0`. None keeps the scene's value. Paths of data files are
            relative to the working directory.

    Raises:
        SceneError: all problems of the scene, with key, value and remedy.
        UsageError: no such scene, or a key that is given twice.
    """
    return _load(scene, overrides, duration=duration, accuracy=accuracy)


def _load(scene: File | Scene, overrides: Mapping[str, object], **values: object) -> Scene:
    from tauto_core.scene import load_scene

    settings = {key: value for key, value in values.items() if value is not None}
    return load_scene(scene, **_by_path({**overrides, **settings}))


def sail(
    scene: File | Scene,
    *,
    out: File | None = None,
    duration: Quantity | None = None,
    accuracy: Quantity | None = None,
    force: bool = False,
    anyway: bool = False,
    keep: bool = True,
    progress: Progress | None = None,
    **overrides: object,
) -> Voyage:
    """Sail a scene without ROS: how far wrong is the clock?

    The result has the error of the dial, the error of the ship's longitude by the clock, and the
    prize by the Act of 1714. With `out` it writes a bag, which `tauto report` turns into a page.

    Args:
        scene: as for `load`.
        out: folder of the bag, if one is to be written.
        duration: as for `load`.
        accuracy: as for `load`.
        force: replace the bag in `out`.
        anyway: sail even machines and ships larger than any known.
        keep: keep the samples for the arrays of the voyage. Without them memory does not grow with
            its length.
        progress: see above.
        overrides: as for `load`.

    Raises:
        TautoError: bad scene, no place for the bag, or an event that ends the motion.
    """
    from tauto_core import voyage

    loaded = _load(scene, overrides, duration=duration, accuracy=accuracy)
    if force and out is None:
        bag, forced = Argument('out'), Argument('force', value=True)
        raise UsageError(forced, ' replaces the bag in ', bag, '. Give ', bag, ', too')
    return voyage.sail(
        loaded,
        None if out is None else path('out', out),
        origin=_origin(scene),
        force=force,
        anyway=anyway,
        keep=keep,
        progress=progress,
        judge=True,
    )


def replay(
    bag: File,
    *,
    scene: File | Scene | None = None,
    stability: bool = False,
    keep: bool = True,
    **removed: object,
) -> Voyage:
    """Estimate drift and longitude again, from a bag alone.

    Args:
        bag: a rosbag2 folder or an .mcap file.
        scene: the scene, if the bag does not contain it.
        stability: also estimate the stability of the clock: Allan deviation and related statistics
            against averaging time, with 95 % confidence.
        keep: as for `sail`.
        removed: is refused: `smooth` and `plot` of 0.2.0.

    Returns:
        The voyage, with `stability` in its `result` on request.

    Raises:
        BagError: not a bag, no readings, or no scene.
        EstimationError: readings whose stability cannot be estimated.
    """
    from tauto_core import voyage
    from tauto_core.bags import read_bag

    for name, value in removed.items():
        _, instead = GONE.get(name, ('', ArgumentText(': is no argument of replay. See its help')))
        raise UsageError(Argument(name, value), instead)
    loaded = None if scene is None else load(scene)
    opened = read_bag(path('bag', bag))
    return voyage.replay(opened, loaded, stability=stability, keep=keep)


def check(
    scene: File | Scene,
    *,
    accuracy: Quantity | None = None,
    progress: Progress | None = None,
    **overrides: object,
) -> dict[str, Any]:
    """Check a scene without sailing it: cost, accuracy and omissions.

    Machines and ships larger than any known cause a warning. The calls that sail refuse them
    without `anyway`.

    Args:
        scene: as for `load`.
        accuracy: as for `load`.
        progress: see above.
        overrides: as for `load`.

    Returns:
        The object of `tauto scene check --json`, with the `propagator` and the `reason` for it,
        the `steady_swing` of the clock, and in `expected` time and error of the run. `left_out`
        lists
        the effects that the scene leaves out: `what` is the effect, `why` the assumption in its
        place (a sentence), `worth` its size for a clock (None: unknown) and `key` the key that
        includes it (None: no scene can).

    Raises:
        SceneError: the scene cannot be run.
        MotionDataError: its measured motion cannot be used.
    """
    loaded = _load(scene, overrides, accuracy=accuracy)
    from tauto_core.checks.facts import scene_facts

    with naming(_origin(scene), loaded.name):
        return scene_facts(loaded, progress)


def budget(
    scene: File | Scene,
    *,
    out: File | None = None,
    duration: Quantity | None = None,
    accuracy: Quantity | None = None,
    jobs: int = 2,
    anyway: bool = False,
    progress: Progress | None = None,
    **overrides: object,
) -> Budget:
    """Break a clock's rate down into its causes.

    Each cause at sea is switched off in turn, in the same waves: the motions of the ship, gravity
    that changes with latitude, heat. The effects of dial, amplitude, drag and escapement are found
    on land. The budget also gives the uncertainty of the rate from badly known numbers, and the
    effect of small changes.

    Args:
        scene: as for `load`.
        out: store it in the folder of a voyage, for its report.
        duration: as for `load`.
        accuracy: as for `load`.
        jobs: processes at once.
        anyway: as for `sail`.
        progress: see above.
        overrides: as for `load`.

    Returns:
        `rows`, one for each cause [s/day]. Their `sum` and the `interaction` make the `whole`.
        `rough` has the uncertainty from badly known numbers, and `worth` the effect of small
        changes.

    Raises:
        UsageError: a clock without a rate, arguments out of range, or `out` cannot be written.
        TautoError: a bad scene, or an event that ends the motion.
    """
    from tauto_core.ensembles.budget import account, budget_file
    from tauto_core.files import write_output

    processes = _jobs(jobs)
    loaded = _load(scene, overrides, duration=duration, accuracy=accuracy)
    place = None if out is None else budget_file(path('out', out), loaded)
    result = account(loaded, processes, progress, origin=_origin(scene), anyway=anyway)
    if place is not None:
        write_output(place, json.dumps(result.facts(), allow_nan=False, indent=1).encode())
    return result


def isochronism(
    scene: File | Scene, amplitudes: Iterable[Quantity], **overrides: object
) -> Isochronism | DescentIsochronism:
    """Find period and rate against amplitude, on land.

    The swings are free: without drag, escapement and ship. The machine has the temperature of the
    clock at the start of the scene.

    A body in a fluid also has a time of descent. Its amplitude is the arc of the release, and its
    period is the time to the turning point on the other side and back.

    Args:
        scene: as for `load`.
        amplitudes: amplitudes of the free swings [rad], such as 0.2,0.6,1. More than a turn needs
            a unit. For a body in a fluid: arcs of the release in metres. Each > 0 and within the
            cam or curve.
        overrides: as for `load`.

    Returns:
        Arrays `amplitude_rad`, `period_s` and `rate_s_per_day`. `print` shows a table. A body in a
        fluid has `amplitude_m` instead of `amplitude_rad`, `descent_s`, the time to the lowest
        point, and `half_swing_s`, the time to the other side. `keys_left_out` names the sections
        of the scene that are not used.

    Raises:
        UsageError: no amplitude, or one out of range.
        SceneError: the machine cannot be built.
    """
    from tauto_core.clockwork.trochlea import at_departure, nominal_period_s, stale_dial
    from tauto_core.machines import compile_machine, free_swings
    from tauto_core.scene.units import in_words

    loaded = _load(scene, overrides)
    values = amplitudes.split(',') if isinstance(amplitudes, str) else list(amplitudes)
    sizes = numbers('amplitudes', values, 'rad' if loaded.regulator is None else 'm')
    for value, size in zip(values, sizes, strict=True) if loaded.regulator is None else ():
        if not in_words(value) and size > math.tau:
            turns = f': {size / math.tau:.2g} turns, more than any known wheel swings. Write '
            units = f'{size:g}deg if degrees are meant, or {size:g}rad'
            raise UsageError(Argument('amplitudes', value, spaced=True), turns, units)
    with naming(_origin(scene), loaded.name):
        built = compile_machine(loaded)
        nominal_s = nominal_period_s(loaded, built)
        result = free_swings(at_departure(loaded, built), sizes, nominal_s)
    left_out, warnings = loaded.sections_besides('air', 'clock'), stale_dial(loaded, built)
    return replace(result, keys_left_out=left_out, warnings=tuple(warnings))


def cam(
    scene: File | Scene,
    *,
    csv: File | None = None,
    svg: File | None = None,
    dxf: File | None = None,
    step: File | None = None,
    stl: File | None = None,
    plate: bool = False,
    reach_rad: Quantity | None = None,
    points: int | None = None,
    thread_mm: Quantity | None = None,
    cutter_mm: Quantity | None = None,
    tolerance_mm: Quantity | None = None,
    bore_mm: Quantity | None = None,
    pins_mm: Quantity | None = None,
    pin_circle_mm: Quantity | None = None,
    slot_mm: Quantity | None = None,
    thickness_mm: Quantity | None = None,
    tool_mm: Quantity | None = None,
    lines: bool = False,
    **overrides: object,
) -> CamOutline:
    """Look at a cam's curve, draw it, or turn it into a plate.

    The frame turns with the wheel: its origin is the axle, +y points along the thread at rest. For
    a curve in a fluid the origin is the lowest point, +y points upwards, and descents begin at
    x > 0. Existing files are replaced.

    A plate has both cheeks as its edge, closed by an arc about the axle, a slot for the thread, a
    bore and two pin holes. Lengths that are left out are multiples of the distance from the cusp
    to the axle. The plate's cost in s/day is computed at several amplitudes, on land.

    `step` and `stl` need the extra `cad`. The rim of the wheel gives all three solids together, in
    brass, the moment of inertia of the scene.

    Args:
        scene: as for `load`.
        csv: write the points of the outline, of both cheeks or branches.
        svg: draw the outline or the plate to scale.
        dxf: draw it for the workshop. A plate has arcs and the path of the cutter.
        step: write wheel, cheeks and axle as solids.
        stl: folder for wheel.stl, cheeks.stl and axle.stl.
        plate: close both cheeks into a plate. Implied by solids.
        reach_rad: largest angle drawn [rad]. Default: 1.5 times the swing of the wheel, within the
            cam and before the cheeks meet.
        points: points on each cheek or branch. Default: 200, or 11 if `tauto cam` only prints.
        thread_mm: thickness of the thread [mm]. Cheeks are cut back by half. Default: 0, or 0.5
            for a plate, the width of its slot.
        cutter_mm: diameter of the cutter, or kerf [mm], 0: no path of its centre. Default: 0.25.
        tolerance_mm: greatest distance between arcs and cheeks [mm]. Default: 1e-05.
        bore_mm: diameter of the bore [mm]. Default: half the cusp.
        pins_mm: diameter of the pin holes [mm]. Default: 0.3 cusps.
        pin_circle_mm: distance of pins from the axle [mm]. Default: 0.65 cusps.
        slot_mm: depth of the slot [mm]. Default: 0.3 cusps.
        thickness_mm: thickness of the plate [mm], for solids. Default: 2.
        tool_mm: diameter of the smallest tool [mm]. Default: 1. Smaller holes are listed.
        lines: write the DXF as R12, with straight lines only, for software that reads no arcs.
            Without a tolerance they are within 1e-4 mm of the arcs.
        overrides: as for `load`.

    Returns:
        The points, the `files`, and the `plate`: in mm, with its cost in rate on land [s/day] at
        each `amplitude_rad` of its `rates`: `edge` (due to the rounded cusp), `outline` (and the
        arcs) and `one_micrometre` (both cheeks cut a micrometre too deep).

    Raises:
        UsageError: another ending, arguments out of range, a thread that the cheeks cannot guide,
            or a plate without two mirror-image cheeks or of parts that do not fit.
        SceneError: the cam cannot be built.
        TautoError: the extra is missing, or a file cannot be written.
    """
    from tauto_core.plots import cutting

    named = {'csv': csv, 'svg': svg, 'dxf': dxf, 'step': step, 'stl': stl}
    files = {name: path(name, file) for name, file in named.items() if file is not None}
    lengths = {
        'thread_mm': thread_mm,
        'cutter_mm': cutter_mm,
        'tolerance_mm': tolerance_mm,
        'bore_mm': bore_mm,
        'pins_mm': pins_mm,
        'pin_circle_mm': pin_circle_mm,
        'slot_mm': slot_mm,
        'thickness_mm': thickness_mm,
        'tool_mm': tool_mm,
    }
    sizes = {name: number(name, size, 'mm') for name, size in lengths.items() if size is not None}
    reach = None if reach_rad is None else number('reach_rad', reach_rad, 'rad')
    is_plate = plate or not files.keys().isdisjoint(('step', 'stl'))
    count = 200 if points is None else whole('points', points)
    cutting.check_cut(files, sizes, is_plate, count)
    if lines and dxf is None:
        raise UsageError(Argument('lines', value=True), ': needs ', Argument('dxf'), '. Give both')
    loaded = _load(scene, overrides)
    with naming(_origin(scene), loaded.name):
        return cutting.outline_of(loaded, files, sizes, is_plate, count, reach, lines=lines)


def design(
    *,
    period: Quantity | None = None,
    pendulum: Quantity | None = None,
    inertia: Quantity | None = None,
    disc_weight: Quantity | None = None,
    disc_radius: Quantity | None = None,
    disc_is_base: bool = False,
    pull: Quantity | None = None,
    base_radius: Quantity | None = None,
    gravity: Quantity = STANDARD_GRAVITY,
    tool_mm: Quantity = 1.0,
    file: File | None = None,
) -> WheelDesign:
    """Find the missing number in the design of a wheel and its cam.

    Of period, moment of inertia, pull and base radius three give the fourth (Euler 1727, XIX-XXI).
    A disc counts as two numbers, weight and radius. Either may be the missing one.

    Lengths are in metres and weights in newtons, or have a unit: `5 mm`, `3 N`, `300 g`, also
    `scruple`, `paris_line` and `paris_pound`. `tauto design` prints in these units.

    Args:
        period: period of a full swing [s].
        pendulum: or length of the simple pendulum that swings with it.
        inertia: the wheel's moment of inertia [kg m2].
        disc_weight: or its weight, if it is a uniform disc,
        disc_radius: and its radius.
        disc_is_base: the disc's radius is the base radius (XX).
        pull: pull in the thread, without inertia.
        base_radius: base radius of the involute, or rate of a hole.
        gravity: acceleration of gravity [m/s2].
        tool_mm: diameter of the smallest tool [mm]. Smaller holes are listed.
        file: write a scene of it to a new file, ending in .yaml.

    Returns:
        All numbers, in SI units, and `too_small`, the parts too small for the tool.

    Raises:
        UsageError: not exactly one is left out, one is given twice, a unit is not known, or a
            number is not between 1e-30 and 1e30.
        SceneError: no such machine can be sailed.
    """
    from tauto_core.machines.design import wheel_design
    from tauto_core.scene import reference
    from tauto_core.scene.units import in_words

    sizes = {
        'period': period,
        'pendulum': pendulum,
        'inertia': inertia,
        'disc_weight': disc_weight,
        'disc_radius': disc_radius,
        'pull': pull,
        'base_radius': base_radius,
    }
    result = wheel_design(
        {
            name: size
            if size is None or (isinstance(size, str) and in_words(size))
            else number(name, size)
            for name, size in sizes.items()
        },
        disc_is_base=disc_is_base,
        gravity=number('gravity', gravity, 'm/s2'),
        tool_mm=number('tool_mm', tool_mm, 'mm'),
    )
    if file is not None:
        reference.write_scene(
            str(path('file', file)), lambda name: reference.scene_of_design(result, name)
        )
    return result


def axle(
    *,
    depth: Quantity,
    gyration_radius: Quantity,
    support: str = 'plane',
    support_radius: Quantity | None = None,
    axle_radius: Quantity = 0.0,
    contact: str = 'smooth',
    friction: float | None = None,
    release_tilt: Quantity = 0.0,
    release_arc: Quantity | None = None,
    push_speed: Quantity | None = None,
    push_spin: Quantity = 0.0,
    duration: Quantity = 2.0,
    every: Quantity = 0.1,
    gravity: Quantity = STANDARD_GRAVITY,
) -> dict[str, Any]:
    """Compute the motion of a body on a cylindrical axle.

    The axle rests in a hollow, on a plane or on a convex support, or the body stands on the
    rockers of a cradle. The motion is exact from any start, until the axle lifts off. Without
    friction, Euler's case, there are two modes. An axle that rolls has one (§40).

    Args:
        depth: c: depth of the centre of gravity below the centre of axle or rockers [m].
        gyration_radius: k: radius of gyration about the centre of gravity [m].
        support: concave, plane, convex or cradle.
        support_radius: radius of the support [m]. Default: plane.
        axle_radius: radius of the axle, or of the rockers [m].
        contact: smooth, rolling or coulomb.
        friction: coefficient of friction, with coulomb.
        release_tilt: tilt of the body at the start [rad].
        release_arc: arc of a smooth axle's centre at the start [m]. Default: regular motion.
        push_speed: n: speed of the centre of gravity at the start [m/s] (§4).
        push_spin: ν: angular velocity at the start [rad/s] (§4).
        duration: length of the motion [s].
        every: a row for each of these intervals [s].
        gravity: acceleration of gravity [m/s2].

    Returns:
        Lengths and periods of small swings, with units in their names, and `rows` of the motion.

    Raises:
        UsageError: no such body, one that stays at rest, or arguments out of range.
    """
    from tauto_core.studies import axle_motion

    sizes = {
        'support_radius': (support_radius, 'm'),
        'axle_radius': (axle_radius, 'm'),
        'depth': (depth, 'm'),
        'gyration_radius': (gyration_radius, 'm'),
        'release_tilt': (release_tilt, 'rad'),
        'release_arc': (release_arc, 'm'),
        'push_speed': (push_speed, 'm/s'),
        'push_spin': (push_spin, 'rad/s'),
    }
    keys = {
        name: None if size is None else number(name, size, unit)
        for name, (size, unit) in sizes.items()
    }
    return axle_motion(
        {'support': support, 'contact': contact, 'friction': friction, **keys},
        number('gravity', gravity, 'm/s2'),
        number('duration', duration, 's'),
        number('every', every, 's'),
    )


def altitudes(
    *,
    altitudes_deg: Iterable[Quantity],
    times: Iterable[Quantity],
    latitude_deg: Quantity,
    rate: Quantity = 0.0,
    body: Literal['star', 'sun'] = 'star',
) -> dict[str, Any]:
    """Find latitude and culmination from three altitudes by a ship's clock.

    Daniel Bernoulli's problem of 1729: the altitudes of one star and the two intervals between
    them give latitude, declination and culmination. The answer includes the effects of errors of
    the clock and of each altitude. The ship is at rest, and the altitudes are true.

    Args:
        altitudes_deg: three altitudes [deg], such as 20,35,41.
        times: their times by the clock [s].
        latitude_deg: latitude by account [deg], to select one of several solutions.
        rate: known gain of the clock, which is corrected for [s/day].
        body: star or (mean) sun.

    Returns:
        `latitude_deg`, `declination_deg`, `culmination_s` by the clock, `highest_deg` there, and
        their `errors` if the clock gains 1 s/day more than `rate`, and if one altitude is taken 1'
        too high.

    Raises:
        UsageError: arguments out of range, or altitudes that no place has.
    """
    from tauto_core.studies import three_altitudes

    heights, when = numbers('altitudes_deg', altitudes_deg, 'deg'), numbers('times', times, 's')
    account, gain = number('latitude_deg', latitude_deg, 'deg'), number('rate', rate, 's/day')
    return three_altitudes(heights, when, account, gain, body)


def hull(
    *,
    shape: str | None = None,
    mesh: File | None = None,
    length: Quantity | None = None,
    beam: Quantity | None = None,
    draught: Quantity | None = None,
    block: float | None = None,
    roll_period: Quantity | None = None,
    roll_damping: float = 0.08,
    speed: Quantity = 0.0,
    out: File | None = None,
    plot: Files = (),
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Find how a hull moves in waves, and its cost to a clock.

    The cost is given by heading and place. The flow is computed by boundary elements (capytaine,
    the extra `hull`). A built-in shape needs no extra, and `length` scales it. `plot` draws the
    response amplitude operators: all six motions against the period of the waves.

    Args:
        shape: a built-in shape: sloop, deptford, ketch, yacht.
        mesh: or a mesh: x forward, z up from the waterline, in metres.
        length: or a parametric form: length of the waterline [m],
        beam: its beam [m],
        draught: its draught without keel [m]
        block: and block coefficient.
        roll_period: natural period of the roll [s]. Default: 3.1 √beam.
        roll_damping: damping ratio of the roll, without radiated waves.
        speed: speed of the ship [m/s].
        out: write the coefficients (.npz), replacing the file.
        plot: draw it as .svg, .png or .pdf, replacing the file.
        progress: see above.

    Returns:
        The object of `tauto hull --json`: the `hull`, the `ship`, its `operators`, the `sea` and
        `rates_s_per_day` of a clock by heading and place.

    Raises:
        UsageError: no hull, several hulls, or arguments out of range.
        TautoError: the extra is missing, or a file cannot be read or written.
    """
    from tauto_core.studies import hull_in_waves

    lengths = {'length': length, 'beam': beam, 'draught': draught}
    sizes = {
        name: None if size is None else number(name, size, 'm') for name, size in lengths.items()
    }
    return hull_in_waves(
        shape,
        None if mesh is None else path('mesh', mesh),
        {**sizes, 'block': None if block is None else number('block', block)},
        roll_period=None if roll_period is None else number('roll_period', roll_period, 's'),
        roll_damping=number('roll_damping', roll_damping),
        speed=number('speed', speed, 'm/s'),
        out=None if out is None else path('out', out),
        plots=_plots(plot),
        progress=progress,
    )


def logbook(
    log: File,
    *,
    passage: str | None = None,
    scene: File | Scene = 'portsmouth_jamaica',
    harbour_days: Quantity = 14.0,
    winds: File | None = None,
    out: File | None = None,
    plot: Files = (),
    progress: Progress | None = None,
) -> list[dict[str, Any]] | str:
    """List the passages of a log-book, or write a scene of one.

    The list includes doubtful entries and, for a passage that cannot be sailed, row and reason.
    `plot` draws the tracks on a map.

    Args:
        log: log-book: our columns, CLIWOC, or a track in GPX.
        passage: write a scene that sails this passage.
        scene: scene with the machine, ship and navigator.
        harbour_days: days in harbour before the first entry [d].
        winds: for a track: CSV of utc, wind_from_deg, wind_mps.
        out: file of the scene. Default: print it.
        plot: draw it as .svg, .png or .pdf, replacing the file.
        progress: see above.

    Returns:
        The `passages` of `tauto logbook --json`, or with `passage` the scene as YAML.

    Raises:
        UsageError: no such file or passage, or arguments that do not go together.
        SceneError: a passage that cannot be sailed.
    """
    from tauto_core.scene.tables import missing_file
    from tauto_core.ship.logbook import passage_facts, read_passages

    files = {'log': log, 'winds': winds}
    named = {name: str(path(name, file)) for name, file in files.items() if file is not None}
    for file in named.values():
        for fault in missing_file('FILE', file, folders=True):
            raise UsageError(f'{file}: {fault.problem}. {fault.remedy}')
    drawn, wind = _plots(plot), named.get('winds')
    if passage is not None:
        if drawn:
            remedy = ': draws all passages. Leave out it or ', Argument('passage')
            raise UsageError(Argument('plot', drawn[0]), *remedy)
        days = number('harbour_days', harbour_days, 'd')
        return _scene_of_passage(named['log'], passage, scene, days, wind, out)
    if out is not None:
        is_scene = ': is the file of a scene. Name a passage with ', Argument('passage')
        raise UsageError(Argument('out', out), *is_scene)
    rows, passages = [], []
    for record in read_passages(named['log'], winds=wind, progress=progress):
        rows.append(passage_facts(record))
        if drawn:  # only a map needs all entries at once
            passages.append(record)
    if passages:
        _draw(drawn, 'passages_figure', passages)
    return rows


def _scene_of_passage(
    log: str, name: str, scene: File | Scene, days: float, winds: str | None, out: File | None
) -> str:
    """Return the checked scene of a passage, and write it to a file."""
    from tauto_core.files import check_place, write_whole
    from tauto_core.scene.loader import parse_scene, scene_yaml, write_mapping
    from tauto_core.ship.logbook import scene_of_passage, sound_passage

    if out is not None:
        if not str(out).endswith(('.yaml', '.yml')):
            raise UsageError(Argument('out', out), ': must end in .yaml. Name another file')
        check_place(path('out', out), 'out')
    record = sound_passage(log, name, winds=winds)
    content = load(scene).model_dump(mode='json', exclude_none=True)
    text = scene_yaml(parse_scene(write_mapping(scene_of_passage(content, record, days)), name))
    if out is not None:
        write_whole(Path(out), text.encode())
    return text


def claims(*, site: File | None = None) -> list[Claim]:
    """Check the claims of Euler's papers by computation.

    The exit code is 1 if a claim that should hold fails, or one that should fail holds.

    Args:
        site: folder for an interactive page for each paper, *.html, in place of the list.

    Returns:
        Every claim of the three papers, each checked against a computed value.
    """
    from tauto_core.euler.site import all_claims, write_site

    results = all_claims()
    if site is not None:
        write_site(path('site', site), results)
    return results


def new_scene(
    file: File | None = None,
    *,
    ship: str | None = None,
    cam: str | None = None,
    thread: str | None = None,
    power: str | None = None,
    escapement: str | None = None,
) -> str:
    """Write a scene that sails, with the unit and meaning of every key.

    Kinds that are left out are chosen to fit. The default is Euler's involute under a weight, in a
    wind sea, without an escapement.

    Args:
        file: a new file, ending in .yaml. Default: standard output.
        ship: kind of the ship's motion.
        cam: kind of the cam. The refusal of an unknown one, such as `x`, lists them.
        thread: kind of the thread.
        power: kind of the power.
        escapement: kind of the escapement.

    Returns:
        The scene as YAML.

    Raises:
        UsageError: an unknown kind, incompatible kinds, or a file that cannot be written.
    """
    from tauto_core.scene import reference

    parts = {'ship': ship, 'cam': cam, 'thread': thread, 'power': power, 'escapement': escapement}
    if file is not None:
        path('file', file)
    kinds = {key: kind for key, kind in parts.items() if kind is not None}
    return reference.write_scene(
        None if file is None else str(file), lambda name: reference.new_scene(name, kinds)
    )


def check_bag(bag: File) -> BagReport:
    """Read all of a bag and report its faults.

    The check covers the ends of its files, checksums, indices, metadata.yaml, payloads, the order
    of the log times, and whether the recording was cut short or has holes. The exit code is 1 if
    it is not whole.

    Args:
        bag: a rosbag2 folder or an .mcap file.

    Returns:
        Its `damage`, which `recover_bag` can repair, `faults` of its contents, `marks` of losses
        that its metadata state, and harmless `notes`, each a list of sentences. `whole` is true
        without the first three.

    Raises:
        BagError: there is no bag.
    """
    from tauto_core import bags

    return bags.check_bag(path('bag', bag))


def recover_bag(bag: File, out: File | None = None) -> Recovered:
    """Write the readable part of a damaged bag as a new bag.

    The old bag is not changed. The metadata of the new bag state which messages were lost.

    Args:
        bag: a rosbag2 folder or an .mcap file.
        out: folder of the new bag, which must not exist. Default: BAG_recovered.

    Returns:
        The new bag's `path`, `counts` of messages by topic, and descriptions of losses (`lost`).

    Raises:
        BagError: the bag is whole, no message can be read, or the folder cannot be written.
    """
    from tauto_core import bags

    return bags.recover_bag(path('bag', bag), None if out is None else path('out', out))


def compare(
    *clocks: File | Scene | Sequence[File | Scene],
    ship_of: File | Scene | None = None,
    duration: Quantity | None = None,
    accuracy: Quantity | None = None,
    roll_deg: Sequence[Quantity] = (),
    suspension: Literal['both', 'with', 'without'] = 'both',
    jobs: int = 2,
    plot: Files = (),
    anyway: bool = False,
    progress: Progress | None = None,
    **overrides: object,
) -> Comparison:
    """Sail several clocks through the same sea, side by side.

    Which of them finds the longitude? The column `dial` is the longitude by the dial alone. The
    dials of the built-in clocks are regulated on land. The column `rated` corrects for the rate
    observed in port, in the same sea.

    Args:
        clocks: files or built-in names with different `name`s, or one list of them. Default: the
            built-in clocks.
        ship_of: send all clocks on the passage of this scene: ship, voyage, …
        duration: as for `load`.
        accuracy: as for `load`.
        roll_deg: significant amplitudes of the roll [deg], twice its root mean square. Heave and
            waves are unchanged.
        suspension: cases suspended as in the scenes, or fixed to the ship.
        jobs: processes at once.
        plot: draw it as .svg, .png or .pdf, replacing the file.
        anyway: as for `sail`.
        progress: see above.
        overrides: as for `load`, for every clock. Keys of the passage (ship, voyage, seed, …)
            apply to `ship_of` if given.

    Returns:
        `rows`, one for each clock, two if its case is suspended.

    Raises:
        TautoError: clocks that cannot be compared, or arguments out of range.
    """
    from tauto_core.ensembles import comparison

    if suspension not in ('both', 'with', 'without'):
        raise UsageError(
            f"suspension = {suspension!r}: must be 'both', 'with' or 'without'. Choose one"
        )
    drawn = _plots(plot)
    listed = clocks[0] if len(clocks) == 1 else clocks
    several = isinstance(listed, Sequence) and not isinstance(listed, str)
    entries = comparison.make_entries(
        cast('Sequence[File | Scene]', listed if several else clocks),
        ship_of=ship_of,
        duration=None if duration is None else number('duration', duration, 's'),
        accuracy=None if accuracy is None else number('accuracy', accuracy, 's'),
        rolls_deg=numbers('roll_deg', roll_deg, 'deg'),
        cases=suspension,
        anyway=anyway,
        overrides=_by_path(overrides),
    )
    result = comparison.compare(entries, jobs=_jobs(jobs), progress=progress)
    _draw(drawn, 'comparison_figure', result)
    return result


def fleet(
    scene: File | Scene,
    *,
    ships: int = 100,
    vary: File | Mapping[str, Mapping[str, object]] | None = None,
    duration: Quantity | None = None,
    accuracy: Quantity | None = None,
    jobs: int = 2,
    out: File | None = None,
    plot: Files = (),
    anyway: bool = False,
    progress: Counting | None = None,
    **overrides: object,
) -> Fleet:
    """Send many ships on one voyage: how many find the longitude?

    Each ship has a different seed: other observations, clock noise and, if ship.kind is sea,
    waves. `vary` draws further keys. With a log-book each ship sails one of its passages (`trial`,
    on the command line --logs).

    Args:
        scene: as for `load`.
        ships: number of ships.
        vary: YAML: keys of the scene with their distributions, drawn for every ship.
        duration: as for `load`.
        accuracy: as for `load`.
        jobs: as for `budget`.
        out: folder for ships.parquet, with a row for each ship; existing rows are not sailed
            again.
        plot: draw it as .svg, .png or .pdf, replacing the file.
        anyway: as for `sail`.
        progress: called with the number of ships done, with fractions, and of all.
        overrides: as for `load`.

    Returns:
        `rows`, a mapping for each ship, and `answers`, the statistics of the fleet. `vary` also
        takes a mapping: `{'trochlea.cam.base_radius': {'kind': 'normal', 'sigma': 2e-5}}`.

    Raises:
        TautoError: a drawn value that the scene does not allow, arguments out of range, or
            processes that cannot be started.
    """
    from tauto_core.ensembles import fleets

    drawn, processes = _plots(plot), _jobs(jobs)
    loaded = _load(scene, overrides, duration=duration, accuracy=accuracy)
    if isinstance(vary, str | Path):
        draws, drawn_by = fleets.read_draws(Path(vary), loaded), str(vary)
    else:
        if vary is not None and not isinstance(vary, Mapping):
            raise UsageError(f'vary = {vary!r}: must be a mapping of keys, or a file. Write {{…}}')
        draws, drawn_by = fleets.as_draws(dict(vary or {}), 'vary', loaded), 'vary'
    count, where = whole('ships', ships), None if out is None else path('out', out)
    plan = fleets.Plan(loaded, _origin(scene), count, draws, drawn_by, anyway)
    if not (loaded.ship.is_random or draws):
        alike = f'all ships meet the same motion, since ship.kind is {loaded.ship.kind}. Let '
        draw = ' draw a key of the machine or the ship'
        _tell(ArgumentText(alike, Argument('vary'), draw))
    report = None if progress is None else lambda done: progress(done, count)
    result = fleets.sail_fleet(plan, processes, where, report)
    _draw(drawn, 'fleet_figure', result)
    return result


def trial(
    scene: File | Scene,
    logs: File,
    *,
    compare: Sequence[File | Scene] = (),
    days: Range = '42..',
    years: Range | None = None,
    sample: int | None = None,
    harbour_days: Quantity = 14.0,
    duration: Quantity | None = None,
    accuracy: Quantity | None = None,
    jobs: int = 2,
    out: File | None = None,
    skip_wrong: bool = False,
    plot: Files = (),
    anyway: bool = False,
    progress: Counting | None = None,
    **overrides: object,
) -> TrialAnswers:
    """Send clocks along the passages of a log-book: where would they have found the longitude?

    The ship of `scene` sails every passage in the sea of its wind.

    Args:
        scene: as for `load`. Its clock is the first.
        logs: sail the passages of this log-book, a file or a folder, each in its wind.
        compare: further clocks in the same sea, fixed to the ship. `clocks`: the built-in ones.
        days: length of the passages [d].
        years: years of the first entry.
        sample: this many of them, evenly over the list.
        harbour_days: days of rating before each [d].
        duration: cut a voyage at this time from its start [s].
        accuracy: as for `load`.
        jobs: as for `fleet`.
        out: as for `fleet`, with a row for each clock on each passage.
        skip_wrong: leave out passages with a wrong row, or without a wind.
        plot: as for `fleet`: the map of all tracks.
        anyway: as for `sail`.
        progress: as for `fleet`, of voyages. While the log is read: the share done and 0.
        overrides: as for `load`.

    Returns:
        The object of `tauto fleet --logs --json`: for each of `clocks`, by the `ways` of finding
        the longitude, `prizes` and errors; `voyages`, one for each clock and passage;
        `keys_left_out`, the keys of the scene that the log replaces.

    Raises:
        TautoError: a log-book that cannot be read or has no such passages, a passage with a wrong
            row, or arguments out of range.
    """
    from tauto_core.ensembles import trials

    logbook, drawn = str(path('logs', logs)), _plots(plot)
    processes = _jobs(jobs)
    if isinstance(compare, str):
        raise UsageError(f'compare = {compare!r}: must be a list of scenes. Write it in [ ]')
    of_days = _range('days', days, 'd')
    of_years = (-math.inf, math.inf) if years is None else _range('years', years)
    size = None if sample is None else whole('sample', sample)
    loaded, origin = _load(scene, overrides, accuracy=accuracy), _origin(scene)
    trial = trials.make_trial(
        logbook,
        [(origin, loaded), *trials.clocks_beside(loaded, origin, compare)],
        days=of_days,
        years=of_years,
        sample=size,
        progress=None if progress is None else lambda share: progress(share, 0),
        harbour_days=number('harbour_days', harbour_days, 'd'),
        longest_s=None if duration is None else number('duration', duration, 's'),
        skip_wrong=skip_wrong,
        anyway=anyway,
    )
    for _, why in trial.left_out:
        _tell(f'left out: {why}')
    for clock in trial.clocks:
        if clock.why_unsensed:
            _tell(f'{clock.name}: is not tried with thermometer and IMU: {clock.why_unsensed}')
    where = None if out is None else path('out', out)
    count = len(trial.passages) * len(trial.clocks)
    report = None if progress is None else lambda done: progress(done, count)
    rows = trials.sail_trial(trial, processes, where, report)
    answers = replace(trials.answers_of(trial, rows), keys_left_out=trials.replaced_by_log(loaded))
    _draw(drawn, 'trial_figure', trial, rows, answers)
    return answers


def plot(
    source: File | Scene | Voyage,
    what: str,
    file: File | None = None,
    *,
    from_s: Quantity | None = None,
    to_s: Quantity | None = None,
    duration: Quantity | None = None,
    accuracy: Quantity | None = None,
    anyway: bool = False,
    progress: Progress | None = None,
    **overrides: object,
) -> Figure:
    """Draw one picture of a bag or a scene.

    Pictures of weather, cam and machine are drawn without sailing the scene.

    Args:
        source: a bag, or a scene, which is sailed.
        what: error, rate, drift, longitude, stability, amplitude, phase, weather, temperature,
            roll, spectrum, map, cam or machine.
        file: ending in .svg, .png or .pdf, which is replaced. `tauto plot` writes NAME_WHAT.svg
            without it.
        from_s: begin roll or spectrum here, from the first reading [s], also `36 h`. Default: the
            roughest ten minutes.
        to_s: end it here [s]. Default: ten minutes after the beginning.
        duration: as for `load`.
        accuracy: as for `load`.
        anyway: as for `sail`.
        progress: see above.
        overrides: as for `load`.

    Returns:
        The picture, written only if a file is named. The source may be a voyage.

    Raises:
        UsageError: no such picture, another format, or a part outside the voyage.
        TautoError: the source cannot be read or sailed.
    """
    from tauto_core.plots.contents import OF_A_SCENE, check_picture

    from_s, to_s = (
        None if at is None else number(name, at, 's')
        for name, at in (('from_s', from_s), ('to_s', to_s))
    )
    part = from_s is not None or to_s is not None
    check_picture(what, None if file is None else path('file', file), part=part)
    values = {**overrides, 'duration': duration, 'accuracy': accuracy}
    voyage = voyage_of(source, values, progress, anyway=anyway, sails=what not in OF_A_SCENE)
    return voyage.plot(what, file, from_s=from_s, to_s=to_s)


def report(
    source: File | Scene | Voyage,
    file: File,
    *,
    duration: Quantity | None = None,
    accuracy: Quantity | None = None,
    anyway: bool = False,
    progress: Progress | None = None,
    **overrides: object,
) -> None:
    """Write a voyage as one page: answer, map, ship, charts.

    Args:
        source: as for `plot`.
        file: ending in .html, which is replaced. `tauto report` writes NAME.html without it.
        duration: as for `load`.
        accuracy: as for `load`.
        anyway: as for `sail`.
        progress: see above.
        overrides: as for `load`.

    Raises:
        UsageError: another suffix, or a folder that does not exist.
        TautoError: the source cannot be read or sailed.
    """
    from tauto_core.plots.page import check_report, write_report

    page = path('file', file)
    check_report(page)
    values = {**overrides, 'duration': duration, 'accuracy': accuracy}
    voyage = voyage_of(source, values, progress, anyway=anyway)
    stated = {key.replace('.', '__'): value for key, value in values.items() if value is not None}
    settings = ''.join(f', {key}={value!r}' for key, value in stated.items())
    write_report(voyage, page, f'tauto.report({voyage.scene.name!r}, {str(file)!r}{settings})')


def _by_path(overrides: Mapping[str, object]) -> dict[str, object]:
    """Return values by the paths of their keys: `ship__rate` is `ship.rate`.

    Times may have a unit. `accuracy` [s] becomes `solver.accuracy` [s/day].
    """
    from tauto_core.scene import Scene

    for key in GONE.keys() & overrides.keys():
        raise UsageError(Argument(key, overrides[key]), GONE[key][1])
    values: dict[str, object] = {}
    for key, value in overrides.items():
        path_of_key = key.replace('__', '.')
        section, _, tail = path_of_key.partition('_')
        if section in Scene.model_fields and path_of_key not in Scene.model_fields:
            raise UsageError(f'{key}: is not a key of a scene. Write {section}__{tail}')
        is_time = key in ('duration', 'accuracy') and value not in (None, ABSENT)
        if key == 'accuracy' and is_time:
            path_of_key = 'solver.accuracy'
        if path_of_key in values:
            raise UsageError(f'{key}: {path_of_key} is given twice. Leave one out')
        values[path_of_key] = number(key, value, 's') if is_time else value
    return values


def voyage_of(
    source: File | Scene | Voyage,
    given: Mapping[str, object],
    progress: Progress | None,
    *,
    anyway: bool,
    sails: bool = True,
) -> Voyage:
    """Return a voyage, the voyage in a bag, or the voyage of a scene, empty unless it `sails`.

    `given` are values of a scene. With a bag or a voyage they are a UsageError.
    """
    from tauto_core.voyage import Voyage
    from tauto_core.voyage import sail as sail_scene

    settings = {key: value for key, value in given.items() if value is not None}
    bag = None if isinstance(source, Voyage) or not is_bag(source) else source
    if settings and (bag is not None or isinstance(source, Voyage)):
        raise UsageError(
            f'{", ".join(settings)}: applies to a scene, not to a bag or voyage. Leave it out'
        )
    if isinstance(source, Voyage):
        return source
    if bag is not None:
        voyage = replay(bag)
        for warning in voyage.result['warnings']:
            _tell(warning)
        return voyage
    loaded = _load(source, settings)
    if sails:
        return sail_scene(loaded, origin=_origin(source), anyway=anyway, progress=progress)
    return Voyage(loaded, {}, {})


def is_bag(source: object) -> TypeGuard[File]:
    """Return whether `source` is a path to a bag rather than a scene."""
    return (
        isinstance(source, str | Path)
        and str(source) not in scenes()
        and (Path(source).is_dir() or Path(source).suffix == '.mcap')
    )
