"""Texts of the tab Plan."""

from workbench.model.messages.message import Text


class PlanText(Text, subject="page-plan"):
    """Plans of a row, what computing took, loads, lanes and curves."""

    COMPUTED = "Computed: {times}"
    STAGE_TIME = "{stage} {time:ms}"
    ROW = "{count} plans in a row, {parts}, {time:s} in all"
    SUMMARY = "{strategy}, {guarantee}, plan {digest}"
    SUMMARY_NUMBERED = "Plan {number}: {time:s}, {summary}"
    CHIP = "{arm}: {part}, {grasp}"
    LOAD = "{arm} arm: load {tool} kg, {both} kg with the part"
    LOAD_NOT_SENT = "{arm} arm: load {tool} kg, {both} kg with the part, not sent by {link}"
    NO_MASS = "No load is sent: mass_g of {tools} is missing"
    OUTLINE = "{strategy}, {parts}"
    OUTLINE_ROW = "{strategy}, {parts}, {count} {count:plan|plans}"
    SYNC_POINTS = "Where the arms wait for each other: {count} sync {count:point|points}"
    SYNC_POINT = "{name}, {time:s2}; {before}; {after}"
    LEGS = "{legs:and}"
    LEG_OF = "{arm}: {leg}"
    BLOCK = "{leg}: {start:s2} to {end:s2}, {motion}"
    BLOCK_HELD = "{leg}: {start:s2} to {end:s2}, {motion}, with the part"
    OF_SECONDS = "of {total:s2}"
    ROBOT_OF_SECONDS = "follows the robot, of {total:s2}"
    CLEARANCES = (
        "Least clearance, up to 100; dashed: required ({margin:mm} free, {near_margin:mm} linear)"
    )
    ARM_AXES = "Axes of the {arm} arm"
