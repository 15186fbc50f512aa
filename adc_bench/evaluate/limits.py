"""What a submission's process may take: one record, part of the rules."""

import msgspec


class Limits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Budgets of wall time, and what all processes of a submission may hold together unless another scope is said."""

    load_s: float = 120.0  # from the start of the process to its first message
    start_s: float = 60.0  # from the mission to the message that it is ready
    step_s: float = 10.0  # from an observation to its command
    total_s: float = 900.0  # all thinking of a run added up; also the processor time of one process
    memory_bytes: int = 4 * 2**30  # resident, mapped files aside; also the private data of one process
    processes: int = 128  # threads count
    open_files: int = 256  # of one process
    tmp_bytes: int = 256 * 2**20  # /tmp and /dev/shm, each; also the longest file
    printed_bytes: int = 2**20  # what is kept of its output; the rest is counted and dropped
    message_bytes: int = 64 * 2**10  # the longest message that it may send
    largest_figure: float = 1e6  # in an answer; metres, radians, pixels, and their squares and rates
    detections: int = 100  # on one picture
