"""A judge of plans that shares nothing with the proof but the plan: MuJoCo, and files read anew.

MuJoCo reads the robot's URDF and moves it, and measures distances; all else is taken from the
cell's files (`judged_files`), margins and pairs from the rules in `docs/proof.md`.  Ways are
sampled from coarse to fine: where no pair can come too near between two samples, because no point
moves that far, it is not looked between them; where one can, the next samples are `FINE` apart.  A
plan is refused for a distance when that is missed by more than `BEYOND`.
"""

from itertools import pairwise

import numpy as np
from judge_files import Files, pose_of
from judge_motion import (
    ALIKE,
    BEYOND,
    CLEAR,
    ROOM,
    SLACK,
    Asked,
    Refusal,
    Sampler,
    Way,
    mix,
    onto,
    where,
)
from judge_rules import STRAIGHT, is_off, leaves_straight, rule_broken
from judge_scene import Scene

Kind = tuple[str, str]
"""What a geom is part of, and the arm that carries it or ""."""


class Judge:
    """Of plans for one cell; remembers what it has looked at, which bends do not change."""

    def __init__(self, beyond: float = BEYOND) -> None:
        """A distance has to be missed by more than `beyond` [m]."""
        self.beyond = beyond
        self._scenes: dict[tuple[str, ...], Scene] = {}
        self._known: dict[bytes, Refusal | None] = {}

    def refusal(self, files: Files, scene, plan) -> Refusal | None:
        """Why a plan must not be run, None where nothing was found."""
        broken = rule_broken(files, scene, plan)
        if broken:
            return Refusal(broken)
        kinds = tuple(one.part for one in plan.detections)
        if kinds not in self._scenes:
            self._scenes[kinds] = Scene(files, kinds)
        return _Run(self, self._scenes[kinds], files, scene, plan).refusal()


class _Run:
    """One plan, walked through."""

    def __init__(self, judge: Judge, scene: Scene, files: Files, known, plan) -> None:
        self.judge, self.scene, self.files, self.plan = judge, scene, files, plan
        self.known = known
        boxes = [(one.T_world_box.homogeneous, np.asarray(one.size)) for one in plan.obstacles]
        parts = [one.T_world_part.homogeneous for one in plan.detections]
        scene.set(files, boxes, parts)
        self._sampler = Sampler(scene, judge.beyond)
        self.q = np.zeros(scene.model.nq)
        for arm, columns in scene.columns.items():
            self.q[columns] = files.home(arm)
        self.held: dict[int, object] = {}
        self.placed: dict[int, object] = {}
        model = scene.model
        self.fixed = (
            b"".join(
                a.tobytes()
                for a in (
                    model.geom_size,
                    scene.T_robot,
                    scene.data.mocap_pos,
                    scene.data.mocap_quat,
                )
            )
            + repr((files.cell["policy"], files.cell["tool"], kinds_of(plan))).encode()
            + files.corners.encode()
        )

    def refusal(self) -> Refusal | None:
        broken = self._hands()
        if broken:
            return Refusal(broken)
        waiting = [arm for arm, slides in self.scene.fingers.items() if len(slides)]
        for step in self.plan.sequence:
            ways = [self._way(self.plan.arm(arm), name) for arm, name in step.runs]
            waiting = [arm for arm in waiting if all(arm != way.arm for way in ways)]
            # Nobody knows how open the fingers are of an arm that has not moved yet.
            for end in range(2 if waiting else 1):
                for arm in waiting:
                    self.q[self.scene.fingers[arm]] = self._stroke(arm)[end] / 2
                key = self._key(ways)
                if key not in self.judge._known:
                    self.judge._known[key] = self._step(ways)
                if self.judge._known[key] is not None:
                    return self.judge._known[key]
            self._after(ways)
        return None

    def _stroke(self, arm: str) -> np.ndarray:
        """[m] The least and the widest opening of an arm's fingers."""
        return np.array(self.files.tool(arm).get("stroke_mm", (0, 0))) / 1000

    def _key(self, ways) -> bytes:
        """All that a step depends on."""
        holds = [
            (number, one.arm, self._held(one).tobytes(), number in self.placed)
            for number, one in sorted({**self.held, **self.placed}.items())
        ]
        runs = [(way.arm, way.leg.name, way.one.detection, way.leg.q.tobytes()) for way in ways]
        ends = [None if w.fingers is None else w.fingers[1].tobytes() for w in ways]
        start = [w.chords[0][0].tobytes() for w in ways]
        # `fixed` has parts where they lie; those that were put down hang on legs before this one.
        puts = [np.asarray(one.leg("place").q[-1]).tobytes() for one in self.placed.values()]
        words = (holds, runs, ends, start, puts, str(self.plan.guarantee), len(ways))
        times = [w.leg.t.tobytes() for w in ways] if len(ways) > 1 else []
        return self.fixed + self.q.tobytes() + repr((words, times)).encode()

    def _flange(self, arm: str, q) -> np.ndarray:
        return self.scene.flange(self.files, arm, np.asarray(q))

    def _tcp(self, arm: str, q) -> np.ndarray:
        return self._flange(arm, q) @ pose_of(self.files.tool(arm)["tcp"])

    def _held(self, one) -> np.ndarray:
        """A part (4, 4) in the frame of the TCP that took it where it lay, whatever a plan says."""
        T_part = self.plan.detections[one.detection].T_world_part.homogeneous
        return np.linalg.inv(self._tcp(one.arm, one.leg("approach").q[-1])) @ T_part

    def _hands(self) -> str:
        """What is wrong with where hands are, before anything is looked at near them."""
        for one in self.plan.arms:

            def hand(q, arm=one.arm):
                return self._tcp(arm, q)

            broken = is_off(self.files, self.known, self.plan, one, hand)
            if broken:
                return broken
        return ""

    def _way(self, one, name: str) -> Way:
        leg, after = one.leg(name), one.leg(name).opening
        if name == "approach":
            after = one.leg("extract").opening
        elif name == "place":
            after = one.leg("home").opening
        columns, slides = self.scene.columns[one.arm], self.scene.fingers[one.arm]

        def whole(q, opening) -> np.ndarray:
            values = np.zeros(self.scene.model.nq)
            values[columns], values[slides] = q, opening / 2
            return values

        path = np.asarray(leg.q)
        chords = [(whole(a, leg.opening), whole(b, leg.opening)) for a, b in pairwise(path)]
        for bow in self._bows(path):
            chords += [(whole(a, leg.opening), whole(b, leg.opening)) for a, b in pairwise(bow)]
        fingers = None
        if after != leg.opening and len(slides):
            fingers = whole(path[-1], leg.opening), whole(path[-1], after)
        if name == "reach" and len(slides):
            fingers = tuple(whole(path[0], opening) for opening in self._stroke(one.arm))
        return Way(one, leg, one.arm, chords, fingers)

    def _bows(self, path):
        """What the controller may make of corners of a path (m, n), as polylines (k, n)."""
        corners, zone = self.files.corners, self.files.policy("zone")
        if corners == "stop":
            return
        for before, corner, behind in zip(path, path[1:], path[2:], strict=False):
            if corners == "blend":
                start, end = corner + zone * (before - corner), corner + zone * (behind - corner)
                u = np.linspace(0.0, 1.0, 9)[:, None]
                yield (1 - u) ** 2 * start + 2 * u * (1 - u) * corner + u**2 * end
                continue
            for share in ((0.49, 0.49), (0.25, 0.49), (0.49, 0.25), (0.25, 0.25)):
                ends = (before, share[0]), (behind, share[1])
                yield np.array([corner + part * (end - corner) for end, part in ends])

    def _after(self, ways) -> None:
        for way in ways:
            is_last = way.fingers and way.leg.name != "reach"
            end = way.fingers[1] if is_last else way.chords[len(way.leg.q) - 2][1]
            for columns in (self.scene.columns[way.arm], self.scene.fingers[way.arm]):
                self.q[columns] = end[columns]
            if way.leg.name == "approach":
                self.held[way.one.detection] = way.one
            elif way.leg.name == "place":
                del self.held[way.one.detection]
                self.placed[way.one.detection] = way.one
                T = self._tcp(way.arm, way.leg.q[-1]) @ self._held(way.one)
                self.scene.put_parts({way.one.detection: T})

    def _step(self, ways) -> Refusal | None:
        held = {
            number: (one.arm, pose_of(self.files.tool(one.arm)["tcp"]) @ self._held(one))
            for number, one in self.held.items()
        }
        self.scene.hang(self.files, held)
        for way in ways:
            found = self._alone(way, [other.arm for other in ways if other is not way])
            if found is not None:
                return found
        return self._together(*ways) if len(ways) == 2 else None

    # -- one arm ------------------------------------------------------------------------------

    def _kinds(self) -> list[tuple[str, str]]:
        """What each geom is part of, and the arm that carries it now."""
        holders = {f"part {number}": one.arm for number, one in self.held.items()}
        both = zip(self.scene.group, self.scene.carrier, strict=True)
        return [(group, holders.get(group, carrier)) for group, carrier in both]

    def _asked(self, moving, need) -> Asked:
        """Pairs of which one is moved by some values (nq,), with what `need` says they keep.

        It is asked for two kinds, each (group, carrier).
        """
        scene = self.scene
        moves, levers = scene.moves.copy(), scene.levers.copy()
        for number, _, name in scene.pieces:
            if number in self.held:
                tool = scene.group.index(f"tool {self.held[number].arm}")
                columns = scene.columns[self.held[number].arm]
                g = scene.geom_of[name]
                moves[g, columns] = True
                # As far from each axis as the hand can be, and its own size further.
                levers[g, columns] = levers[tool, columns] + 0.3
        first, second = np.triu_indices(scene.model.ngeom, 1)
        differ = (moves[first] ^ moves[second]) & moving
        differ &= ~(scene.turns[first] | scene.turns[second])
        chosen = np.flatnonzero(differ.any(axis=1))
        pairs = np.stack([first[chosen], second[chosen]], axis=1)
        kinds, known = self._kinds(), {}
        least = np.full(len(chosen), np.nan)
        for k, (a, b) in enumerate(pairs.tolist()):
            pair = kinds[a], kinds[b]
            if pair not in known:
                known[pair] = need(*pair)
            if known[pair] is not None:
                least[k] = known[pair]
        counts = ~np.isnan(least)
        chosen, pairs = chosen[counts], pairs[counts]
        both = np.where(moves, levers, 0.0)[pairs].sum(axis=1)
        return Asked(pairs, least[counts], np.where(differ[chosen], both, 0.0))

    def _alone(self, way: Way, others) -> Refusal | None:
        scene, name, arm = self.scene, way.leg.name, way.arm
        columns = scene.columns[arm]
        policy, tool = self.files.policy, f"tool {arm}"
        margin, near = policy("margin_mm"), policy("near_margin_mm")
        is_straight = name in STRAIGHT
        target = f"part {way.one.detection}"
        press = 0.0 if len(scene.fingers[arm]) else self.files.tool(arm).get("press_mm", 1.5) / 1000
        starts: set[tuple[Kind, Kind]] = set()

        def need(a: Kind, b: Kind) -> float | None:
            pair, arms = {a[0], b[0]}, {a[1], b[1]}
            if len(pair) == 1 or self._never(pair) or arms & set(others):
                return None
            if name == "approach" and pair == {target, tool}:
                return -press
            is_held = any(f"part {number}" in pair for number in self.held)
            if arms == {arm}:
                self_margin = policy("self_margin_mm")
                return (near if is_straight else margin) if is_held else self_margin
            if name == "home" and target in pair and arms == {arm, ""}:
                starts.add((a, b))
                return margin
            works = [k[0] for k in (a, b) if k[1] == arm and k[0] in (tool, target)]
            if is_straight and "" in arms and works:
                if name == "extract" and target in works:
                    starts.add((a, b))
                return near
            return margin

        moving = np.zeros(scene.model.nq, bool)
        moving[columns] = True
        asked = self._asked(moving, need)
        base = self.q.copy()
        base[scene.fingers[arm]] = way.chords[0][0][scene.fingers[arm]]
        chords = [(onto(base, a, columns), onto(base, b, columns)) for a, b in way.chords]
        kinds = self._kinds()
        may = np.array([(kinds[a], kinds[b]) in starts for a, b in asked.pairs.tolist()], bool)
        free = asked.only(~may)
        found = self._sampler.along(chords, free, way)
        if found is None and may.any():
            found = self._from_touch(chords, asked.only(may), way)
        if found is None and way.fingers is not None:
            found = self._fingers(way, base, need, target, tool)
        return found

    def _fingers(self, way: Way, base, need, target, tool) -> Refusal | None:
        """What fingers would touch, but for the part that they take or let go."""
        moving, columns = np.zeros(self.scene.model.nq, bool), self.scene.fingers[way.arm]
        moving[columns] = True

        def other(a: Kind, b: Kind) -> float | None:
            return None if {a[0], b[0]} == {target, tool} else need(a, b)

        base = onto(base, way.fingers[0], self.scene.columns[way.arm])
        ends = [onto(base, values, columns) for values in way.fingers]
        return self._sampler.along([tuple(ends)], self._asked(moving, other), way)

    def _from_touch(self, chords, asked: Asked, way: Way) -> Refusal | None:
        """Pairs that may begin nearer than they keep later: a bed, or a part just put down."""
        near, extract = self.files.policy("near_margin_mm"), way.leg.name == "extract"
        self.scene.at(chords[0][0])
        begin = np.array([self.scene.distance(a, b, 0.02) for a, b in asked.pairs.tolist()])
        if extract:
            deepest = int(begin.argmin())
            if begin[deepest] < -self.files.policy("sink_mm") - min(ALIKE, self.judge.beyond):
                return self._sampler.refused(
                    way, asked, deepest, begin[deepest], 0.0, "lies too deep: "
                )
        count = len(way.leg.q) - 1
        # What touches comes off leaning; what is clear stays so.
        kept = np.where(begin > CLEAR, np.maximum(begin / 2, begin - SLACK), begin - SLACK)
        before = asked.keeping(np.minimum(near, kept))
        if extract:
            release = self.files.policy("release_mm")
            start = self._tcp(way.arm, way.leg.q[0])[:3, 3]
            columns = self.scene.columns[way.arm]

            def far(q) -> float:
                return float(np.linalg.norm(self._tcp(way.arm, q[columns])[:3, 3] - start))

            k = next((k for k in range(count) if far(chords[k][1]) >= release), count)
            parts = [chords[:k], chords[k + 1 : count], []]
            if k < count:
                cut = where(lambda s: far(mix(*chords[k], s)) - release)
                parts[0] = [*parts[0], (chords[k][0], mix(*chords[k], cut))]
                # From a little later on, as the two find this point by other means.
                parts[1] = [(mix(*chords[k], min(cut + 0.02, 1.0)), chords[k][1]), *parts[1]]
            bows = chords[count:]
            parts[1] += [bow for bow in bows if min(map(far, bow)) > release + SLACK]
            found = self._sampler.along(parts[0], before, way)
            return found or self._sampler.along(parts[1], asked, way)
        left = count + 1
        for k in range(count + 1):
            self.scene.at(chords[k][0] if k < count else chords[k - 1][1])
            distances = [self.scene.distance(a, b, 0.02) for a, b in asked.pairs.tolist()]
            if min(distances) >= asked.needs[0] + ROOM:
                left = k
                break
        if left > count and np.ptp(way.leg.q, axis=0).any():
            return Refusal("the hand never leaves the part", (way.arm,), (way.leg.name,))
        out = way.leg.q[: left + 1]
        if len(out) > 1 and not leaves_straight(out, lambda q: self._tcp(way.arm, q)):
            return Refusal("the hand does not leave straight", (way.arm,), (way.leg.name,))
        found = self._sampler.along(chords[: min(left, count)], before, way)
        # A corner is rounded after the waypoint at which the hand has left.
        bows = chords[count:]
        first = len(bows) * left // max(count - 1, 1)
        return found or self._sampler.along([*chords[left:count], *bows[first:]], asked, way)

    # -- two arms -----------------------------------------------------------------------------

    def _together(self, one: Way, other: Way) -> Refusal | None:
        scene, margin = self.scene, self.files.policy("margin_mm")
        arms = {one.arm, other.arm}

        def need(a: Kind, b: Kind) -> float | None:
            is_between = {a[1], b[1]} == arms and not self._never({a[0], b[0]})
            return margin if is_between else None

        sides = []
        for way in (one, other):
            both = np.concatenate([scene.columns[way.arm], scene.fingers[way.arm]])
            chords = [*way.chords, *([way.fingers] if way.fingers else [])]
            sides.append([(onto(self.q, a, both), onto(self.q, b, both), both) for a, b in chords])
        moving = np.zeros(scene.model.nq, bool)
        moving[np.concatenate([sides[0][0][2], sides[1][0][2]])] = True
        asked = self._asked(moving, need)
        is_in_step = str(self.plan.guarantee) == "synchronised"
        if is_in_step and np.array_equal(one.leg.t, other.leg.t):
            count = len(one.leg.q) - 1
            chords = [
                (onto(a[0], b[0], b[2]), onto(a[1], b[1], b[2]))
                for a, b in zip(sides[0][:count], sides[1][:count], strict=True)
            ]
            return self._sampler.along(chords, asked, one, other)
        return self._sampler.products(sides, asked, (one, other))

    def _never(self, pair: set[str]) -> bool:
        names = frozenset(
            f"{group[5:]}_tool" if group.startswith("tool ") else group.removeprefix("link ")
            for group in pair
        )
        return names in self.files.never


def kinds_of(plan) -> tuple[str, ...]:
    return tuple(one.part for one in plan.detections)
