"""Spreading work over processes without changing its result."""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def parallel_map(
    work: Callable[[Item], Result], items: Iterable[Item], workers: int, chunk: int = 1
) -> Iterator[Result]:
    """Yield ``work(item)`` in the order of the items; in this process where ``workers`` is 1.

    Processes are spawned, so that nothing of this process's state reaches them but the arguments.
    """
    if workers <= 1:
        yield from map(work, items)
        return
    with _pool(workers) as pool:
        yield from pool.map(work, items, chunksize=chunk)


def parallel_unordered(
    work: Callable[[Item], Result], items: Iterable[Item], workers: int
) -> Iterator[Result]:
    """Yield ``work(item)`` as soon as it is there: with several workers not in the order of the items."""
    if workers <= 1:
        yield from map(work, items)
        return
    with _pool(workers) as pool:
        try:
            for future in as_completed([pool.submit(work, item) for item in items]):
                yield future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)  # after an error: do not work through the rest


def _pool(workers: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(workers, get_context("spawn"), initializer=_end_with_parent)


def _end_with_parent() -> None:
    """Let this worker end when its parent is killed; by itself it would wait for work forever."""
    parent = parent_process()
    assert parent is not None

    def wait() -> None:
        parent.join()
        os._exit(1)

    Thread(target=wait, daemon=True).start()
