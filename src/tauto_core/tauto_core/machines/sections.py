"""The trochlea of a scene: the section, and the rules between its parts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any, cast

from pydantic import Field

from tauto_core.curves.cam import CAMS, Cam, CamKind
from tauto_core.machines.drags.polynomial import Drag
from tauto_core.machines.parts import POWERS, DragKind, EscapementKind, PowerKind
from tauto_core.machines.trochlea import FOLDER as THREADS
from tauto_core.machines.trochlea import Parts, ThreadKind
from tauto_core.scene.errors import Problem, SceneError
from tauto_core.scene.fields import Number, OneOf, Positive, Section, kind_of, kinds_in


def cam_kinds() -> tuple[type[CamKind], ...]:
    """Return all kinds of cam."""
    return cast(tuple[type[CamKind], ...], kinds_in(CAMS))


class Trochlea(Section):
    """The regulator: a balanced wheel with a cam on which a thread winds, pulled by the power."""

    inertia: Positive = Field(description="the wheel's moment of inertia about its axle [kg m2]")
    cam: Annotated[CamKind, OneOf(CAMS)] = Field(
        description='mapping with `kind` and the dimensions of the cam'
    )
    thread: Annotated[ThreadKind, OneOf(THREADS)] = Field(
        description='mapping with `kind` and the dimensions of the thread'
    )
    power: Annotated[PowerKind, OneOf(POWERS)] = Field(
        description='mapping with `kind` and what pulls the thread'
    )
    release_angle: Number = Field(
        description="the wheel's angle in its case at the start, at rest there [rad], "
        'at most ten turns'
    )

    def parts(
        self,
        gravity: float,
        drag: DragKind | None = None,
        escapement: EscapementKind | None = None,
    ) -> Parts:
        """Return the parts of a machine; friction of resting teeth is part of the drag."""
        friction = 0.0 if escapement is None else escapement.friction
        if friction:
            drag = (drag or Drag()).with_friction(friction)
        return Parts(
            self.inertia, self.cam, self.power, self.release_angle, gravity, drag, escapement
        )

    def made_cam(self, gravity: float) -> Cam:
        """Return the cam for the thread of this trochlea.

        Args:
            gravity: acceleration of gravity of the scene [m/s2].

        Raises:
            SceneError: a cam, a thread and a power that are not compatible, a cam that is
                impossible (`possible_cam`), or a table that cannot be used.
        """
        fits = self.thread.kind in self.cam.threads
        if not fits or self.cam.corrects not in ('', self.power.acts_as):
            raise SceneError(
                'trochlea',
                'thread.kind',
                self.thread.kind,
                f'a cam of kind {self.cam.kind!r} is not made for this thread and power '
                f'{self.power.kind!r}',
                'Use ' + '; '.join(_what_goes_together(each) for each in cam_kinds()) + '.',
            )
        return self.thread.cam(self.parts(gravity))

    def problems(
        self,
        gravity: float,
        drag: DragKind | None,
        escapement: EscapementKind | None,
        *,
        still: bool,
    ) -> Iterator[Problem]:
        """Yield what is wrong between its keys, or with the drag and escapement.

        Args:
            gravity: acceleration of gravity of the scene [m/s2].
            drag: the drag of the scene.
            escapement: the escapement of the scene.
            still: whether the ship lies still.
        """
        fitting = self.cam.threads
        if self.thread.kind not in fitting:
            cams = (kind_of(each) for each in cam_kinds() if self.thread.kind in each.threads)
            yield Problem(
                'trochlea.thread.kind',
                self.thread.kind,
                f'does not go with trochlea.cam.kind {self.cam.kind}',
                f'Use thread kind {" or ".join(fitting)}, or a cam of kind {", ".join(cams)}.',
            )
        if self.cam.corrects not in ('', self.power.acts_as):
            yield self._not_corrected(gravity)
        yield from self.thread.problems(self.power, drag, escapement)
        # at rest in the middle only recoil pushes the wheel
        recoil = 0.0 if escapement is None else escapement.recoil
        drag = self.parts(gravity, drag, escapement).drag
        friction = 0.0 if drag is None else drag.coulomb
        if still and self.release_angle == 0.0 and not recoil > friction:
            yield Problem(
                'trochlea.release_angle',
                0.0,
                'leaves the wheel at rest for ever on a ship that lies still',
                'Release it at an angle other than 0 rad'
                + (f', or give it a recoil above {friction!r} N m.' if recoil else '.'),
            )

    def _not_corrected(self, gravity: float) -> Problem:
        """Return what is wrong with a power for which the cam was not made."""
        cam, power = cast(Any, self.cam), self.power
        omega = math.tau / cam.period
        rate = self.inertia * omega * omega / power.pull.at_rest(gravity)
        if power.acts_as == 'force':
            plain = (
                f'cam {{kind: involute, base_radius: {rate:.6g}}}'
                if self.thread.kind == 'vertical'
                else f'cam {{kind: hole, lever_rate: {rate:.6g}}}'
            )
            others = f'a pull without inertia or stiffness needs {plain}'
        else:
            correctors = (kind_of(each) for each in cam_kinds() if each.corrects == power.acts_as)
            others = f'{power.words} needs cam kind {next(correctors, "synthesised")}'
        weightless = power.kind == 'weight' and power.acts_as == 'force'
        return Problem(
            'trochlea.power.massless' if weightless else 'trochlea.power.kind',
            True if weightless else power.kind,
            f'does not go with trochlea.cam.kind {cam.kind}, which is made for power kind '
            f'{cam.corrects}',
            f'For the period of {cam.period!r} s {others}.',
        )


def _what_goes_together(cam: type[CamKind]) -> str:
    power = f' under a {cam.corrects}' if cam.corrects else ''
    return f'{kind_of(cam)} with thread {" or ".join(cam.threads)}{power}'
