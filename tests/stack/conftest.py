import pytest
from floor_pictures import LENSES, road_mount

from adc_bench.stack.birds_eye import BirdsEye


@pytest.fixture(scope="session", params=["pinhole", "barrel"])
def birds_eye(request: pytest.FixtureRequest) -> BirdsEye:
    """The road camera's view of the floor, without a lens and through the benchmark's."""
    return BirdsEye(mount=road_mount(LENSES[request.param]))
