"""The entries of a comparison: clocks, fixed or suspended, in one sea or with several rolls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from tauto_core.comparison.roll import significant_roll_deg, with_roll
from tauto_core.readiness import check_known, check_scene
from tauto_core.scene import Scene, load_scene, parse_scene, scene_yaml
from tauto_core.scene.errors import SceneError, UsageError, naming

CLOCKS = (
    'clock_cheek_weight',
    'clock_involute_weight',
    'clock_own_cam_weight',
    'clock_second_cam_force',
    'clock_own_cam_spring',
    'clock_hanging_thread',
    'clock_sully_lever',
    'clock_own_cam_lever',
)
"""The shipped clocks in order; all have the same wheel, drag and escapement."""

SHARED = ('duration', 'starts_at', 'seed', 'gravity', 'ship', 'voyage', 'drift', 'log')
"""Keys of a scene that describe the passage, not the clock."""

OF_THE_CLOCK = ('white_fm', 'random_walk_fm')
"""Keys of `drift` that describe the clock."""

Cases: TypeAlias = Literal['both', 'with', 'without']


@dataclass(frozen=True)
class Entry:
    """A clock that takes part.

    Attributes:
        origin: file or name that the user gave.
        scene: the scene that runs.
        roll_deg: significant amplitude of its ship's roll [deg]; None: measured.
    """

    origin: str
    scene: Scene
    roll_deg: float | None

    @property
    def hung(self) -> bool:
        """Whether the case is suspended."""
        return self.scene.suspension is not None


def make_entries(
    names: Sequence[str] = (),
    *,
    ship_of: str | None = None,
    duration: float | None = None,
    rolls_deg: Sequence[float] = (),
    cases: Cases = 'both',
    anyway: bool = False,
) -> list[Entry]:
    """Return the entries of a comparison, each checked as before a voyage.

    They are in the order of roll, then clock, with fixed cases before suspended ones.

    Args:
        names: files or shipped names; none: CLOCKS.
        ship_of: a scene whose keys SHARED all clocks take; None: they must agree in them.
        duration: duration of the run [s].
        rolls_deg: significant amplitudes of the roll [deg]; none: as the ship rolls.
        cases: 'with' and 'without' suspension, or 'both' where a scene has one.
        anyway: sail machines and ships beyond all that are known, too; rolls asked for may be.

    Raises:
        SceneError: a scene that cannot run.
        UsageError: scenes that do not share their sea, names or rolls given twice, or a suspension
            asked for that a scene does not have.
    """
    scenes = _scenes(names or CLOCKS, ship_of, duration)
    for origin, scene in scenes:
        if not anyway:
            with naming(origin, scene.name):
                check_known(scene)
    _check_names(scenes)
    _check_shared(scenes)
    if len(set(rolls_deg)) < len(rolls_deg):
        raise UsageError(f'--roll {_commas(rolls_deg)}: a roll comes twice. Leave one out')
    entries = []
    for roll in rolls_deg or (None,):
        for origin, scene in scenes:
            rolled = scene if roll is None else _as_given(origin, with_roll(scene, roll))
            for cased in _in_cases(origin, rolled, cases):
                with naming(origin, cased.name):
                    check_scene(cased)
                entries.append(Entry(origin, cased, significant_roll_deg(cased)))
    return entries


def _scenes(
    names: Sequence[str], ship_of: str | None, duration: float | None
) -> list[tuple[str, Scene]]:
    scenes = [(name, load_scene(name)) for name in names]
    taken: dict[str, Any] = {}
    if ship_of is not None:
        passage = load_scene(ship_of)
        taken = {key: getattr(passage, key) for key in SHARED}
    if duration is not None:
        taken['duration'] = duration
    if not taken:
        return scenes
    return [
        (name, _as_given(name, scene.model_copy(update=_own(scene, taken)), ship_of))
        for name, scene in scenes
    ]


def _own(scene: Scene, taken: dict[str, Any]) -> dict[str, Any]:
    """Return the keys taken from a passage, with what the scene's `drift` says of its clock."""
    if 'drift' not in taken:
        return taken
    kept = {key: getattr(scene.drift, key) for key in OF_THE_CLOCK}
    return {**taken, 'drift': taken['drift'].model_copy(update=kept)}


def _as_given(origin: str, changed: Scene, ship_of: str | None = None) -> Scene:
    """Return a changed scene, checked as if it had been written that way."""
    try:
        return parse_scene(scene_yaml(changed), origin)
    except SceneError as error:
        whose = '' if ship_of is None else f' and the passage of {ship_of}'
        error.add_note(f'{origin} was read with the options given{whose}')
        raise


def _in_cases(origin: str, scene: Scene, cases: Cases) -> Iterator[Scene]:
    if cases == 'with' and scene.suspension is None:
        raise UsageError(
            f'--suspension with: {origin} has no suspension. Write one (`suspension: {{kind: '
            f'axle, …}}`, as in {CLOCKS[0]}), or use --suspension both'
        )
    if cases != 'with':
        yield scene.model_copy(update={'suspension': None})
    if cases != 'without' and scene.suspension is not None:
        yield scene


def _check_names(scenes: Sequence[tuple[str, Scene]]) -> None:
    first: dict[str, str] = {}
    for origin, scene in scenes:
        if scene.name in first:
            raise UsageError(
                f'{origin}: its name, {scene.name!r}, is that of {first[scene.name]} too, and a '
                'row is called by it. Leave one out, or give another `name`'
            )
        first[scene.name] = origin


def _check_shared(scenes: Sequence[tuple[str, Scene]]) -> None:
    """Refuse clocks that are not on the same ship."""
    (first, scene), *others = scenes
    passage = _passage(scene)
    for origin, other in others:
        apart = list(_differences('', passage, _passage(other)))
        if apart:
            told = '; '.join(f'{key} = {theirs} against {ours}' for key, ours, theirs in apart)
            raise UsageError(
                f'{origin} does not make the passage of {first}: {told}. Let the scenes agree, '
                f'or take one passage for all with --ship-of {first}'
            )


def _passage(scene: Scene) -> dict[str, Any]:
    return scene.model_dump(include=set(SHARED), exclude={'drift': set(OF_THE_CLOCK)})


def _differences(path: str, ours: Any, theirs: Any) -> Iterator[tuple[str, Any, Any]]:
    """Yield the path of every key whose values differ, and both values."""
    if not (isinstance(ours, dict) and isinstance(theirs, dict)):
        if ours != theirs:
            yield path, ours, theirs
        return
    for key in dict.fromkeys((*ours, *theirs)):
        here = f'{path}.{key}' if path else str(key)
        yield from _differences(here, ours.get(key, 'absent'), theirs.get(key, 'absent'))


def _commas(numbers: Sequence[float]) -> str:
    return ','.join(f'{number:g}' for number in numbers)
