"""The constants of the collocation are those derived in decimals."""

import numpy as np
import pytest
from gauss_derivation import derived

from tauto_core.motion.gauss_step import gauss_constants


@pytest.mark.parametrize('stages', [8, 16])
def test_the_table_holds_the_constants_derived_in_decimals(stages):
    for stored, exact in zip(gauss_constants(stages), derived(stages), strict=True):
        np.testing.assert_array_equal(stored, exact, strict=True)
