"""What the interpreter executes of RobotWare: constants, instructions and functions.

`prelude.mod` is RAPID itself: the shipped reader reads it.  What stands there, and which arguments
it names, is executed; `robotware/` knows all others.  Names and arguments are those of ABB's
"Technical reference manual: RAPID instructions, functions and data types" (3HAC050917); those of
the gripper of "Product manual: Grippers for IRB 14000" (3HAC054949); those of EGM are taken from
modules that others have published, as `devices/abb_egm/rapid_guidance.py` says.
"""

from pathlib import Path

ERRORS = """
ERR_ALRDYCNT ERR_ARGDUPCND ERR_CNTNOTVAR ERR_DIVZERO ERR_FNCNORET ERR_HAND_FAILEDGRIPPOS
ERR_HAND_FAILEDMOVEPOS ERR_HAND_NOTCALIBRATED ERR_ILLRAISE ERR_INOMAX ERR_NUM_OVERFLOW
ERR_OUTOFBND ERR_OVERFLOW ERR_REFUNKPRC ERR_ROBLIMIT ERR_SIG_NOT_VALID ERR_SOCK_ADDR_INUSE
ERR_SOCK_ADDR_INVALID ERR_SOCK_CLOSED ERR_SOCK_IS_BOUND ERR_SOCK_IS_CONN
ERR_SOCK_NOT_BOUND ERR_SOCK_NOT_CONN ERR_SOCK_TIMEOUT ERR_SOCK_UNSPEC ERR_STRTOOLNG
ERR_SYNCMOVEOFF ERR_SYNCMOVEON ERR_TASKNAME ERR_TP_MAXTIME ERR_UDPUC_COMM ERR_UNKINO
ERR_WAITSYNCTASK ERR_WAIT_MAXTIME
"""
"""Predefined error numbers; their values are not ABB's, programs compare names."""

NUMBERS = {name: float(k) for k, name in enumerate(sorted(ERRORS.split()), start=1001)}

ZONES = {
    "z0": (0.3, 0.3, 0.3, 0.03, 0.3, 0.03), "z1": (1, 1, 1, 0.1, 1, 0.1),
    "z5": (5, 8, 8, 0.8, 8, 0.8), "z10": (10, 15, 15, 1.5, 15, 1.5),
    "z15": (15, 23, 23, 2.3, 23, 2.3), "z20": (20, 30, 30, 3.0, 30, 3.0),
    "z30": (30, 45, 45, 4.5, 45, 4.5), "z40": (40, 60, 60, 6.0, 60, 6.0),
    "z50": (50, 75, 75, 7.5, 75, 7.5), "z60": (60, 90, 90, 9.0, 90, 9.0),
    "z80": (80, 120, 120, 12, 120, 12), "z100": (100, 150, 150, 15, 150, 15),
    "z150": (150, 225, 225, 23, 225, 23), "z200": (200, 300, 300, 30, 300, 30),
}  # fmt: skip
"""[mm, mm, mm, deg, mm, deg] The predefined zonedata."""

SPEEDS = (5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000,
          2500, 3000, 4000, 5000, 6000, 7000)  # fmt: skip
"""[mm/s] Of the predefined speeddata; they turn at 500 deg/s."""


def prelude() -> str:
    """Data, instructions and functions, as RAPID."""
    return Path(__file__).with_name("prelude.mod").read_text(encoding="ascii")


def constants() -> str:
    """The predefined data that come in rows, as RAPID."""
    rows = [f"CONST errnum {name}:={number:g};" for name, number in NUMBERS.items()]
    rows += ["CONST zonedata fine:=[TRUE,0,0,0,0,0,0];"]
    rows += [
        f"CONST zonedata {name}:=[FALSE,{','.join(f'{value:g}' for value in values)}];"
        for name, values in ZONES.items()
    ]
    rows += [f"CONST speeddata v{speed}:=[{speed},500,5000,1000];" for speed in SPEEDS]
    rows += ["CONST speeddata vmax:=[7000,500,5000,1000];"]
    return "\n".join(["MODULE Predefined", *rows, "ENDMODULE"])
