"""The twelve vertical signs: where they stand, and which sign stands where."""

import msgspec

from adc_bench.world.categories import SignCategory


class VerticalSign(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A sign on its post: the post's foot, and the way its board faces (yaw 0: seen by who looks along -x)."""

    name: str
    sign: SignCategory
    x_m: float
    y_m: float
    yaw_rad: float
