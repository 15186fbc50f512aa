"""Contacts of the robot with what stands or lies in the arena."""

import math

import msgspec
import numpy as np
from numpy.typing import NDArray
from sapien import physx

Array = NDArray[np.float64]


class Contact(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robot touched a solid, a body or a tape during one control step.

    `time_s` is the end of the physics step of the first touch; `impulse_ns` the size of the normal impulse that the
    thing gave to the robot over the control step, 0 for a tape. A lasting touch gives one contact a control step.
    """

    time_s: float
    with_name: str
    impulse_ns: float


class ContactLog:
    """Collects contacts, one per thing and control step.

    PhysX lists contacts in no fixed order, so impulses are summed exactly.
    """

    def __init__(self, hull: physx.PhysxRigidBaseComponent, floor: physx.PhysxRigidBaseComponent) -> None:
        self._hull, self._floor = hull, floor
        self._open: dict[str, tuple[float, list[Array]]] = {}
        self._done: list[Contact] = []

    def record(self, time_s: float, contacts: list[physx.PhysxContact]) -> None:
        """Add what pushed the robot in the last physics step, the floor excluded."""
        for contact in contacts:
            bodies = contact.bodies
            if self._hull not in bodies or self._floor in bodies:
                continue
            impulses_ns = [np.asarray(point.impulse, dtype=np.float64) for point in contact.points]
            pushes = [impulse for impulse in impulses_ns if impulse.any()]
            if pushes:  # else near, not touching
                other = bodies[0] if bodies[1] is self._hull else bodies[1]
                self._touched(time_s, other.entity.name).extend(pushes)

    def touch(self, time_s: float, name: str) -> None:
        """Add a contact that gave no impulse."""
        self._touched(time_s, name)

    def _touched(self, time_s: float, name: str) -> list[Array]:
        return self._open.setdefault(name, (time_s, []))[1]

    def close_step(self) -> None:
        """End a control step: what it gathered becomes contacts, in order of first touch, then of name."""
        for name, (first_s, impulses_ns) in sorted(self._open.items(), key=lambda item: (item[1][0], item[0])):
            sums_ns = [math.fsum(along) for along in zip(*impulses_ns, strict=True)]
            self._done.append(Contact(time_s=first_s, with_name=name, impulse_ns=math.hypot(*sums_ns)))
        self._open.clear()

    def take(self) -> list[Contact]:
        """Return the contacts since the last call."""
        taken, self._done = self._done, []
        return taken
