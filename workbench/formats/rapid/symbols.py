"""What names of a program stand for, and where their values are while it runs."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from workbench.formats.rapid.problems import PointerMoved, RapidError, RapidStop
from workbench.formats.rapid.syntax.tokens import SyntaxTree, Token
from workbench.formats.rapid.values import Kind, Place

Node = SyntaxTree

MARKS = frozenset({"local", "task", "const", "var", "pers", "inout"})
"""Words of the language that stay in the tree of a declaration."""


class Frame(list[Any]):
    """The places of the local data of one call, None for an argument that was not given."""

    result: Any = None
    error: RapidError | None = None
    has_handler: bool = False
    is_trap: bool = False


Run = Callable[[Frame], Any]

RETURN, RETRY, TRYNEXT = "RETURN", "RETRY", "TRYNEXT"
"""How a statement ends that does not go on to the next one."""


@dataclass(slots=True)
class Variable:
    """Data: global ones have a place, local ones a slot in the frame.

    `settle` is there until type, sizes and value are known, and finds them.
    """

    name: str
    kind: Kind
    sizes: tuple[int, ...] = ()
    place: Place | None = None
    slot: int = -1
    storage: str = "var"
    is_optional: bool = False
    is_executed: bool = True
    settle: Callable[[], None] | None = None

    @property
    def is_writable(self) -> bool:
        """Whether it may be assigned."""
        return self.storage not in ("const", "loop")


@dataclass(slots=True)
class Parameter:
    """Of a routine; those of a `group` other than 0 exclude each other.

    `others` may stand at its place instead; `executed_as` is what the interpreter takes of it, None
    for nothing.
    """

    name: str
    kind: Kind
    mode: str = "value"
    is_optional: bool = False
    group: int = 0
    others: list["Parameter"] = field(default_factory=list["Parameter"])
    executed_as: Kind | None = None


@dataclass(slots=True, eq=False)
class Routine:
    """A PROC, FUNC or TRAP, or an instruction or function of the controller.

    `native` is what the controller does with the parameters `takes`, `body` what the module says;
    `calls` are all frames of the task that are under way.  One that is loose takes any arguments.
    """

    name: str
    word: str
    kind: Kind | None
    parameters: list[Parameter]
    module: str
    node: Node | None = None
    native: Callable[..., Any] | None = None
    slots: int = 0
    body: Run | None = None
    handler: Run | None = None
    undo: Run | None = None
    locals: list[tuple[int, Run]] = field(default_factory=list[tuple[int, Run]])
    on_error: Callable[[RapidError], None] = lambda error: None
    calls: list[Frame] = field(default_factory=list[Frame])
    takes: list[str] = field(default_factory=list[str])
    is_executed: bool = True
    is_loose: bool = False

    def call(self, places: list[Place | None]) -> Any:
        """Run it with the places of its arguments.

        Raises:
            RapidError: nothing in it has taken an error.
        """
        frame = Frame(places)
        frame.extend([None] * (self.slots - len(places)))
        for slot, value in self.locals:
            frame[slot] = ([value(frame)], 0)
        assert self.body is not None
        frame.has_handler, frame.is_trap = self.handler is not None, self.word == "trap"
        self.calls.append(frame)
        try:
            self.body(frame)
        except PointerMoved:
            if self.undo is not None:
                self.undo(frame)
            raise
        finally:
            self.calls.pop()
        if self.kind is not None and frame.result is None:
            raise RapidError("ERR_FNCNORET")
        return frame.result

    def recover(self, frame: Frame, error: RapidError) -> Any:
        """What the ERROR handler makes of an error: a word that states how to go on.

        Raises:
            RapidError: there is no handler, or it raises.
            RapidStop: no routine that has called this one has a handler, either.
        """
        if self.handler is None or frame.error is not None:
            # Who is interrupted takes no errors of a trap.
            begin = max((k for k, call in enumerate(self.calls) if call.is_trap), default=0)
            if any(call.has_handler and call.error is None for call in self.calls[begin:-1]):
                raise error
            raise RapidStop(f"nothing handles {error}")
        self.on_error(error)
        frame.error = error
        try:
            # A handler that reaches its end returns to the caller.
            return self.handler(frame) or RETURN
        finally:
            frame.error = None


def parts(node: Node) -> list[Any]:
    """The children of a node without the words that only mark it."""
    return [child for child in node.children if type(child) is not Token or child.type not in MARKS]


def words(node: Node) -> set[str]:
    """The words that mark a node."""
    return {child.type for child in node.children if type(child) is Token and child.type in MARKS}


def only(node: Node, data: str) -> Node | None:
    """The child of that kind, if there is one."""
    for child in node.children:
        if type(child) is SyntaxTree and child.data == data:
            return child
    return None
