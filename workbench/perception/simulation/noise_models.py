"""Builds of simulated scanners: what each kind gets wrong, in figures."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from workbench.model.cell import ScannerMount


@dataclass(frozen=True, slots=True)
class NoiseModel:
    """A build of scanner.

    `baseline` [m] is from camera to projector, along the image's rows.  Below the cosine
    `grazing` too little of the pattern comes back; failures begin at `fading`.  `drop_outs` is the
    share of pixels that fail anywhere (dust, gloss); `outliers` that of pixels which are decoded
    wrongly and lie anywhere up to `stray` [m] off; `flying` that of pixels beside a depth edge
    which measure something between its two sides.

    The rest is none unless it is said.  Near things are `fattened` by this many pixels; depths are
    averaged with a deviation of `blur` pixels, steps lower than `bridged` [m] with them, which
    leaves about 1 / (2 sqrt(pi) `blur`) of the deviation that pixels have by themselves; they are
    told in steps of `step` [m] at 1 m, and waved by `wave` [m] at 1 m, once every `fringe` [m] of
    depth.  `corners` is the share of multiple ways in concave places (`lengthened`).  What is met
    more squarely than the cosine `gloss` mirrors the light and is a hole in `glare` of the pixels;
    `torn` is the share of rows that are missing.  By this many pixels the scene has `drifted` along
    the rows when the last of them is measured.
    """

    baseline: float
    grazing: float
    fading: float
    drop_outs: float
    outliers: float
    stray: float
    flying: float
    fattened: int = 0
    blur: float = 0.0
    bridged: float = 0.0
    step: float = 0.0
    wave: float = 0.0
    fringe: float = 0.01
    corners: float = 0.0
    gloss: float = 1.0
    glare: float = 0.0
    torn: float = 0.0
    drifted: float = 0.0


FINE_SCANNER = NoiseModel(
    baseline=0.12,
    grazing=0.26,  # 75 degrees
    fading=0.42,  # 65 degrees
    drop_outs=0.01,
    outliers=0.0005,
    stray=0.03,
    flying=0.05,
)
ROUGH = NoiseModel(
    baseline=0.25,
    grazing=0.34,  # 70 degrees
    fading=0.57,  # 55 degrees
    drop_outs=0.05,
    outliers=0.005,
    stray=0.06,
    flying=0.4,
)
STRUCTURED_LIGHT = NoiseModel(
    baseline=0.2,
    grazing=0.26,
    fading=0.5,
    drop_outs=0.01,
    outliers=0.001,
    stray=0.03,
    flying=0.2,
    blur=0.8,
    bridged=0.006,
    wave=0.0002,
    fringe=0.012,
    corners=0.03,
    gloss=0.995,
    glare=0.3,
)
STEREO = NoiseModel(
    baseline=0.1,
    grazing=0.26,
    fading=0.42,
    drop_outs=0.02,
    outliers=0.003,
    stray=0.05,
    flying=0.3,
    fattened=1,
    blur=1.6,
    bridged=0.008,
    step=0.0005,
)
TIME_OF_FLIGHT = NoiseModel(
    baseline=0.02,
    grazing=0.17,
    fading=0.3,
    drop_outs=0.005,
    outliers=0.001,
    stray=0.03,
    flying=0.6,
    blur=1.0,
    bridged=0.01,
    corners=0.1,
    gloss=0.998,
    glare=0.5,
)
LASER_LINE = NoiseModel(
    baseline=0.3,
    grazing=0.34,
    fading=0.5,
    drop_outs=0.01,
    outliers=0.001,
    stray=0.02,
    flying=0.1,
    torn=0.02,
)
MOVING = replace(LASER_LINE, drifted=3.0)
NOISE_MODELS: Mapping[str, NoiseModel] = MappingProxyType(
    {
        "fine": FINE_SCANNER,
        "rough": ROUGH,
        "structured_light": STRUCTURED_LIGHT,
        "stereo": STEREO,
        "time_of_flight": TIME_OF_FLIGHT,
        "laser_line": LASER_LINE,
        "moving": MOVING,
    }
)


def noise_of(mount: ScannerMount) -> NoiseModel:
    """The build that a cell names for its simulated scanner: `like` in `[scanner.options]`."""
    like = mount.options.get("like", "fine") if mount.source == "simulated" else "fine"
    return NOISE_MODELS[str(like)]
