"""Texts of the tab Emptying."""

from workbench.model.messages.message import Text


class EmptyingText(Text, subject="page-emptying"):
    """Piles that were emptied in simulation: table, summary, curves and film."""

    ASKED_TRUTH = (
        "{piles} {piles:pile|piles} of {count} {count:part|parts} {kind}, seed {seeds}, "
        "by true poses, in simulation."
    )
    ASKED_SCANS = (
        "{piles} {piles:pile|piles} of {count} {count:part|parts} {kind}, seed {seeds}, "
        "by simulated scans, in simulation."
    )
    SEEDS = "{first} to {last}"
    TAKEN = "{count} of {total} parts, {share:%}"
    TAKEN_KNOCKED = "{count} of {total} parts, {share:%}, {knocked} knocked out of the bin"
    STIRRED = "{count} {count:time|times}"
    PICKS = "{count}, {failed}, {touches}"
    FAILED = "{count} failed"
    FAILED_KINDS = "{count} failed ({kinds})"
    COUNTED = "{count} {kind}"
    TOUCHES = "{count} {count:touch|touches}"
    UNSEEN = "of these {count}, {touches}: collisions with parts not found are possible there"
    PLANNING = "{median:ms} median, {most:ms} at 95%"
    TAKEN_OF = "{count} of {total}"
    LEFT = "left: {parts}"
    LEFT_PART = "{part} {kind}"
    NEAREST_FIX = "Smallest change that takes it: {change}."
    SEED = "seed {seed}"
    CURVES = "Parts taken over picks"
    CURVES_FIRST = "Parts taken over picks, of the first {count} piles"
    FILM = "Plan {number} of {plans}, {taken} of {total} taken: {actions}"
    END = "The end: {taken} of {total} taken, the bin is empty"
    END_LEFT = "The end: {taken} of {total} taken, {left} left"
    ARMS_GO = "{arms:and}"
    GOES_TO = "{arm} arm goes to {part}"
    STIRS = "{arm} arm stirs the parts"
    HOLDS = "{arm} arm holds {part}"
    NO_PART = "a part that is not there"
    SCANS = "scan of the bin"
    MISSED = "{arm} arm closes on nothing: missed"
    CROOKED = "{arm} arm takes a part that lies elsewhere: crooked"
    TURNED = "{arm} arm takes a part whose roll is another: turned"
    SLIPPED = "{arm} arm takes a part that is too heavy for the grip: slipped"
    FAILS = "{arm} arm fails: {why}"
