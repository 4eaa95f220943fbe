"""What all kinds of cam share: keys, compatible threads and powers, lever arm."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar, NamedTuple

from tauto_core.curves.cam import Cam
from tauto_core.curves.lever_geometry import LeverSetting, LeverShape
from tauto_core.scene.errors import SceneError
from tauto_core.scene.fields import Kind

FOLDER = 'tauto_core.curves.cams'


class Pull(NamedTuple):
    """The pull of a power in the thread: F = force + stiffness · lift + pulling_mass · g_eff.

    Attributes:
        carried_mass: m, whose inertia rides on the thread [kg].
        pulling_mass: mass whose weight pulls [kg].
        force: constant pull, or that of a spring at zero draw [N].
        stiffness: stiffness of a spring [N/m].
    """

    carried_mass: float = 0.0
    pulling_mass: float = 0.0
    force: float = 0.0
    stiffness: float = 0.0

    def at_rest(self, gravity: float) -> float:
        """Return F(0) on land [N]."""
        return self.force + self.pulling_mass * gravity


class Setting(NamedTuple):
    """The properties of the machine for which a cam is made.

    Attributes:
        inertia: I of the wheel [kg m2].
        pull: the pull of the power.
        gravity: g [m/s2].
        distance: distance of the hole from the axle [m]; inf where the thread hangs vertically.
    """

    inertia: float
    pull: Pull
    gravity: float
    distance: float = math.inf


class CamKind(Kind):
    """A cam of a scene. Each kind is a module of `curves/cams` that names its model `KIND`.

    Attributes:
        threads: the kinds of thread that it takes.
        corrects: the power for which it is made, as in `PowerKind.acts_as`; '' for any.
    """

    threads: ClassVar[tuple[str, ...]]
    corrects: ClassVar[str] = ''

    kind: str

    def made(self, setting: Setting) -> Cam:
        """Return the cam for an ideal thread.

        Raises:
            SceneError: a cheek that no thread can wrap, or a table that cannot be used.
        """
        del setting
        raise self._no_cheek('an ideal thread')

    def on_lever(self, lever: LeverSetting) -> LeverShape:
        """Return cam, thread and lever of Sully's machine.

        Raises:
            SceneError: a cam that is not compatible with a lever.
        """
        del lever
        raise self._no_cheek('a lever')

    def files(self) -> Iterator[tuple[str, str]]:
        """Yield key and path of the files that must exist when a scene is loaded."""
        return iter(())

    def _no_cheek(self, thread: str) -> SceneError:
        return SceneError(
            'trochlea',
            'trochlea.cam.kind',
            self.kind,
            f'does not go with {thread}',
            'See which cams go with which threads in docs/scenes.md.',
        )


def rate_for_period(setting: Setting, period: float) -> float:
    """Return t'(0) = I ω²/F(0), which gives small swings a period [m/rad].

    Raises:
        SceneError: a period that is impossible with wheel and power.
    """
    omega = math.tau / period
    rate = setting.inertia * omega * omega / setting.pull.at_rest(setting.gravity)
    if not 0.0 < rate < math.inf:
        raise SceneError(
            'trochlea',
            'trochlea.cam.period',
            period,
            f'asks for a lever arm of {rate!r} m a radian at rest',
            'Give a period in seconds that wheel and power can keep, for example 1.0.',
        )
    return rate
