"""The budget of a clock's rate: its causes, their uncertainty, the effect of small changes.

Each cause at sea is switched off in turn, and the same stretches of the same voyage are sailed
again with the same seed: the scatter that both runs share cancels. Dial, amplitude, drag and
escapement are computed on land from the steady swing.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from itertools import starmap
from pathlib import Path
from typing import Any, cast

import numpy as np

from tauto_core.bags.write import BUDGET
from tauto_core.checks.readiness import check_known, check_scene
from tauto_core.clockwork import TrochleaStage
from tauto_core.clockwork.trochlea import at_departure, nominal_period_s
from tauto_core.curves.cams.corrected import EquivalentCam, LinearisedCam
from tauto_core.curves.materials import material
from tauto_core.ensembles.rows import Row, Voyages, sail
from tauto_core.machines import (
    AnyMachine,
    HangingMachine,
    LeverMachine,
    Machine,
    NoSteadySwing,
    OtherRegulator,
    SteadySwing,
    compile_machine,
    rate_s_per_day,
    steady_swing,
)
from tauto_core.machines.heat import Heat
from tauto_core.navigation import Route
from tauto_core.navigation.longitude import ARCMIN_PER_S
from tauto_core.samples import PHASE, SHIP_IMU, SHIP_TEMPERATURE, Batches, FloatArray, JointSamples
from tauto_core.scene import Scene
from tauto_core.scene.errors import Argument, PropagationError, TautoError, UsageError, naming
from tauto_core.scene.times import DAY_S, LOOKAHEAD, NS_PER_S
from tauto_core.ship import ShipMotion
from tauto_core.ship.airs import BoxTemperature, ConstantAir
from tauto_core.ship.motions import StillShip
from tauto_core.voyage import CHUNK, ShipSource, bag_scene
from tauto_core.wording import span

STRETCHES, FEWEST_STRETCHES = 240, 24
"""Number of stretches of a long voyage, and the least number if each has to be long."""

THINNED = 3
"""Uncertain numbers are varied on every third stretch."""

STRETCH_S, SETTLE_S = 1800.0, 600.0
"""Least length of a stretch, and of the time that it is sailed before it counts [s]."""

SETTLINGS = 8.0
"""Time constants of the amplitude before a stretch counts: e⁻⁸ of the start remains."""

CHEEK_M, WEIGHT_KG, AMPLITUDE_RAD = 1e-5, 1e-4, 0.1
"""The small changes of `Budget.worth`."""

EXPANSION_PART, MODULUS_PART, THINNING_PART = 0.05, 0.15, 0.15
"""Relative uncertainty of the properties of a named material or oil, an assumption: the name
gives neither the alloy nor the sort.
"""

_FORMAT = 1


@dataclass(frozen=True)
class BudgetRow:
    """The effect of one cause on the rate.

    Attributes:
        cause: its name.
        rate_s_per_day: the rate with the cause minus the rate without it, positive if it gains.
        sigma_s_per_day: standard deviation by the choice of stretches, `None` if the cause was
            computed on land or the whole voyage was sailed.
        east_nmi: how far east it would put the ship at the end of the scene.
        found: `land` or `sea`.
    """

    cause: str
    rate_s_per_day: float
    sigma_s_per_day: float | None
    east_nmi: float
    found: str


@dataclass(frozen=True)
class RoughRow:
    """The effect of an uncertain number on the rate.

    Attributes:
        key: of the number in the scene.
        unit: of the values.
        least, most: smallest and largest value that was tried.
        least_s_per_day, most_s_per_day: change of the whole rate with these values.
    """

    key: str
    unit: str
    least: float
    most: float
    least_s_per_day: float
    most_s_per_day: float

    @property
    def half_range(self) -> float:
        """Half of the range of the rate [s/day]."""
        ends = (0.0, self.least_s_per_day, self.most_s_per_day)
        return 0.5 * (max(ends) - min(ends))


@dataclass(frozen=True)
class Sensitivity:
    """The change of the rate on land [s/day] by a small change, `what`."""

    what: str
    rate_s_per_day: float


@dataclass(frozen=True)
class Budget:
    """The budget of a clock's rate: `sum` + `interaction` = `whole`.

    Attributes:
        duration_s: length of the scene [s].
        latitude_deg: latitude of the ship at the end, for the miles.
        stretches: number of stretches. One of the length of the scene is the whole voyage.
        stretch_s, settle_s: length of each, and the time sailed before it begins to count [s].
        rows, sum: the causes and their sum.
        interaction, whole: the effect of causes that act only together, and the rate with all.
        rough: the effects of uncertain numbers.
        rough_s_per_day: root of the summed squares of their half ranges.
        fixed_s_per_day: the whole rate with the case fixed to the ship, `None` if it is fixed.
        worth: the effect of small changes.
    """

    scene: str
    duration_s: float
    latitude_deg: float
    stretches: int
    stretch_s: float
    settle_s: float
    rows: tuple[BudgetRow, ...]
    sum: BudgetRow
    interaction: BudgetRow
    whole: BudgetRow
    rough: tuple[RoughRow, ...]
    rough_s_per_day: float
    fixed_s_per_day: float | None
    worth: tuple[Sensitivity, ...]

    def __str__(self) -> str:
        """Return the causes as lines of text."""
        rows = (*self.rows, self.sum, self.interaction, self.whole)
        return '\n'.join(f'{row.cause:14}{row.rate_s_per_day:+12.3f} s/day' for row in rows)

    @property
    def sailed(self) -> str:
        """The runs, in words."""
        if self.settle_s == 0.0:
            return f'all of the {span(self.duration_s)} sailed'
        return (
            f'{self.stretches} stretches of {span(self.stretch_s)} sailed, evenly spread over '
            f'{span(self.duration_s)}, each after {span(self.settle_s)} to settle'
        )

    def facts(self) -> dict[str, Any]:
        """Return the budget as a mapping for JSON."""
        return {'format': _FORMAT, 'sailed': self.sailed, **asdict(self)}


@dataclass(frozen=True)
class Job:
    """Stretches of one voyage to be sailed.

    Attributes:
        without: motions or gravity switched off, see `ShipMotion`.
        begins_ns: when each stretch begins to settle, from the start [ns].
        settle_ns: time before it counts [ns]. 0: the voyage is sailed as by `sail`.
        stretch_ns: time for which it counts [ns].
        heat: temperature and age dependence of the machine. `None`: the scene's.
    """

    scene: Scene
    without: tuple[str, ...]
    begins_ns: tuple[int, ...]
    settle_ns: int
    stretch_ns: int
    heat: Heat | None = None

    @property
    def machine(self) -> AnyMachine:
        """The machine of these stretches."""
        built = cast(AnyMachine, compile_machine(self.scene))
        return built if self.heat is None else replace(built, heat=self.heat)


def swings_a_second(job: Job, tell: Callable[[float], None]) -> FloatArray:
    """Return the mean frequency of the swing in each stretch of a job [1/s].

    Raises:
        PropagationError: an event that ends the motion.
    """
    scene, machine = job.scene, job.machine
    source = ShipSource(scene, ShipMotion(scene, job.without), says_scene=False, as_messages=False)
    log_ns, means = scene.log_interval_ns, []
    for number, begin_ns in enumerate(job.begins_ns):
        sample = begin_ns // scene.step_ns
        source.restore({'produced': sample, 'motion': {'next': sample}})
        aged = _aged(machine, begin_ns / NS_PER_S)
        stage = TrochleaStage(scene, 'first' if job.settle_ns else 'scene', aged)
        remaining = (job.settle_ns + job.stretch_ns) // scene.step_ns + 1 + 2 * LOOKAHEAD
        warm = SHIP_TEMPERATURE in stage.inputs
        if warm:  # the clock needs the temperature at the next logged instant
            remaining += log_ns // scene.step_ns + 2 * LOOKAHEAD
        outputs: list[Batches] = []
        while remaining > 0 and source.produced < source.total:
            batches = source.produce(min(remaining, CHUNK))
            remaining -= len(batches[SHIP_IMU].stamp_ns)
            outputs.append(stage.feed({t: batches[t] for t in stage.inputs if t in batches}))
            if len(job.begins_ns) == 1:
                tell(source.produced / source.total)
        if not warm or source.produced >= source.total:
            outputs.append(stage.finish())
        phases = [batch[PHASE] for batch in outputs if PHASE in batch]
        half_turns = np.concatenate(
            [batch.position[:, 1:3] for batch in phases if isinstance(batch, JointSamples)]
        )
        ends = job.settle_ns // log_ns, (job.settle_ns + job.stretch_ns) // log_ns
        # whole half turns and the fraction separately: a long voyage loses no digits
        turned = half_turns[ends[1]] - half_turns[ends[0]]
        means.append(0.5 * float(turned.sum()) / (job.stretch_ns / NS_PER_S))
        tell((number + 1.0) / len(job.begins_ns))
    return np.array(means)


def _aged(machine: AnyMachine, age_s: float) -> AnyMachine:
    """Return the machine with older oil: the clock of a stretch counts from its beginning."""
    if not (age_s and machine.heat.thickening and machine.drag):
        return machine
    viscous = machine.drag.viscous * math.exp(machine.heat.thickening * age_s)
    return replace(machine, drag=machine.drag.model_copy(update={'viscous': viscous}))


def account(
    scene: Scene,
    jobs: int,
    progress: Callable[[float], None] | None = None,
    *,
    origin: str | None = None,
    anyway: bool = False,
) -> Budget:
    """Return the budget of a scene's rate.

    Args:
        jobs: processes at once.
        progress: called with the fraction done.
        origin: file or name that the user gave, for errors. `None`: the scene's name.
        anyway: sail machines and ships larger than any known, too.

    Raises:
        TautoError: a bad scene, a clock without a rate, or an event that ends the motion.
    """
    with naming(origin or scene.name, scene.name):
        if not anyway:
            check_known(scene)
        built, motion = check_scene(scene)
        machine = at_departure(scene, built)
        if isinstance(machine, OtherRegulator):
            raise UsageError(
                f'{scene.name}: a body in a fluid or on an axle has no drag, escapement or heat '
                'to be told apart. Use a scene with a trochlea'
            )
        # none on land if the thread swings, too
        swing = None if isinstance(machine, HangingMachine) else steady_swing(machine)
        if isinstance(swing, NoSteadySwing):
            raise UsageError(
                f'{scene.name}: has no rate to account for: {swing.why}. Give it a drag and an '
                'escapement that keep its swing, or neither'
            )
    nominal_s = nominal_period_s(scene, built)
    heat = cast(AnyMachine, built).heat
    plan = _plan(scene, machine, swing)
    cases = {'': plan, **_causes(plan, machine, heat, motion.moves)}
    causes = list(cases)[1:]
    if swing is None:
        still = {'ship': StillShip(), 'gravity': scene.g, 'suspension': None}
        cases[_ON_LAND] = _with(plan, **still, air=_steady_air(scene))
    if scene.suspension is not None:
        cases[_FIXED] = _with(plan, suspension=None)
    thinned = replace(plan, begins_ns=plan.begins_ns[::THINNED])
    rough = [
        (item.key, item.unit, item.values, [_with(thinned, ship=ship) for ship in item.ships])
        for item in scene.ship.known_roughly(scene)
    ]
    rough += [
        (key, '/K', values, [replace(thinned, heat=heat) for heat in heats])
        for key, values, heats in _materials(scene, heat)
    ]
    for key, _, values, runs in rough:
        for value, job in zip(values, runs, strict=True):
            cases[f'{key} = {value:.4g}'] = job
    # the dial is regulated for the properties that are tried, too
    nominal = {
        name: nominal_s if job.heat is None else nominal_period_s(scene, job.machine)
        for name, job in cases.items()
    }
    rates = {
        name: DAY_S * (nominal[name] * ratio - 1.0)
        for name, ratio in _sailed(cases, jobs, progress).items()
    }
    total = rates['']
    end_ns = np.array([scene.starts_at_ns + scene.duration_ns])
    latitude_deg = float(Route(scene).fixes(end_ns).latitude[0])
    east = -scene.duration / DAY_S * ARCMIN_PER_S * math.cos(math.radians(latitude_deg))

    def row(cause: str, rate: FloatArray | float) -> BudgetRow:
        if isinstance(rate, float):
            return BudgetRow(cause, rate, None, east * rate, 'land')
        mean = float(np.mean(rate))
        return BudgetRow(cause, mean, _sigma(rate), east * mean, 'sea')

    on_land = _on_land(machine, swing, nominal_s)
    if _ON_LAND in rates:
        on_land['drag, escapement'] = float(np.mean(rates[_ON_LAND])) - sum(on_land.values())
    at_sea = {cause: total - rates[cause] for cause in causes}
    parts: dict[str, FloatArray | float] = {**on_land, **at_sea}
    together = sum(at_sea.values(), np.zeros(len(total))) + sum(on_land.values())
    open_rows = tuple(
        RoughRow(
            key,
            unit,
            *values,
            *(float(np.mean(rates[f'{key} = {at:.4g}'] - total[::THINNED])) for at in values),
        )
        for key, unit, values, _ in rough
    )
    return Budget(
        scene=scene.name,
        duration_s=scene.duration,
        latitude_deg=latitude_deg,
        stretches=len(plan.begins_ns),
        stretch_s=plan.stretch_ns / NS_PER_S,
        settle_s=plan.settle_ns / NS_PER_S,
        rows=tuple(starmap(row, parts.items())),
        sum=row('sum', together),
        interaction=row('interaction', total - together),
        whole=row('whole', total),
        rough=open_rows,
        rough_s_per_day=math.hypot(*(item.half_range for item in open_rows)),
        fixed_s_per_day=float(np.mean(rates[_FIXED])) if _FIXED in rates else None,
        worth=tuple(_worth(scene, machine, swing, nominal_s, heat)),
    )


_ON_LAND, _FIXED = 'on land', 'its suspension'


def _with(plan: Job, **keys: object) -> Job:
    return replace(plan, scene=plan.scene.model_copy(update=keys))


def _steady_air(scene: Scene) -> ConstantAir | None:
    if scene.air is None:
        return None
    return ConstantAir(celsius=float(BoxTemperature(scene).at(np.zeros(1, np.int64))[0]))


def _causes(
    plan: Job, machine: AnyMachine, heat: Heat, moves: tuple[tuple[str, ...], ...]
) -> dict[str, Job]:
    jobs = {
        ' and '.join(name for name in names if not name.startswith('force')): replace(
            plan, without=names
        )
        for names in moves
    }
    if plan.scene.gravity == 'normal' and machine.feels_gravity:
        jobs['gravity'] = replace(plan, without=('gravity',))
    if heat.varies and heat.feels_temperature:
        jobs['heat'] = _with(plan, air=_steady_air(plan.scene))
    if heat.thickening:
        jobs['age of oil'] = replace(plan, heat=replace(heat, thickening=0.0))
    return jobs


def case_of(voyage: tuple[int, str, Job]) -> str:
    """Return the change that a job makes, in words, empty for the whole."""
    _, name, _ = voyage
    return f'with {name}' if ' = ' in name else f'without {name}' if name else ''


def sail_job(voyage: tuple[int, str, Job], progress: Callable[[float], None]) -> list[Row]:
    """Return the row of a job: the frequencies of its stretches."""
    number, _, job = voyage
    try:
        return [{'ship': number, 'per_s': swings_a_second(job, progress).tolist()}]
    except PropagationError as error:
        error.add_note(f'That happened {case_of(voyage) or "with all causes"}.')
        raise


def _sailed(
    cases: Mapping[str, Job], jobs: int, progress: Callable[[float], None] | None
) -> dict[str, FloatArray]:
    plan = Voyages(sail_job, [(k, *item) for k, item in enumerate(cases.items())], case_of)
    report = None if progress is None else lambda count: progress(count / len(cases))
    rows = sail(plan, jobs, None, report)
    return {case: np.array(row['per_s']) for case, row in zip(cases, rows, strict=True)}


def _sigma(rates: FloatArray) -> float | None:
    """Return the standard deviation of the mean of evenly spread stretches [s/day].

    Differences of neighbours have little slow weather (Cochran, Sampling Techniques, 3rd ed.,
    8.10: a systematic sample of an autocorrelated population).
    """
    if len(rates) < 2:
        return None
    return float(np.sqrt(0.5 * np.mean(np.diff(rates) ** 2) / len(rates)))


def _plan(scene: Scene, machine: AnyMachine, swing: SteadySwing | None) -> Job:
    """Return the stretches of the scene as it is, which begin with the steady swing."""
    log_ns, memory_s = scene.log_interval_ns, 0.0
    if swing is not None and math.isfinite(swing.time_constant):
        memory_s = swing.time_constant
    elif machine.drag is not None and machine.drag.viscous:
        memory_s = 2.0 * machine.inertia / machine.drag.viscous
    settle_s = max(SETTLE_S, SETTLINGS * memory_s)
    stretch_s = max(STRETCH_S, settle_s)
    settle_ns, stretch_ns = (
        -(-round(seconds * NS_PER_S) // log_ns) * log_ns for seconds in (settle_s, stretch_s)
    )
    each_s = (settle_ns + stretch_ns) / NS_PER_S
    count = max(int(STRETCHES * (STRETCH_S + SETTLE_S) / each_s), FEWEST_STRETCHES)
    if count * each_s >= scene.duration:
        return Job(scene, (), (0,), 0, scene.duration_ns // log_ns * log_ns)
    spare = scene.duration_ns - settle_ns - stretch_ns
    begins = tuple(round(spare * (n + 0.5) / count) // log_ns * log_ns for n in range(count))
    if swing is not None and scene.trochlea is not None:
        release = math.copysign(swing.amplitude, machine.release_angle)
        trochlea = scene.trochlea.model_copy(update={'release_angle': release})
        scene = scene.model_copy(update={'trochlea': trochlea})
    return Job(scene, (), begins, settle_ns, stretch_ns)


# -----------------------------------------------------------------------------
# Causes on land: dial, amplitude, drag, escapement. The effect of small changes.


def _on_land(machine: AnyMachine, swing: SteadySwing | None, nominal_s: float) -> dict[str, float]:
    """Return the causes of the rate on land [s/day], which add up to it.

    The dial is the rate of small free swings. The amplitude adds the difference to free swings of
    the steady amplitude. Drag adds drag and the impulse energy, with all impulses at mid-swing
    where they do not change the period (Airy). The escapement adds their real place and recoil.
    """
    parts = {'dial': rate_s_per_day(machine.small_period, nominal_s)}
    free_s = machine.period(machine.release_angle) if swing is None else swing.free_period
    parts['amplitude'] = rate_s_per_day(free_s, nominal_s) - parts['dial']
    if swing is None or isinstance(machine, HangingMachine):
        return parts
    escapement = machine.escapement
    if escapement is None or machine.drag is None:
        return parts
    driven = rate_s_per_day(swing.period, nominal_s) - rate_s_per_day(swing.free_period, nominal_s)
    energy = 0.5 * escapement.work
    centred = escapement.model_copy(update={'angle': 0.0, 'energy': energy, 'rest': None})
    middle = steady_swing(replace(machine, escapement=centred))
    if isinstance(middle, NoSteadySwing):
        return {**parts, 'drag, escapement': driven}
    drag = rate_s_per_day(middle.period, nominal_s) - rate_s_per_day(middle.free_period, nominal_s)
    return {**parts, 'drag': drag, 'escapement': driven - drag}


def _materials(
    scene: Scene, heat: Heat
) -> Iterator[tuple[str, tuple[float, float], tuple[Heat, Heat]]]:
    """Yield key, limits and heats of each property that only the name of a material gives."""
    trochlea, drag = scene.trochlea, scene.drag
    if trochlea is None or not (heat.varies and heat.feels_temperature):
        return
    parts = [
        (
            'trochlea.material',
            trochlea.material,
            'wheel' if trochlea.cam.material else 'wheel cam',
        ),
        ('trochlea.cam.material', trochlea.cam.material, 'cam'),
        ('trochlea.power.material', getattr(trochlea.power, 'material', None), 'force'),
    ]
    for key, named, fields in parts:
        if isinstance(named, str):
            # a spring's expansion is a twentieth of its modulus
            of_spring = fields == 'force'
            part = MODULUS_PART if of_spring else EXPANSION_PART
            value = (material(named).modulus or 0.0) if of_spring else material(named).expansion
            off = part * abs(value)
            heats = (
                replace(heat, **{name: getattr(heat, name) + shift for name in fields.split()})
                for shift in (-off, off)
            )
            yield key, (value - off, value + off), cast(tuple[Heat, Heat], tuple(heats))
    if drag is not None and isinstance(drag.oil, str):
        rates = tuple(part * heat.oil.rate for part in (1.0 - THINNING_PART, 1.0 + THINNING_PART))
        oils = (replace(heat, oil=heat.oil._replace(rate=rate)) for rate in rates)
        yield 'drag.oil', cast(tuple[float, float], rates), cast(tuple[Heat, Heat], tuple(oils))


def _worth(
    scene: Scene, machine: AnyMachine, swing: SteadySwing | None, nominal_s: float, heat: Heat
) -> Iterator[Sensitivity]:
    """Yield the effects of small possible changes on land, by central differences."""

    def rate(changed: AnyMachine) -> float:
        if isinstance(changed, HangingMachine):
            return rate_s_per_day(changed.period(changed.release_angle), nominal_s)
        steady = steady_swing(changed)
        if isinstance(steady, NoSteadySwing):
            raise UsageError(steady.why)
        return rate_s_per_day(steady.period, nominal_s)

    amplitude = abs(machine.release_angle) if swing is None else swing.amplitude
    changes: dict[str, Callable[[float], float]] = {
        '10 µm of lever arm at 1 rad': lambda sign: rate(_larger_cheek(machine, sign * CHEEK_M)),
        f'0.1 g of {"weight" if machine.feels_gravity else "pull"}': lambda sign: rate(
            _heavier(machine, sign * WEIGHT_KG)
        ),
        '0.1 rad of amplitude': lambda sign: rate_s_per_day(
            machine.period(amplitude + 0.5 * sign * AMPLITUDE_RAD), nominal_s
        ),
    }
    if heat.feels_temperature and not isinstance(machine, HangingMachine):
        # The action of oil on a swinging thread is unknown. The properties hold at
        # heat.at_celsius, and `machine` is `base` at the departure's temperature.
        base, celsius = cast(AnyMachine, compile_machine(scene)), machine.heat.at_celsius
        changes['1 K'] = lambda sign: rate(base.at_celsius(celsius + sign))
    for what, changed in changes.items():
        with suppress(TautoError):
            change = changed(1.0) - changed(-1.0)
            yield Sensitivity(what, change if 'amplitude' in what else 0.5 * change)


def _larger_cheek(machine: AnyMachine, more_m: float) -> AnyMachine:
    """Return a machine with a larger cam, its lever arm at 1 rad longer by `more_m`."""
    if isinstance(machine, HangingMachine):
        return replace(machine, base_radius=machine.base_radius + more_m)
    if isinstance(machine, LeverMachine):
        shape = machine.geometry
        tau = shape.tau_of(np.array([min(1.0, 0.999 * machine.range_rad)]))
        part = 1.0 + more_m / float((shape.base_radius * tau * shape.u_per_tau(tau))[0])
        # β turns faster by this factor. The size of the cam changes the pull by less than
        # a hundredth of that. J scales as the square, the moment of the weights linearly.
        spared = (part**2 - part) * (machine.turned_inertia - machine.lever_inertia)
        if machine.force:
            # a longer end of the lever has the larger moment and draw
            return replace(
                machine,
                weight_arm=machine.weight_arm * part,
                lever_inertia=machine.lever_inertia * part**2,
            )
        return replace(
            machine,
            mass=machine.mass * part,
            lever_inertia=machine.lever_inertia * part**2 + spared,
            tail=(machine.tail[0] * part, machine.tail[1]),
        )
    at = min(1.0, 0.999 * machine.range_rad)
    cam = machine.cam
    if isinstance(cam, EquivalentCam | LinearisedCam):
        part = 1.0 + more_m * at / float(cam.cam.lever_arm(at))
        return replace(machine, cam=EquivalentCam(cam.cam, cam.law, part))
    # a pull on a longer arm is a larger pull, and its mass moves farther
    part = 1.0 + more_m * at / float(cam.lever_arm(at))
    return replace(
        machine,
        carried_mass=machine.carried_mass * part**2,
        pulling_mass=machine.pulling_mass * part,
        force=machine.force * part,
        stiffness=machine.stiffness * part**2,
    )


def _heavier(machine: AnyMachine, more_kg: float) -> AnyMachine:
    """Return a machine with a heavier weight, or a pull that is larger by as much."""
    if isinstance(machine, LeverMachine) and machine.force:
        return replace(machine, force=machine.force + more_kg * machine.gravity)
    if not isinstance(machine, Machine):
        return replace(machine, mass=machine.mass + more_kg)
    if not machine.pulling_mass:
        return replace(machine, force=machine.force + more_kg * machine.gravity)
    return replace(
        machine,
        pulling_mass=machine.pulling_mass + more_kg,
        carried_mass=machine.carried_mass + (more_kg if machine.carried_mass else 0.0),
    )


# -----------------------------------------------------------------------------
# A budget that is stored with its voyage.


def kept_budget(bag: Path) -> dict[str, Any] | None:
    """Return the budget stored with a bag, as `Budget.facts` gave it, or `None`.

    Raises:
        UsageError: this version cannot read it.
    """
    file = (bag if bag.is_dir() else bag.parent) / BUDGET
    if not file.is_file():
        return None
    try:
        content = json.loads(file.read_text(encoding='utf-8'))
        is_known = content['format'] == _FORMAT
    except (OSError, ValueError, KeyError, TypeError):
        is_known = False
    if not is_known:
        raise UsageError(f'{file}: is not a budget of this version. Make it again, or remove it')
    return dict(content)


def budget_file(out: Path, scene: Scene) -> Path:
    """Return the file for a budget in the folder of a voyage.

    Raises:
        UsageError: it is not the folder of a voyage of this scene.
    """
    if not out.is_dir():
        remedy = ': must be the folder of a voyage. For a file use `--json >FILE` or `facts()`'
        raise UsageError(Argument('out', out), remedy)
    from tauto_core.bags import read_bag

    if bag_scene(read_bag(out)) != scene:
        remedy = ': is the voyage of another scene. Give the scene as it was sailed, with the same'
        raise UsageError(Argument('out', out), f'{remedy} settings')
    return out / BUDGET
