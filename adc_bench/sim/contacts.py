"""Contacts of the robot with what stands or lies in the arena."""

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
    """Collects contacts, one per thing and control step."""

    def __init__(self) -> None:
        self._open: dict[str, tuple[float, Array]] = {}
        self._done: list[Contact] = []

    def record(self, time_s: float, contacts: list[physx.PhysxContact]) -> None:
        """Add what pushed the robot in the last physics step, the floor excluded."""
        for contact in contacts:
            names = [body.entity.name for body in contact.bodies]
            if "hull" not in names or "floor" in names or not contact.points:
                continue
            impulse_ns: Array = np.sum([point.impulse for point in contact.points], axis=0, dtype=np.float64)
            if not impulse_ns.any():
                continue  # near, not touching
            self._add(time_s, names[0] if names[1] == "hull" else names[1], impulse_ns)

    def touch(self, time_s: float, name: str) -> None:
        """Add a contact that gave no impulse."""
        self._add(time_s, name, np.zeros(3))

    def _add(self, time_s: float, name: str, impulse_ns: Array) -> None:
        first_s, sum_ns = self._open.get(name, (time_s, np.zeros(3)))
        self._open[name] = (first_s, sum_ns + impulse_ns)

    def close_step(self) -> None:
        """End a control step: what it gathered becomes contacts, in order of first touch, then of name."""
        for name, (first_s, impulse_ns) in sorted(self._open.items(), key=lambda item: (item[1][0], item[0])):
            self._done.append(Contact(time_s=first_s, with_name=name, impulse_ns=float(np.linalg.norm(impulse_ns))))
        self._open.clear()

    def take(self) -> list[Contact]:
        """Return the contacts since the last call."""
        taken, self._done = self._done, []
        return taken
