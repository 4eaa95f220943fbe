"""The commands as functions, for scripts and notebooks; arguments are checked first.

Errors are those of the command line, which spells the names of arguments as options. A number
with a unit may be a text that has another: `reach_rad='60 deg'`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from tauto_core.scene import Scene, load_scene, shipped_scenes
from tauto_core.scene.errors import UsageError, naming
from tauto_core.scene.loader import origin_of
from tauto_core.scene.times import STANDARD_GRAVITY
from tauto_core.scene.units import in_words, quantity
from tauto_core.voyage import Voyage
from tauto_core.voyage import replay as replay_bag
from tauto_core.voyage import sail as sail_scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tauto_core.bags import Recovered, Soundness
    from tauto_core.ensembles.budget import Budget
    from tauto_core.ensembles.comparison import Comparison
    from tauto_core.ensembles.fleets import Fleet
    from tauto_core.ensembles.trial_answers import TrialAnswers
    from tauto_core.euler import Claim
    from tauto_core.machines import Isochronism
    from tauto_core.machines.design import WheelDesign
    from tauto_core.machines.fluid_pendulum import DescentIsochronism
    from tauto_core.plots.cutting import CamOutline, ScenePlate


Quantity: TypeAlias = float | str
"""A number in the unit of the argument, or a text of a number and a unit, such as `5 mm`."""

# -----------------------------------------------------------------------------
# Arguments of Python calls: their types, checked before anything runs.


def whole(name: str, value: object) -> int:
    """Return a whole number, of NumPy too; UsageError for anything else."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise UsageError(f'{name} = {value!r}: must be a whole number. Write for example 2')
    return int(value)


def numbers(name: str, values: object, unit: str | None = None) -> list[float]:
    """Return a list of numbers, of NumPy too; UsageError for anything else.

    With a unit they are in it, or texts such as `5 mm`.
    """
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise UsageError(f'{name} = {values!r}: must be a list of numbers. Write it in [ ]')
    return [number(name, each, unit) for each in values]


def number(name: str, value: object, unit: str | None = None) -> float:
    """Return a number, as `numbers` returns several."""
    if isinstance(value, str) and unit is not None and in_words(value):
        return quantity(value, unit, f'{name} = {value!r}')
    if isinstance(value, bool) or not isinstance(value, Real):
        raise UsageError(f'{name}: {value!r} is not a number. Write numbers')
    return float(value)


def path(name: str, value: object) -> Path:
    """Return a path; UsageError where it is neither a string nor a path."""
    if not isinstance(value, str | Path):
        raise UsageError(f'{name} = {value!r}: must be a path. Write it as text')
    return Path(value)


def scenes() -> list[str]:
    """Return the names of the built-in scenes."""
    return shipped_scenes()


def load(scene: str | Path | Scene, **overrides: object) -> Scene:
    """Return a scene.

    Args:
        scene: a built-in name, a YAML file, or a scene already loaded.
        overrides: values in place of the scene's own, for example `duration=300.0` or a whole
            section such as `voyage={…}`. A key in a section is named by its path, with two
            underscores in place of each dot: `ship__sea__peak_period=8.0`. None keeps the
            scene's value. Data paths among them are relative to the working directory.

    Raises:
        SceneError: all problems of the scene, with key, value and remedy.
        UsageError: a scene that is none of these, or a key that is given twice.
    """
    return load_scene(scene, **_by_path(overrides))


def sail(scene: str | Path | Scene, *, anyway: bool = False, **overrides: object) -> Voyage:
    """Return the voyage of a scene, sailed offline.

    Args:
        scene: as for `load`.
        anyway: sail even machines and ships larger than any known.
        overrides: as for `load`.

    Raises:
        TautoError: bad scene, or an event that ends the motion.
    """
    loaded = load(scene, **overrides)
    return sail_scene(loaded, origin=origin_of(scene), anyway=anyway, judge=True)


def replay(
    bag: str | Path,
    *,
    scene: str | Path | Scene | None = None,
    stability: bool = False,
) -> Voyage:
    """Return the voyage in a bag, with drift and longitude estimated again.

    Args:
        bag: rosbag2 folder or MCAP file.
        scene: replaces the scene in the bag, and is needed where there is none.
        stability: also estimate the stability of the clock, Allan's deviation and its kin with
            95 % confidence; it is `result['stability']`.

    Raises:
        BagError: not a bag, no readings, or no scene.
        EstimationError: readings whose stability cannot be estimated.
    """
    loaded = None if scene is None else load(scene)
    from tauto_core.bags import read_bag

    opened = read_bag(path('bag', bag))
    return replay_bag(opened, loaded, stability=stability)


def check(scene: str | Path | Scene, **overrides: object) -> dict[str, Any]:
    """Check a scene without sailing it, and return its facts.

    A machine or ship larger than any known is among the `warnings` here; `sail` refuses it
    without `anyway=True`.

    Args:
        scene: as for `load`.
        overrides: as for `load`.

    Returns:
        The object of `tauto scene check --json`. Among others it has the `propagator` and the
        `reason` for it, the `steady_swing` in which the clock settles, and in `expected` time and
        error of the run. `left_out` lists the effects that the scene leaves out: `what` is the
        effect, `why` the assumption in its place (a sentence), `worth` its size for a clock (None
        where no figure is known) and `key` the key that includes it (None where no scene can).

    Raises:
        SceneError: the scene cannot be run.
        MotionDataError: its measured motion cannot be used.
    """
    from tauto_core.checks.facts import scene_facts

    loaded = load(scene, **overrides)
    with naming(origin_of(scene), loaded.name):
        return scene_facts(loaded)


def budget(
    scene: str | Path | Scene,
    *,
    jobs: int = 2,
    out: str | Path | None = None,
    anyway: bool = False,
    **overrides: object,
) -> Budget:
    """Return the causes of the rate of a scene's clock.

    Each cause at sea is switched off in turn: the motions of the ship, gravity that changes, heat.
    Dial, amplitude, drag and escapement are found on land.

    Args:
        scene: as for `load`.
        jobs: number of parallel processes.
        out: file for the budget, ending in .json; or the folder of the scene's voyage, whose
            `report` then shows it.
        anyway: sail even machines and ships larger than any known.
        overrides: as for `load`.

    Returns:
        `rows`, one for each cause [s/day]; their `sum` and the `interaction` make the `whole`.
        `rough` has the uncertainty of the rate by badly known numbers, and `worth` the effect of
        small changes.

    Raises:
        UsageError: a clock without a rate, arguments out of range, or an `out` that cannot be
            written.
        TautoError: a bad scene, or an event that ends the motion.
    """
    from tauto_core.ensembles.budget import account, budget_file
    from tauto_core.ensembles.workers import Crew

    loaded = load(scene, **overrides)
    place = None if out is None else budget_file(path('out', out), loaded)
    found = account(loaded, Crew(whole('jobs', jobs)), origin=origin_of(scene), anyway=anyway)
    if place is not None:
        found.write(place)
    return found


def isochronism(
    scene: str | Path | Scene, amplitudes: Iterable[Quantity], **overrides: object
) -> Isochronism | DescentIsochronism:
    """Return period and rate of free swings at several amplitudes.

    The swings are on land, without drag and escapement. `print` shows the result as a table.

    Args:
        scene: as for `load`.
        amplitudes: amplitudes of the swings [rad]; of a body in a fluid the arcs of the release
            [m]. Each > 0 and within the cam, or the curve.
        overrides: as for `load`.

    Returns:
        Arrays `amplitude_rad`, `period_s` and `rate_s_per_day`. A body in a fluid has
        `amplitude_m` in place of the first, and also `descent_s`, the time to the lowest point,
        and `half_swing_s`, the time to the other side; its period is the time there and back.

    Raises:
        UsageError: no amplitude, or one out of range.
        SceneError: the machine cannot be built.
    """
    from tauto_core.machines import free_swings

    loaded = load(scene, **overrides)
    asked = numbers('amplitudes', amplitudes, 'rad' if loaded.regulator is None else 'm')
    with naming(origin_of(scene), loaded.name):
        return free_swings(loaded, asked, loaded.clock.nominal_period)


def cam(
    scene: str | Path | Scene,
    *,
    csv: str | Path | None = None,
    svg: str | Path | None = None,
    dxf: str | Path | None = None,
    template: str | Path | None = None,
    step: str | Path | None = None,
    stl: str | Path | None = None,
    plate: bool = False,
    points: int = 200,
    reach_rad: Quantity | None = None,
    thread_mm: Quantity | None = None,
    cutter_mm: Quantity | None = None,
    tolerance_mm: Quantity | None = None,
    bore_mm: Quantity | None = None,
    pins_mm: Quantity | None = None,
    pin_circle_mm: Quantity | None = None,
    slot_mm: Quantity | None = None,
    thickness_mm: Quantity | None = None,
    **overrides: object,
) -> CamOutline:
    """Return the curve of a scene's cam, and write it for the workshop, in millimetres.

    A curve in a fluid and the uneven cheeks of a lever are returned and written, too. A plate has
    both cheeks as its edge, closed by an arc about the axle, with a slot for the thread, a bore
    and two pin holes. Its lengths that are left out are multiples of the distance from the cusp to
    the axle. Existing files are replaced.

    Args:
        scene: as for `load`.
        csv: name of a file for the points of both cheeks or branches.
        svg: name of a file, ending in .svg: a drawing to scale, of the plate if there is one.
        dxf: name of a file, ending in .dxf: the same for the machine; of a plate its arcs and the
            path of the cutter.
        template: name of a file, ending in .svg: the plate to scale on a sheet of A4. Of a larger
            plate it is the plan of several sheets beside it.
        step: name of a file, ending in .step: wheel, cheeks and axle as solids (extra `cad`).
        stl: a folder, for wheel.stl, cheeks.stl and axle.stl (extra `cad`).
        plate: make a plate; `template`, `step` and `stl` do, too.
        points: number of points on each cheek or branch, 2 to 1,000,000.
        reach_rad: angle at which the cheeks end [rad]. None: one and a half times the amplitude of
            the wheel, but within the cam and before its two cheeks meet.
        thread_mm: thickness of the thread [mm], 0 to 100; the cheeks are cut back by half of it.
            None: 0; of a plate 0.5, the width of its slot.
        cutter_mm: diameter of the cutter, or kerf [mm]; 0: without the path of its centre. None:
            0.25.
        tolerance_mm: greatest distance between arcs and cheeks [mm]. None: 1e-5.
        bore_mm: diameter of the bore [mm]; None: half the distance from the cusp to the axle.
        pins_mm: diameter of the pin holes [mm]; None: 0.3 of that distance.
        pin_circle_mm: distance of the pins from the axle [mm]; None: 0.65 of that distance.
        slot_mm: depth of the slot [mm]; None: 0.3 of that distance.
        thickness_mm: thickness of the plate [mm], for `step` and `stl`. None: 2.
        overrides: as for `load`.

    Returns:
        The points, the `files`, and the `plate`: in mm, with its cost in rate on land [s/day], the
        arrays `edge` (by the rounded cusp), `outline` (by the arcs as well) and `one_micrometre`
        (both cheeks cut a micrometre too deep) at each `amplitude_rad` of its `rates`.

    Raises:
        UsageError: another ending, arguments out of range, a thread that the cheeks cannot guide,
            or a plate without two mirror-image cheeks or of parts that do not fit.
        SceneError: the cam cannot be built.
        TautoError: the extra is missing, or a file cannot be written.
    """
    from tauto_core.plots import cutting

    named = {'csv': csv, 'svg': svg, 'dxf': dxf, 'template': template, 'step': step, 'stl': stl}
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
    }
    sizes = {name: number(name, size, 'mm') for name, size in lengths.items() if size is not None}
    reach = None if reach_rad is None else number('reach_rad', reach_rad, 'rad')
    is_plate = plate or not files.keys().isdisjoint(('template', 'step', 'stl'))
    count = whole('points', points)
    cutting.check_cut(files, sizes, is_plate, count)
    loaded = load(scene, **overrides)
    with naming(origin_of(scene), loaded.name):
        return cutting.outline_of(loaded, files, sizes, is_plate, count, reach)


def cut(scene: str | Path | Scene, file: str | Path, **options: Any) -> CamOutline:
    """Write a scene's cam as .csv, .svg or .dxf; the old name of `cam(scene, svg=file, …)`."""
    from tauto_core.plots.cutting import drawn_kind

    options[drawn_kind(path('file', file))] = file
    return cam(scene, **options)


def plate(scene: str | Path | Scene, **options: Any) -> ScenePlate:
    """Return a scene's cam as a plate; the old name of `cam(scene, plate=True, …).plate`."""
    found = cam(scene, plate=True, **options).plate
    assert found is not None
    return found


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
    length_unit: str = 'm',
    weight_unit: str = 'N',
    gravity: Quantity = STANDARD_GRAVITY,
) -> WheelDesign:
    """Return the design of a wheel and its cam, of which one number is left out.

    Of period, moment of inertia, pull and base radius three give the fourth (Euler 1727, XIX-XXI).
    A disc counts as two numbers, weight and radius, one of which may be the missing one.

    Args:
        period: period of a full swing [s].
        pendulum: or the length of the simple pendulum that swings with it.
        inertia: moment of inertia of the wheel [kg m2].
        disc_weight: or the weight of a uniform disc, in `weight_unit`,
        disc_radius: and its radius, in `length_unit`.
        disc_is_base: whether the radius of the disc is the base radius (XX).
        pull: pull in the thread, without inertia, in `weight_unit`.
        base_radius: base radius of the involute, or the lever rate of a cam with a hole
            [`length_unit`, per radian].
        length_unit: unit of the lengths: m, mm, scruple, rhenish_foot, line or paris_foot.
        weight_unit: unit of weights and pull: N, kg or pound (of Paris).
        gravity: acceleration of gravity [m/s2].

    Returns:
        All numbers, in SI units.

    Raises:
        UsageError: not exactly one is left out, one is given twice, a unit is not known, or a
            number is not between 1e-30 and 1e30.
    """
    from tauto_core.machines.design import wheel_design

    sizes = {
        'period': period,
        'pendulum': pendulum,
        'inertia': inertia,
        'disc_weight': disc_weight,
        'disc_radius': disc_radius,
        'pull': pull,
        'base_radius': base_radius,
    }
    return wheel_design(
        {
            name: size
            if size is None or (isinstance(size, str) and in_words(size))
            else number(name, size)
            for name, size in sizes.items()
        },
        disc_is_base=disc_is_base,
        length_unit=length_unit,
        weight_unit=weight_unit,
        gravity=number('gravity', gravity, 'm/s2'),
    )


def claims() -> list[Claim]:
    """Return every claim of Euler's three papers, each checked against a computed value."""
    from tauto_core.euler.page import all_claims

    return all_claims()


def new_scene(
    file: str | Path | None = None,
    *,
    ship: str | None = None,
    cam: str | None = None,
    thread: str | None = None,
    power: str | None = None,
    escapement: str | None = None,
) -> str:
    """Return a scene that sails as YAML, with the unit and meaning of every key.

    Kinds that are None are chosen to fit those that are given; without any the scene is Euler's
    involute under a weight, in a wind sea.

    Args:
        file: a file to write it to, ending in .yaml or .yml; it must not exist.
        ship: kind of the ship's motion: still, components, sea or recorded.
        cam: kind of the cam, such as involute or hole.
        thread: kind of the thread: vertical, hole, lever or hanging.
        power: kind of the power: force, weight, spring or weight_and_spring.
        escapement: impulse or remontoire; None: there is none.

    Raises:
        UsageError: an unknown kind, kinds that do not go together, or a file that cannot be
            written.
    """
    from tauto_core.scene.reference import write_scene

    asked = {'ship': ship, 'cam': cam, 'thread': thread, 'power': power, 'escapement': escapement}
    if file is not None:
        path('file', file)
    kinds = {key: kind for key, kind in asked.items() if kind is not None}
    return write_scene(None if file is None else str(file), kinds)


def check_bag(bag: str | Path) -> Soundness:
    """Read all of a bag, and return its faults.

    The check covers the ends of its files, checksums, indices, metadata.yaml, payloads, the order
    of the log times, and whether the recording was cut short.

    Args:
        bag: rosbag2 folder or MCAP file.

    Returns:
        Its `damage`, which `recover_bag` can repair, `faults` of its contents and harmless
        `notes`, each a list of sentences; `whole` is true without damage and faults.

    Raises:
        BagError: there is no bag.
    """
    from tauto_core import bags

    return bags.check_bag(path('bag', bag))


def recover_bag(bag: str | Path, out: str | Path | None = None) -> Recovered:
    """Write the readable part of a damaged bag as a new bag; the old bag is not changed.

    Args:
        bag: rosbag2 folder or MCAP file.
        out: folder of the new bag, which must not exist; None: beside the old one, with
            `_recovered` appended to its name.

    Returns:
        The new bag's `path` and `counts` of messages by topic, and descriptions of what is `lost`.

    Raises:
        BagError: nothing is damaged, no message can be read, or the folder cannot be written.
    """
    from tauto_core import bags

    return bags.recover_bag(path('bag', bag), None if out is None else path('out', out))


def compare(
    *clocks: str | Path | Scene,
    ship_of: str | Path | Scene | None = None,
    duration: Quantity | None = None,
    accuracy: Quantity | None = None,
    roll_deg: Sequence[Quantity] = (),
    suspension: Literal['both', 'with', 'without'] = 'both',
    logs: str | Path | None = None,
    passage: str | None = None,
    harbour_days: Quantity = 14.0,
    jobs: int = 2,
    anyway: bool = False,
    **overrides: object,
) -> Comparison:
    """Return a comparison of several clocks in the same sea.

    Args:
        clocks: scenes, as for `load`, each with another `name`; none: the built-in clocks.
        ship_of: a scene whose ship and voyage all of them get.
        duration: length of the run [s].
        accuracy: largest error of the reading for a day of the run [s]; replaces the accuracy
            of the scenes.
        roll_deg: significant amplitudes of the roll [degrees], each in its own run.
        suspension: `both`, `with` or `without`: cases suspended as in the scenes, or fixed.
        logs: a log-book; all sail a passage of it, in the ship of `ship_of` or of the first clock,
            in the sea that its wind raises, and their dials are regulated at its beginning.
        passage: name of that passage, which a file of one may leave out.
        harbour_days: days of rating before its first entry, >= 0.
        jobs: number of parallel processes.
        anyway: sail even machines and ships larger than any known.
        overrides: as for `load`, for every clock; those of the passage (ship, voyage, seed, …) for
            `ship_of`, where there is one.

    Returns:
        `rows`, one for each clock, or two where its case is suspended.

    Raises:
        TautoError: clocks that cannot be compared, or arguments out of range.
    """
    from tauto_core.ensembles import comparison
    from tauto_core.ensembles.trials import check_logs
    from tauto_core.ship.logbook import sound_passage

    if suspension not in ('both', 'with', 'without'):
        raise UsageError(
            f"suspension = {suspension!r}: must be 'both', 'with' or 'without'. Choose one"
        )
    if logs is not None:
        check_logs(str(path('logs', logs)))
    elif passage is not None:
        raise UsageError(f'passage = {passage!r}: is one of a log-book. Name it with logs = …')
    entries = comparison.make_entries(
        clocks,
        ship_of=ship_of,
        duration=duration,
        accuracy=accuracy,
        rolls_deg=numbers('roll_deg', roll_deg, 'deg'),
        cases=suspension,
        anyway=anyway,
        passage=None if logs is None else sound_passage(str(logs), passage),
        harbour_days=number('harbour_days', harbour_days, 'd'),
        overrides=_by_path(overrides),
    )
    return comparison.compare(entries, jobs=whole('jobs', jobs))


def fleet(
    scene: str | Path | Scene,
    *,
    ships: int = 100,
    vary: str | Path | Mapping[str, Mapping[str, object]] | None = None,
    jobs: int = 2,
    scheduler: str | None = None,
    out: str | Path | None = None,
    anyway: bool = False,
    **overrides: object,
) -> Fleet:
    """Return the voyages of many ships on one scene, each ship with its own seed.

    Args:
        scene: as for `load`.
        ships: number of ships.
        vary: keys of the scene that are drawn for each ship, for example
            `{'trochlea.cam.base_radius': {'kind': 'normal', 'sigma': 2e-5}}`, or a YAML file with
            that content.
        jobs: number of parallel processes.
        scheduler: address of a dask scheduler whose workers are used instead.
        out: folder for the rows in Parquet; ships that have a row there do not sail again.
        anyway: sail even machines and ships larger than any known.
        overrides: as for `load`.

    Returns:
        `rows`, a mapping for each ship, and `answers`, the statistics of the fleet.

    Raises:
        TautoError: a drawn value that the scene does not allow, arguments out of range, or
            processes that cannot be started.
    """
    from tauto_core.ensembles import fleets
    from tauto_core.ensembles.workers import Crew

    loaded = load(scene, **overrides)
    if isinstance(vary, str | Path):
        draws, drawn_by = fleets.read_draws(Path(vary), loaded), str(vary)
    else:
        if vary is not None and not isinstance(vary, Mapping):
            raise UsageError(f'vary = {vary!r}: must be a mapping of keys, or a file. Write {{…}}')
        draws, drawn_by = fleets.as_draws(dict(vary or {}), 'vary', loaded), 'vary'
    count = whole('ships', ships)
    plan = fleets.Plan(loaded, origin_of(scene), count, draws, drawn_by)
    where = None if out is None else path('out', out)
    return fleets.sail_fleet(plan, Crew(whole('jobs', jobs), scheduler), where, anyway=anyway)


def trial(
    scene: str | Path | Scene,
    logs: str | Path,
    *,
    compare: Sequence[str | Path | Scene] = (),
    days: tuple[Quantity, Quantity] = (42.0, math.inf),
    years: tuple[float, float] = (-math.inf, math.inf),
    port: str | None = None,
    ocean: str | None = None,
    sample: int | None = None,
    harbour_days: Quantity = 14.0,
    wind_draws: int = 0,
    hull_draws: int = 0,
    local_time_s: Quantity = 4.0,
    duration: Quantity | None = None,
    jobs: int = 2,
    scheduler: str | None = None,
    out: str | Path | None = None,
    file: str | Path | None = None,
    skip_wrong: bool = False,
    anyway: bool = False,
    **overrides: object,
) -> TrialAnswers:
    """Return the passages of a log-book on which a scene's clock would find the longitude.

    Args:
        scene: as for `load`; its ship sails every passage.
        logs: the log-book, a file or a folder.
        compare: further clocks in the same sea, as for `load`, fixed to the ship; `clocks` means
            the built-in ones.
        days: least and largest length of the passages [days].
        years: first and last year of the first entry.
        port: part of the name of a port from which or to which they go.
        ocean: part of the name of the ocean in which most of their entries lie.
        sample: number of passages taken of these, evenly over their list.
        harbour_days: days of rating before the first entry.
        wind_draws: number of repetitions of each passage with another random wind.
        hull_draws: the same with another hull.
        local_time_s: error of the navigator's local time [s], 0 to 3600.
        duration: time from the start to which a voyage is cut [s].
        jobs: number of parallel processes.
        scheduler: as for `fleet`.
        out: as for `fleet`, with a row for each clock on each passage.
        file: name of a picture, ending in .svg, .png or .pdf: the map of all tracks.
        skip_wrong: leave out passages with a wrong row, or without a wind.
        anyway: sail even machines and ships larger than any known.
        overrides: as for `load`.

    Returns:
        The object of `tauto fleet --logs --json`: for each of `clocks`, by the `ways` of finding
        the longitude, its `prizes` and the rest; `voyages`, one for each clock and passage.

    Raises:
        TautoError: a log-book that cannot be read or has no such passages, a passage with a wrong
            row, or arguments out of range.
    """
    from tauto_core.ensembles import trials
    from tauto_core.ensembles.trial_answers import answers_of, check_local_time
    from tauto_core.ensembles.workers import Crew
    from tauto_core.files import check_plot

    logbook, plotted = str(path('logs', logs)), None if file is None else path('file', file)
    if plotted is not None:
        check_plot(plotted, 'file')
    local_time_s = number('local_time_s', local_time_s, 's')
    check_local_time(local_time_s)
    if isinstance(compare, str):
        raise UsageError(f'compare = {compare!r}: must be a list of scenes. Write it in [ ]')
    between = (_between('days', days, 'd'), _between('years', years))
    count = None if sample is None else whole('sample', sample)
    choice = trials.Choice(*between, port, ocean, count)
    loaded, origin = load(scene, **overrides), origin_of(scene)
    trial = trials.make_trial(
        logbook,
        [(origin, loaded), *trials.clocks_beside(loaded, origin, compare)],
        choice,
        harbour_days=number('harbour_days', harbour_days, 'd'),
        longest_s=None if duration is None else number('duration', duration, 's'),
        wind_draws=whole('wind_draws', wind_draws),
        hull_draws=whole('hull_draws', hull_draws),
        skip_wrong=skip_wrong,
        anyway=anyway,
    )
    where = None if out is None else path('out', out)
    sailed = trials.sail_trial(trial, Crew(whole('jobs', jobs), scheduler), where)
    answers = answers_of(sailed, local_time_s)
    if plotted is not None:
        from tauto_core.plots.tracks import draw_trial

        draw_trial(sailed, answers, plotted)
    return answers


def _between(name: str, values: object, unit: str | None = None) -> tuple[float, float]:
    """Return the least and the largest of a range; UsageError for anything else."""
    ends = numbers(name, values, unit)
    if len(ends) != 2 or not ends[0] <= ends[1]:
        raise UsageError(
            f'{name} = {values!r}: must be the least and the largest. Write (42, 100)'
        )
    return ends[0], ends[1]


def plot(
    source: str | Path | Scene | Voyage,
    what: str,
    file: str | Path | None = None,
    *,
    from_s: Quantity | None = None,
    to_s: Quantity | None = None,
    anyway: bool = False,
) -> Figure:
    """Return a picture as a Matplotlib figure, and write it to a file if one is named.

    Args:
        source: a voyage; or a bag, which is replayed; or a scene, which is sailed.
        what: one of `tauto_core.plots.contents.PICTURES`, such as `error`.
        file: name of the file, ending in .svg, .png or .pdf; an existing file is replaced.
        from_s: beginning of the part that `roll` or `spectrum` shows, from the first reading [s].
        to_s: its end [s]. Without both, the roughest ten minutes are shown; with one, the ten
            minutes after `from_s` or before `to_s`.
        anyway: sail even a scene with a machine or ship larger than any known.

    Raises:
        UsageError: no such picture, a file of a format that pictures cannot have, or a part that
            is not one of the voyage.
        TautoError: the source cannot be read or sailed.
    """
    from tauto_core.plots.contents import OF_A_SCENE, check_picture

    from_s, to_s = (
        None if at is None else number(name, at, 's')
        for name, at in (('from_s', from_s), ('to_s', to_s))
    )
    part = from_s is not None or to_s is not None
    check_picture(what, None if file is None else path('file', file), part=part)
    bag = isinstance(source, str | Path) and is_bag(source)
    if what in OF_A_SCENE and not isinstance(source, Voyage) and not bag:
        source = Voyage(load(source), {}, {})
    return _voyage(source, anyway).plot(what, file, from_s=from_s, to_s=to_s)


def report(source: str | Path | Scene | Voyage, file: str | Path, *, anyway: bool = False) -> None:
    """Write a page with all figures and pictures, and the machine as it moves.

    Args:
        source: as for `plot`.
        file: name of the page, ending in .html; an existing file is replaced.
        anyway: as for `plot`.

    Raises:
        UsageError: another suffix, or a folder that does not exist.
        TautoError: Bokeh is not installed, or the source cannot be read or sailed.
    """
    from tauto_core.plots.page import check_report, write_report

    page = path('file', file)
    check_report(page)
    voyage = _voyage(source, anyway)
    write_report(voyage, page, f'tauto.report({voyage.scene.name!r}, {str(file)!r})')


def _by_path(overrides: Mapping[str, object]) -> dict[str, object]:
    """Return values by the paths of their keys: `ship__rate` means `ship.rate`."""
    found: dict[str, object] = {}
    for key, value in overrides.items():
        path_of_key = key.replace('__', '.')
        if path_of_key in found:
            raise UsageError(f'{key}: {path_of_key} is given twice. Leave one out')
        found[path_of_key] = value
    return found


def _voyage(source: str | Path | Scene | Voyage, anyway: bool) -> Voyage:
    if isinstance(source, Voyage):
        return source
    if isinstance(source, str | Path) and is_bag(source):
        return replay(source)
    return sail(source, anyway=anyway)


def is_bag(source: str | Path) -> bool:
    """Return whether a path refers to a bag rather than a scene."""
    return str(source) not in shipped_scenes() and (
        Path(source).is_dir() or Path(source).suffix == '.mcap'
    )
