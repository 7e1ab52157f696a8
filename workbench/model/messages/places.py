"""What is wrong with pallets and stations of a cell, and how full pallets are."""

from workbench.model.messages.message import Text


class PalletText(Text, subject="pallet"):
    """Pallets in layers: how full they are, and what is wrong with their places."""

    FILL = "{arm} pallet {number}: {parts} of {places}, layer {layer}"
    FULL = "{arm} pallet {number}: {parts} of {places}, full"
    DOUBTFUL = "{count} more may be there or not: check, and report when the pallets are empty"
    UNKNOWN_PART = (
        "a part {part} lies on a pallet, and the cell does not have that part any more; take it "
        "away and empty the pallets"
    )
    PROBLEM = "{arm} arm: pallet {number} of parts {part}: {problem}"
    NOTHING_BENEATH = "in layer {layer} nothing is within {far:mm0} beneath a part"
    FALLS = (
        "in layer {layer} a part is released {falls:mm} above its support; {least:mm} to {most:mm} "
        "are required"
    )
    PITCH = "{problem}: layers are {pitch:mm} apart, and the part is {high:mm} high"
    TOO_CLOSE = (
        "in layer {layer} a part comes within {near:mm} of one that lies there; the margin is "
        "{margin:mm}, so pitch_mm has to be larger"
    )
    IN_LAYER = "in layer {layer} {problem}"


class StationText(Text, subject="stand"):
    """Why no part can be taken from a station to its place."""

    PROBLEM = "station {station}, for {part}: {problem}"
    TOO_SMALL = "it is too small to stand on"
    TOO_CLOSE = "it brings a part within {margin:mm} of {body}"
    NOT_CARRIED = "it has nothing beneath it that would carry a part"
    UNREACHABLE = "it is out of reach of every arm"
    NO_GRASP = "no grasp takes a part from it to a place"
    UNSTABLE = "the part stands nowhere without falling over or rolling away"
