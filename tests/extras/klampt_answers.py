"""What Klamp't itself makes of a robot or world: run in a process of its own, answers in JSON.

Usage: klampt_answers.py FILE < configurations (a JSON list of lists)
"""

import json
import os
import sys

out = os.dup(1)
os.dup2(2, 1)  # Klamp't talks on standard output
import klampt  # noqa: E402

world = klampt.WorldModel()
path = sys.argv[1]
ok = world.readFile(path) if path.endswith(".xml") else world.loadRobot(path).index >= 0
assert ok, path
robot = world.robot(0)
names = [robot.link(k).getName() for k in range(robot.numLinks())]
told = {"links": names, "terrains": world.numTerrains(), "poses": [], "collisions": []}
for q in json.load(sys.stdin):
    robot.setConfig(q)
    poses = [robot.link(k).getTransform() for k in range(robot.numLinks())]
    told["poses"].append([[R[0::3] + [t[0]], R[1::3] + [t[1]], R[2::3] + [t[2]]] for R, t in poses])
    met = []
    for i in range(len(names)):
        for j in range(i):
            if robot.selfCollisionEnabled(i, j) and robot.link(i).geometry().collides(
                robot.link(j).geometry()
            ):
                met.append(sorted((names[i], names[j])))
    told["collisions"].append(sorted(met))
os.write(out, json.dumps(told).encode())
os._exit(0)
