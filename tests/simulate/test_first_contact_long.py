"""The other half of the first contacts where rounding is hardest: a file of its own, for a second worker."""

import pytest

from damped_flights import REGIONS
from test_first_contact_damped import many


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("region", REGIONS[1::2])
def test_many(region, seed):
    many(region, seed)
