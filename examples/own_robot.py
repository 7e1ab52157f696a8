"""An arm from the six rows of its data sheet: to a cell, and to a proven plan.

What a cell file says about an arm, its tool, the bin and the scanner is all that is needed; without
meshes the arm is checked as capsules along its links.  `workbench cell new` makes such a file from
a URDF.
"""

import tempfile
from pathlib import Path

import workbench as wb

# Of each joint: alpha, a, d, theta, its range and its speed; degrees and mm, standard convention.
ROWS = [
    (-90, 50, 478, 0, -180, 180, 400),
    (0, 425, 50, -90, -130, 147, 400),
    (90, 0, 0, 90, -145, 145, 430),
    (-90, 0, 425, 0, -270, 270, 540),
    (90, 0, 0, 0, -115, 140, 475),
    (0, 0, 100, 0, -270, 270, 760),
]

JOINTS = "".join(
    f"[[robot.dh.joint]]\nalpha_deg = {alpha}\na_mm = {a}\nd_mm = {d}\ntheta_deg = {theta}\n"
    f"range_deg = [{least}, {most}]\nspeed_deg = {speed}\n"
    for alpha, a, d, theta, least, most, speed in ROWS
)

CELL = f"""
name = "own_robot"
parts = ["puck"]                # a shipped part, taken by suction

[robot.dh]
convention = "standard"
radius_mm = 50
{JOINTS}
[[tool]]
name = "cup"
tcp.position_mm = [0, 0, 300]

[[tool.body]]
name = "tube"
shape = "cylinder"
radius_mm = 12
length_mm = 290
position_mm = [0, 0, 150]

[[arm]]
name = "right"
flange = "flange"
tool = "cup"
home_deg = [0, 0, 90, 0, 90, 0]

[[arm.place]]
position_mm = [250, -560, 190]
rpy_deg = [180, 0, 0]

[bin]
position_mm = [600, 0, 5]
size_mm = [300, 400, 100]

[scanner]
position_mm = [600, 0, 1600]
rpy_deg = [180, 0, 90]          # looking down
field_of_view_deg = 30
far_mm = 2000
"""

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "cell.toml"
    file.write_text(CELL, encoding="utf-8")
    cell = wb.read_cell(file)
arm = cell.arms[0]
print(f"an arm of {len(arm.joints)} joints, {len(cell.robot.links)} links, tool {arm.tool.name}")
pile = wb.drop_parts([cell.parts[0]] * 3, cell.bin, seed=2)
scan = wb.simulate_scan(cell, pile, seed=2)
found = wb.localize(cell, scan).detections
print(f"{len(pile)} parts in the bin, {len(found)} found")
result = wb.plan(cell, found, scan=scan)
if result.plan is None or result.proof is None:
    print(f"no plan: {result.verdict}")
else:
    print(f"a pick in {result.plan.cycle_seconds:.1f} s, proven: {result.proof.holds}")
    print("its legs:", ", ".join(leg.name for leg in result.plan.arms[0].legs))
