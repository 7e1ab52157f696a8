"""Runs a study's cases, here one after the other or on many workers, with the same results.

Every case is a function of its number alone, so where it runs changes nothing.  On many workers
they run on Dask `distributed` (extra `cluster`); a case whose worker is lost runs again elsewhere.
"""

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

import numpy as np

from workbench.model.errors import InputError
from workbench.plugins.extras import install_command
from workbench.plugins.progress import Report, silent

Case = TypeVar("Case")
Result = TypeVar("Result")

RETRIES = 5
"""How often a case is tried again when its worker is lost."""


def percentiles(values: Sequence[float], **wanted: float) -> dict[str, float] | None:
    """Percentiles of values by name, in their unit; None where there are no values."""
    if not values:
        return None
    found = np.percentile(values, list(wanted.values()))
    return dict(zip(wanted, map(float, found), strict=True))


def run_cases(
    function: Callable[[Case], Result],
    cases: Sequence[Case],
    *,
    workers: int = 1,
    scheduler: str | None = None,
    report: Report = silent,
    keep: Callable[[Case, Result], None] = lambda case, result: None,
) -> list[Result]:
    """The result of every case, in the order of the cases.

    Args:
        function: importable by its name, so that workers find it.
        cases: what it is called with.
        workers: processes on this machine; 1 runs all in this process.
        scheduler: address of an existing cluster (`tcp://...`), whose workers do it instead.
        report: progress.
        keep: called with each case and its result as soon as that is there, in this process.

    Raises:
        InputError: Dask is needed and not installed, or the cluster cannot be reached.
    """
    if workers <= 1 and scheduler is None:
        results: list[Result] = []
        for case in cases:
            report(len(results) / len(cases), f"{len(results)} of {len(cases)} cases")
            results.append(function(case))
            keep(case, results[-1])
        return results
    with _client(workers, scheduler) as client:
        from distributed import as_completed

        futures = client.map(function, cases, pure=False, retries=RETRIES)
        numbers = {future.key: number for number, future in enumerate(futures)}
        for done, future in enumerate(as_completed(futures)):
            report(done / len(cases), f"{done} of {len(cases)} cases")
            keep(cases[numbers[future.key]], future.result())
        return client.gather(futures)


@contextmanager
def _client(workers: int, scheduler: str | None) -> Generator[Any]:
    """A connection to a cluster; one of our own listens on this machine alone."""
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise InputError(
            f"more than one worker needs Dask: {install_command('cluster')}, or --workers 1"
        ) from None
    if scheduler is not None:
        try:
            client = Client(scheduler, timeout=10)
        except (OSError, ValueError) as error:
            raise InputError(f"the cluster {scheduler}: {error}") from None
        with client:
            yield client
        return
    with (
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host="127.0.0.1",
            # Any free port: that of Dask is taken where two studies run.
            dashboard_address="127.0.0.1:0",
            silence_logs=40,
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client
