"""The scanner keeps the promises of its seam; a thread stands for the device."""

import socket
import threading
from dataclasses import replace

import numpy as np
from acme_cell.scanner import AcmeScanner

import workbench
from workbench.testing import check_scanner


def test_it_keeps_its_promises():
    server = socket.create_server(("127.0.0.1", 0))

    def serve():
        for _ in range(2):
            link, _ = server.accept()
            with link:
                points = np.random.default_rng(0).uniform(300, 900, (5000, 3))
                link.sendall(points.astype("<f4").tobytes())

    thread = threading.Thread(target=serve)
    thread.start()
    cell = workbench.read_cell("yumi")
    address = f"127.0.0.1:{server.getsockname()[1]}"
    mount = replace(cell.scanner, source="acme", address=address, patience=60.0)
    scan = check_scanner(AcmeScanner, replace(cell, scanner=mount))
    assert len(scan.points) == 5000
    thread.join()
    server.close()
