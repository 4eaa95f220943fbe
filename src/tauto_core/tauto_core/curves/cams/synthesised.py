"""The isochronous cam for any power, found by quadrature (theory D)."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from pydantic import Field

from tauto_core.curves.cam import FitError
from tauto_core.curves.cams.table import Fitted
from tauto_core.curves.kind import CamKind, Setting, rate_for_period
from tauto_core.curves.synthesis import PowerTrain, SynthesisError, synthesise, synthesised_cam
from tauto_core.scene.errors import SceneError
from tauto_core.scene.fields import Positive

REMEDY = 'Give a smaller range'


class SynthesisedCam(CamKind):
    """The isochronous cam for any power, made for one period and a range of angles (theory D).

    For a weight alone it equals weight_corrected, for a spring alone spring_corrected, which have
    closed forms.
    """

    threads = ('vertical', 'hole')
    rank = 9
    starter = {'period': 1.0, 'range': 2.0}

    kind: Literal['synthesised'] = 'synthesised'
    period: Positive = Field(description='period of every swing on land [s]')
    range: Positive = Field(description='largest angle that the cam is made for [rad]')

    def made(self, setting: Setting) -> Fitted:
        """Return the cam for the wheel and its power.

        Raises:
            SceneError: a power too slow for the period, a range that the power cannot provide, a
                lever arm longer than the distance of the hole, or a cheek that would be hollow.
        """
        rate_for_period(setting, self.period)
        key, value = 'trochlea.cam.period', self.period
        try:
            found = synthesise(setting.inertia, math.tau / self.period, power_train(setting))
            key, value = 'trochlea.cam.range', self.range
            return synthesised_cam(found, setting.distance, self.range)
        except (SynthesisError, FitError) as error:
            problem, _, remedy = str(error).rpartition('. ')
            raise SceneError(
                'trochlea', key, value, problem or remedy, f'{remedy if problem else REMEDY}.'
            ) from None


def power_train(setting: Setting) -> PowerTrain:
    """Return V and M of a power as functions of its lift y: F = F(0) + κy, V = F(0) y + κy²/2."""
    pull, first = setting.pull, setting.pull.at_rest(setting.gravity)
    stiffness = pull.stiffness
    return PowerTrain(
        pull=lambda y: first + stiffness * y,
        place=lambda v: 2.0 * v / (first + np.sqrt(first * first + 2.0 * stiffness * v)),
        mass=lambda y: np.full_like(y, pull.carried_mass),
    )


KIND = SynthesisedCam
