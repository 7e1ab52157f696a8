"""Makes the convex pieces in meshes/: the links of the arm, measured to hold the real ones.

Lengths in millimetres, each piece in the frame of its link.

Run from the repository's root: `python -m robots.tx2_90.make_meshes`.
"""

from pathlib import Path

from robots.hulls import Y, Z, disc, mirrored, plate, write_all

CHEEK = (  # one side of the fork in which the wrist turns
    disc((0, 31, 425), Y, 53),
    disc((0, 40, 425), Y, 58),
    disc((0, 66, 425), Y, 59),
    disc((0, 76, 423), Y, 53),
    plate((-66, 53), (40, 78), 380),
    plate((-64, 50), (40, 70), 360),
)

PIECES = {
    "base_1": (  # the foot
        disc((0, 0, 0), Z, 132),
        disc((0, 0, 60), Z, 130),
        disc((0, 0, 160), Z, 126),
        disc((0, 0, 225), Z, 120),
        disc((0, 0, 251), Z, 116),
    ),
    "base_4": (  # the plate it is screwed down with
        plate((-96, 62), (-127, 127), 0),
        plate((-96, 62), (-128, 128), 50),
        plate((-80, 62), (-100, 100), 62),
    ),
    "base_2": (  # the connectors behind it
        plate((-188, -60), (-66, 66), 5),
        plate((-196, -60), (-66, 66), 80),
        plate((-196, -60), (-66, 66), 130),
        plate((-140, -60), (-66, 66), 158),
    ),
    "base_3": (  # and its front edge
        plate((60, 162), (-63, 63), 0),
        plate((60, 162), (-63, 63), 35),
        plate((60, 138), (-63, 63), 75),
    ),
    "link_1_1": (  # the column
        disc((2, 0, -234), Z, 128),
        disc((4, 0, -206), Z, 130),
        disc((0, 0, -180), Z, 127),
        disc((0, 0, -57), Z, 126),
        disc((3, 0, -13), Z, 119),
        disc((0, 0, 15), Z, 111),
        disc((8, 0, 32), Z, 101),
        disc((25, 8, 76), Z, 75),
    ),
    "link_1_2": (  # the shoulder
        disc((50, 162, 0), Y, 119),
        disc((50, 88, 0), Y, 122),
        disc((36, 18, 0), Y, 119),
        disc((20, -17, -4), Y, 116),
        disc((6, -53, -22), Y, 111),
        disc((24, -72, -12), Y, 88),
        disc((3, -91, -45), Y, 94),
        disc((45, -34, 0), Y, 98),
        disc((40, -106, -8), Y, 36),
        disc((52, -8, 30), Y, 81),
    ),
    "link_2": (  # the upper arm
        disc((0, 157, 0), Y, 119),
        disc((0, 191, 0), Y, 124),
        disc((0, 226, 0), Y, 124),
        disc((0, 260, 0), Y, 119),
        disc((0, 278, 0), Y, 106),
        disc((0, 294, 5), Y, 60),
        disc((0, 157, 425), Y, 92),
        disc((0, 191, 425), Y, 96),
        disc((0, 214, 425), Y, 95),
        disc((0, 238, 424), Y, 91),
        disc((0, 251, 423), Y, 84),
        disc((0, 266, 405), Y, 62),
    ),
    "link_3_1": (  # the tube of the forearm
        disc((0, 0, 156), Z, 72),
        disc((0, 0, 120), Z, 75),
        disc((0, 0, 80), Z, 81),
        disc((0, -8, 35), Z, 92),
        disc((0, -13, 13), Z, 92),
    ),
    "link_3_2": (  # the elbow
        disc((0, 154, 0), Y, 87),
        disc((0, 92, 0), Y, 95),
        disc((0, -42, 2), Y, 94),
        disc((0, -75, 16), Y, 75),
        disc((0, -13, 20), Z, 92),
        disc((0, 60, 30), Z, 92),
        disc((0, -4, -23), Z, 92),
        disc((0, 60, -23), Z, 93),
        disc((0, 8, -58), Z, 84),
        disc((0, 70, -58), Z, 85),
        disc((0, 25, -92), Z, 75),
        disc((0, 2, -84), Z, 72),
        disc((0, 40, -118), Z, 46),
        disc((0, 62, -124), Z, 18),
        disc((0, -99, 34), Y, 44),
        disc((0, 33, -130), Z, 12),
    ),
    "link_4_1": (  # the forearm
        disc((0, 0, 152), Z, 70),
        disc((0, 0, 195), Z, 76),
        plate(-88, (-22, 22), (205, 240)),
        plate((-55, 45), (-84, 84), 250),
        plate((-50, 40), (-85, 85), 300),
        plate((-64, 50), (-66, 66), 370),
        plate((-38, 30), (-83, 83), 370),
        plate((-45, 40), (-50, 50), 384),
        plate((-30, 30), (-36, 36), 400),
    ),
    "link_4_2": CHEEK,
    "link_4_3": mirrored(CHEEK),
    "link_5": (  # the wrist
        disc((0, 0, 89), Z, 39.5),
        disc((0, 0, 70), Z, 39.5),
        plate((-45, 43), (-12, 12), 24),
        plate((-34, 34), (-36, 36), 12),
        plate((-34, 34), (-36, 36), -12),
        plate((-45, 43), (-12, 12), -20),
        disc((0, 0, -20), Z, 40),
        disc((0, 0, -40), Z, 37),
        disc((0, 0, -55), Z, 20),
    ),
    "link_6": (  # the flange
        disc((0, 0, -15), Z, 21),
        disc((0, 0, -9), Z, 39.5),
        disc((0, 0, -6), Z, 39.5),
        disc((0, 0, 0), Z, 32),
    ),
}


if __name__ == "__main__":
    write_all(Path(__file__).with_name("meshes"), PIECES)
