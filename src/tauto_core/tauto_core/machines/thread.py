"""What all kinds of thread share: keys, the machine that they make, refusals."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar, NamedTuple

from tauto_core.curves.cam import Cam
from tauto_core.curves.curvature import possible_cam
from tauto_core.curves.kind import CamKind, Setting
from tauto_core.machines.drag import Drag
from tauto_core.machines.escapement import EscapementKind
from tauto_core.machines.power import PowerKind
from tauto_core.machines.regulator import Regulator
from tauto_core.machines.trochlea import Machine
from tauto_core.scene.errors import Problem
from tauto_core.scene.kinds import Kind

FOLDER = 'tauto_core.machines.threads'


class Parts(NamedTuple):
    """The parts that a thread joins to a machine.

    Attributes:
        inertia: I of the wheel [kg m2].
        cam: cam on the wheel.
        power: power that pulls the thread.
        release_angle: angle of release of the wheel in its case, at rest at the start [rad].
        gravity: g [m/s2].
        drag: torques against the motion in the case, including the friction of resting teeth.
        escapement: the escapement.
    """

    inertia: float
    cam: CamKind
    power: PowerKind
    release_angle: float
    gravity: float
    drag: Drag | None
    escapement: EscapementKind | None


class ThreadKind(Kind):
    """A thread. Each kind is a module of `machines/threads` that names its `KIND`.

    Attributes:
        moves_the_weight: whether the motion of the weight on the thread is part of the machine.
        upright: whether a weight keeps it along the apparent vertical.
    """

    moves_the_weight: ClassVar[bool] = False
    upright: ClassVar[bool] = False

    kind: str

    @property
    def hole_distance(self) -> float:
        """Distance of the hole from the axle [m]; inf without a hole."""
        return math.inf

    def setting(self, parts: Parts) -> Setting:
        """Return the properties of the machine for which the cam is made."""
        return Setting(parts.inertia, parts.power.pull, parts.gravity, self.hole_distance)

    def cam(self, parts: Parts) -> Cam:
        """Return the cam that is made for this thread.

        Raises:
            SceneError: a cam that cannot be made, or that is impossible (`possible_cam`).
        """
        return possible_cam(parts.cam.made(self.setting(parts)), parts.cam.kind)

    def machine(self, parts: Parts) -> Regulator:
        """Return the machine, here with an ideal thread.

        Raises:
            SceneError: a cam that cannot be made.
        """
        return self.ideal(parts)

    def ideal(self, parts: Parts) -> Machine:
        """Return the machine as if the thread were ideal.

        Raises:
            SceneError: a cam that cannot be made.
        """
        pull = parts.power.pull
        return Machine(
            inertia=parts.inertia,
            carried_mass=pull.carried_mass,
            pulling_mass=pull.pulling_mass,
            force=pull.force,
            stiffness=pull.stiffness,
            gravity=parts.gravity,
            cam=self.cam(parts),
            follows_apparent_vertical=pull.pulling_mass > 0.0 and self.upright,
            drag=parts.drag,
            escapement=parts.escapement,
            release_angle=parts.release_angle,
        )

    def problems(
        self, power: PowerKind, drag: Drag | None, escapement: EscapementKind | None
    ) -> Iterator[Problem]:
        """Yield what is not compatible with a thread that moves its weight."""
        if not self.moves_the_weight:
            return
        if not power.pull.pulling_mass:
            yield Problem(
                'trochlea.power.kind',
                power.kind,
                f'does not go with trochlea.thread.kind {self.kind}, which carries a weight',
                'Use power kind weight, or thread kind vertical.',
            )
        elif not power.pull.carried_mass:
            yield Problem(
                'trochlea.power.massless',
                True,
                f'does not go with trochlea.thread.kind {self.kind}, where the weight moves the '
                'thread',
                'Leave it out, or use thread kind vertical.',
            )
        elif power.pull.stiffness:
            yield Problem(
                'trochlea.power.kind',
                power.kind,
                f'does not go with trochlea.thread.kind {self.kind}, whose equations have no '
                'spring',
                'Use power kind weight, or thread kind vertical.',
            )
        frictions = {
            'drag.coulomb': 0.0 if drag is None else drag.coulomb,
            'escapement.rest.friction': 0.0 if escapement is None else escapement.friction,
        }
        if escapement is not None and escapement.ebb is not None:
            yield Problem(
                'escapement.kind',
                escapement.kind,
                f'with impulses that weaken does not go with trochlea.thread.kind {self.kind}',
                'Give impulses that are all the same (fall 0), or use thread kind vertical or '
                'hole.',
            )
        for key, friction in frictions.items():
            if friction > 0.0:
                yield Problem(
                    key,
                    friction,
                    f'does not go with trochlea.thread.kind {self.kind}',
                    'Use viscous or quadratic drag, or thread kind vertical or hole.',
                )
