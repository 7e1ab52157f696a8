"""Two cameras at once, in a network of their own: the second needs an address of an interface.

Run as a program inside `unshare --net`; prints what came as JSON, and the tests judge it.
"""

import json
from concurrent.futures import ThreadPoolExecutor

from genicam_cameras import camera, is_right, number, scanner, taken

from workbench.model.errors import LinkError

ROUNDS = 5
ONE, TWO = ("127.0.0.1", "GV01"), ("127.0.0.2", "GV02")


def told(address: str, serial: str) -> str:
    """Why there is no scan."""
    try:
        return taken(scanner(address, serial=serial)).source
    except LinkError as error:
        return str(error)


def main() -> None:
    """Scan with both at once, then look for one by its number."""
    with camera(*ONE), camera(*TWO), ThreadPoolExecutor() as pool:
        both = []
        for _ in range(ROUNDS):
            dark = pool.submit(taken, scanner(ONE[0], serial=ONE[1], exposure_us=10_000))
            bright = pool.submit(taken, scanner(TWO[0], serial=TWO[1], exposure_us=100_000))
            for scan, brightness in ((dark.result(), 1.0), (bright.result(), 2.0)):
                both.append((brightness, number(scan), is_right(scan, brightness)))
        found = taken(scanner("", serial=TWO[1], exposure_us=100_000))
        refusals = [told("", "GV03"), told("", ""), told(ONE[0], TWO[1])]
    print(json.dumps({"both": both, "found": is_right(found, 2.0), "refusals": refusals}))


if __name__ == "__main__":
    main()
