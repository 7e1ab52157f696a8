"""A front before a viser with few file descriptors, as a process: `cramped_front.py USERS LIMIT`.

Prints its url, then does what is said to it, a line each: `fill` opens files until none can be
opened, `free` closes them.  Ends with its input.
"""

import logging
import os
import resource
import sys
from pathlib import Path

from attackers import SECRET

from workbench.gui.shared.viser_server import open_viser
from workbench.web.http.listening import TlsCertificate
from workbench.web.page.relay import Upstream
from workbench.web.server import ServerOptions, serve_front


def main() -> None:
    users, limit, *pem = sys.argv[1:]
    resource.setrlimit(resource.RLIMIT_NOFILE, (int(limit), int(limit)))
    logging.basicConfig(level=logging.WARNING)
    server = open_viser("127.0.0.1", 0, SECRET)

    @server.on_client_connect
    def _(client) -> None:
        client.gui.add_number("number", 0.0)

    certificate = TlsCertificate(Path(pem[0]), Path(pem[1])) if pem else None
    upstream = Upstream(f"http://127.0.0.1:{server.get_port()}", SECRET)
    options = ServerOptions(port=0, certificate=certificate)
    front = serve_front(upstream, Path(users), options, title="Cell tested")
    print(front.url, flush=True)
    held: list[int] = []
    for line in sys.stdin:
        if line == "fill\n":
            fill(held)
        elif line == "free\n":
            for descriptor in held:
                os.close(descriptor)
            held.clear()
        print("done", flush=True)
    os._exit(0)


def fill(held: list[int]) -> None:
    while True:
        try:
            held.append(os.open(os.devnull, os.O_RDONLY))
        except OSError:
            return


if __name__ == "__main__":
    try:
        main()
    except BaseException:
        logging.exception("the front did not start, or broke")
        # viser's threads would go on, and whoever reads our output would wait.
        os._exit(1)
