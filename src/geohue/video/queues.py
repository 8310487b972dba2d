"""Reading ahead and writing behind, each in a thread with a queue of bounded length."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from queue import Queue
from typing import Generic, TypeVar

from geohue.video.sources import Camera, Shot

Item = TypeVar("Item")

ROOM = 4
"""Frames that wait in a queue at most."""


class Feed:
    """Reads a camera in a thread, a few frames ahead.

    Parameters
    ----------
    camera : Camera
    drop : bool
        Where the reader is ahead by `room` frames, drop the oldest of them instead of waiting: a
        picture that is late is worth less than one that is new.
    room : int
        Frames that wait at most.
    """

    def __init__(self, camera: Camera, drop: bool = False, room: int = ROOM) -> None:
        self._camera, self._drop, self._room = camera, drop, room
        self._waiting: deque[tuple[Shot, float]] = deque()
        self._changed = threading.Condition()
        self._ended = self._stopped = False
        self._error: BaseException | None = None
        self.dropped = 0
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def next(self) -> tuple[Shot, float] | None:
        """Return the next frame and when it was read (`time.perf_counter`), None at the end."""
        with self._changed:
            while not self._waiting and not self._ended:
                self._changed.wait()
            if self._waiting:
                shot = self._waiting.popleft()
                self._changed.notify_all()
                return shot
        if self._error is not None:
            raise self._error
        return None

    def close(self) -> None:
        """Stop reading and close the camera."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()
        self._thread.join(timeout=10)
        self._camera.close()

    def _read(self) -> None:
        try:
            while not self._stopped:
                shot = self._camera.read()
                if shot is None:
                    break
                self._put(shot)
        except BaseException as error:  # whatever it is, the one who waits must hear of it
            self._error = error
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def _put(self, shot: Shot) -> None:
        now = time.perf_counter()
        with self._changed:
            while len(self._waiting) >= self._room and not self._stopped:
                if self._drop:
                    self._waiting.popleft()
                    self.dropped += 1
                else:
                    self._changed.wait()
            self._waiting.append((shot, now))
            self._changed.notify_all()


class Sink(Generic[Item]):
    """Does something with each item in a thread, in their order.

    Parameters
    ----------
    write : callable
        What is done with an item.
    room : int
        Items that wait at most; `put` waits beyond that.
    """

    def __init__(self, write: Callable[[Item], None], room: int = ROOM) -> None:
        self._write = write
        self._queue: Queue[Item | None] = Queue(room)
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def put(self, item: Item) -> None:
        """Add an item; raises what an earlier one met with."""
        if self._error is not None:
            raise self._error
        self._queue.put(item)

    def close(self) -> None:
        """Wait until all is done; raises what an item met with."""
        self._queue.put(None)
        self._thread.join()
        if self._error is not None:
            raise self._error

    def _run(self) -> None:
        while (item := self._queue.get()) is not None:
            if self._error is None:
                try:
                    self._write(item)
                except BaseException as error:  # raised again where items are put
                    self._error = error
