"""What a browser has asked for, carried out: no error of it is lost, or ends the page."""

import logging
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import viser

from workbench.gui.incoming.refusals import FAILED, REFUSED, SECONDS_TO_READ
from workbench.model.errors import WorkbenchError

log = logging.getLogger(__name__)


class Rim(ThreadPoolExecutor):
    """Threads for what pages call back; viser 1.1.1 prints their errors where no log has them.

    Concurrency: any thread.
    """

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Call in a thread; an error is reported in the browser that the first argument names."""

        def call() -> Any:
            try:
                return fn(*args, **kwargs)
            except Exception as error:
                show_error(getattr(args[0] if args else None, "client", None), error)

        return super().submit(call)


def show_error(client: viser.ClientHandle | None, error: Exception) -> None:
    """Tell in a browser that something was refused, and in the log what must not happen."""
    if isinstance(error, WorkbenchError):
        title, text = REFUSED, str(error)
    else:
        log.error("what the page was asked for failed", exc_info=error)
        title, text = FAILED, f"{type(error).__name__}: {error}"
    if client is not None:
        client.add_notification(title, text, color="red", auto_close_seconds=SECONDS_TO_READ)
