"""Live data for display, which is not recorded.

The rules use only the joints: the bench writes them into the entries of commands whose rules
compare them with the start of a plan or the view of a scan.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from workbench.app.emptying.film import Filmed
from workbench.app.runtime.worker import GettingReady
from workbench.model.messages.message import Message
from workbench.model.release import LinkStatus
from workbench.model.scan import Detection, LocalizationResult, OffsetCheck, ScaleCheck


@dataclass(frozen=True, slots=True, eq=False)
class Live:
    """Progress of the running job, and the robot as it stands now.

    `job` is the number of the job that `done` (0..1), `note` and `started` [s since the epoch]
    belong to, 0 before the first.  `getting_ready` is what jobs wait for just now, if anything;
    it does not count as their time.  `joints` (name -> rad) is what the controller reports,
    `robot` what it does by that; empty and None while it reports nothing.  `last_joints`
    (name -> rad) is what it reported last, at `reported_at` [s since the epoch], also when it
    reports nothing any more; empty before its first report.  `link`
    is how the last connection for motion stands, or how it ended.
    `findings` are of the last search for parts, with what it rejected: the journal keeps the
    parts alone, since the rest decides nothing and can be computed again.  So are `films` of the
    piles that were emptied last: the same seeds bring them again.  `unrecorded` says why
    the end of a task or of a sending is not on record yet; else None.  `is_saving`: the
    cell is being written, or the last time it could not be.
    """

    job: int = 0
    done: float = 0.0
    note: Message | str = ""
    started: float = 0.0
    joints: Mapping[str, float] = field(default_factory=dict[str, float])
    robot: Message | None = None
    last_joints: Mapping[str, float] = field(default_factory=dict[str, float])
    reported_at: float = 0.0
    link: LinkStatus = field(default_factory=LinkStatus)
    findings: LocalizationResult | None = None
    films: Filmed | None = None
    getting_ready: GettingReady | None = None
    unrecorded: Message | None = None
    is_saving: bool = False

    def wrong_sizes(self, detections: tuple[Detection, ...] | None) -> tuple[Message, ...]:
        """What the search that brought these detections says of CAD files of a wrong size."""
        words = (check.words for check in self._checks(detections))
        return tuple(words for words in words if words is not None)

    def wrong_parts(self, detections: tuple[Detection, ...] | None) -> tuple[str, ...]:
        """The names of the parts that `wrong_sizes` is about."""
        off = (check.part for check in self._checks(detections) if check.is_off)
        return tuple(dict.fromkeys(off))

    def _checks(
        self, detections: tuple[Detection, ...] | None
    ) -> tuple[ScaleCheck | OffsetCheck, ...]:
        if self.findings is None or self.findings.detections is not detections:
            return ()
        return (*self.findings.scales, *self.findings.offsets)

    def progress_of(self, job: int) -> tuple[float, Message | str]:
        """Share done and note of the job with that number, or of what it waits for."""
        if self.getting_ready is not None:
            return self.getting_ready.done, self.getting_ready.note
        return (self.done, self.note) if self.job == job else (0.0, "")
