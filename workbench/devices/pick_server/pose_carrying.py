"""Vision only: one pick while a robot program asks for its poses, and what it reports."""

from workbench.devices.pick_server.carrying import Carrying, Words
from workbench.devices.pick_server.lines import Request
from workbench.devices.pick_server.poses import PoseProgram
from workbench.model.errors import LinkError, ProtocolError
from workbench.model.messages.message import Message
from workbench.model.messages.work import AskText


class PoseCarrying(Carrying):
    """One pick whose poses go out in order, each once, and which `placed` or `failed` ends.

    Lifetime and concurrency: as `Carrying`.
    """

    program: PoseProgram

    @property
    def where(self) -> Message:
        """How far it has come, for people."""
        if not self._given:
            return AskText.BEFORE()
        return AskText.POSE(pose=self._given, poses=len(self.program.poses))

    @property
    def is_moving(self) -> bool:
        """Whether the robot may be on its way, by its own program."""
        return self._given > 0 and not self.is_over

    @property
    def seconds(self) -> float:
        """[s] That the plan would take from here on."""
        return self.program.seconds

    @property
    def step(self) -> int:
        """None of the plan's steps: the robot moves by its own program."""
        return 0

    def _answer(self, request: Request) -> Words:
        match request.job:
            case "next" if not self.is_taken:
                return self._take(request)
            case "pose" if self._given < len(self.program.poses) and not self._is_reported:
                return self._give_pose(request)
            case "picked" if self._given == len(self.program.poses) and not self._is_gripped:
                self._is_gripped = True
                return self._acknowledge(request)
            case "placed" if self._is_gripped:
                return self._end(request, is_picked=True)
            case "failed":
                return self._end(request, is_picked=False)
            case "stop":
                why = request.words[0] if request.words else "-"
                raise LinkError(AskText.STOPPED(where=self.where, why=why))
            case _:
                raise ProtocolError(AskText.WRONG_JOB(job=request.job, where=self.where))

    @property
    def _may_have_missed(self) -> bool:
        # What the robot's own motion has moved nobody knows.
        return False

    def _take(self, request: Request) -> Words:
        # Joints are a report alone: where the robot stands decides nothing here.
        if request.words:
            self._check_joints(request.words)
        self.is_taken = True
        self._count += 1
        return self._record(self.program.words, request)

    def _give_pose(self, request: Request) -> Words:
        self._check_number(request, 0, self._given + 1)
        if not self._given:
            # From here on the robot moves.
            self._released()
        self._given += 1
        self.done = self._given - 1
        self._count += 1
        return self._record(self.program.poses[self._given - 1], request)

    def _end(self, request: Request, *, is_picked: bool) -> Words:
        self._count, self.done = self.program.total, self.program.steps
        self.is_over = True
        self._report_part(request, is_picked=is_picked)
        return self._record(("OK", "end"), request, self.part)
