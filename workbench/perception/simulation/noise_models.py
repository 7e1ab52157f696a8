"""Builds of simulated scanners: what each kind gets wrong, in figures."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from workbench.model.cell import ScannerMount


@dataclass(frozen=True, slots=True)
class NoiseModel:
    """Errors of a type of scanner.

    Attributes:
        baseline: distance from camera to projector along the image rows [m].
        grazing: cosine of the angle of incidence below which no pixel is measured.
        fading: cosine below which pixels begin to fail.
        drop_outs: share of pixels that fail anywhere (dust, gloss).
        outliers: share of pixels that are decoded wrongly.
        stray: largest error of an outlier [m].
        flying: share of the pixels at a depth edge that measure a depth between its sides.
        fattened: pixels by which near objects extend over far ones.
        blur: standard deviation of the averaging of depths [pixels]; it leaves about
            1 / (2 sqrt(pi) `blur`) of a single pixel's noise.
        bridged: depth steps lower than this are averaged, too [m].
        step: quantisation of depth at 1 m [m].
        wave: amplitude of a periodic depth error at 1 m [m].
        fringe: period of that error [m].
        corners: share of multiple reflections in concave places (`lengthened`).
        gloss: cosine above which a surface mirrors the light into the camera.
        glare: share of such pixels that are holes.
        torn: share of missing rows.
        drifted: motion of the scene along the rows until the last row is measured [pixels].
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
