"""When an answer came, told by the kernel: rendering keeps every Python thread of the loop's process from looking."""

import ctypes
import os
import select
import socket
import threading
import time

LONGEST_S = 3600
BITS = 64


class _TimeVal(ctypes.Structure):
    _fields_ = (("s", ctypes.c_long), ("us", ctypes.c_long))


class ArrivalClock:
    """Notes, on `time.perf_counter`'s clock, when something last arrived at a socket.

    A thread waits in select(2), which on Linux says how much of its time limit was left: so the moment is exact
    however late the thread may go on.
    """

    def __init__(self, end: socket.socket) -> None:
        self.last_s = 0.0
        self._edges = select.epoll()
        self._edges.register(end, select.EPOLLIN | select.EPOLLET)  # an edge for each arrival, read or not
        self._stop = os.eventfd(0)
        self._edges.register(self._stop, select.EPOLLIN)
        self._stopped = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Return when the thread has ended."""
        self._stopped = True
        os.eventfd_write(self._stop, 1)
        self._thread.join()
        os.close(self._stop)
        self._edges.close()

    def _run(self) -> None:
        while not self._stopped:
            self.last_s = _ready_s(self._edges.fileno())
            self._edges.poll(0)


def _ready_s(descriptor: int) -> float:
    """Return the moment at which a file descriptor becomes readable."""
    words = (ctypes.c_uint64 * (descriptor // BITS + 1))()
    words[descriptor // BITS] = 1 << (descriptor % BITS)
    left = _TimeVal(LONGEST_S, 0)
    begun_s = time.perf_counter()
    if _LIBC.select(descriptor + 1, ctypes.byref(words), None, None, ctypes.byref(left)) < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return begun_s + LONGEST_S - float(left.s) - float(left.us) * 1e-6


_LIBC = ctypes.CDLL(None, use_errno=True)
