"""What stands for the Acme 3000: `python -m acme_cell.device CELL` serves scans of new piles."""

import socket
import sys

import numpy as np

import workbench

PARTS = 2


def main() -> None:
    """Serve until the standard input ends; prints the port."""
    cell = workbench.read_cell(sys.argv[1])
    server = socket.create_server(("127.0.0.1", 0))
    print(server.getsockname()[1], flush=True)
    seed = 0
    while True:
        link, _ = server.accept()
        with link:
            pile = workbench.drop_parts(cell.parts[:1] * PARTS, cell.bin, seed=seed)
            scan = workbench.simulate_scan(cell, pile, seed=seed)
            link.sendall((np.asarray(scan.points) * 1000).astype("<f4").tobytes())
        seed += 1


if __name__ == "__main__":
    main()
