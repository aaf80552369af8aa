"""Signals that end a run: all are answered like Ctrl-C."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

#: What a job scheduler and a terminal that closes send, where the system has it.
_ENDING = ("SIGTERM", "SIGHUP")


@contextmanager
def stopped_like_ctrl_c() -> Iterator[None]:
    """Inside, SIGTERM and SIGHUP interrupt as Ctrl-C does: points are kept, processes end.

    What somebody else handles or ignores (``nohup``) stays as it is.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may set signals
        return
    known = [getattr(signal, name) for name in _ENDING if hasattr(signal, name)]
    ours = [number for number in known if signal.getsignal(number) is signal.SIG_DFL]
    for number in ours:
        signal.signal(number, signal.default_int_handler)
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, signal.SIG_DFL)
