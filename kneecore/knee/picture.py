"""A knee's picture: circle, plateau line and ligaments in the load-free pose."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore.errors import ParameterError
from kneecore.knee.parameters import LIGAMENTS, N_PARAMETERS, NAMES, check_physical
from kneecore.knee.physics.forces import THETA_0
from kneecore.knee.physics.pose import ORIGIN_X, ORIGIN_Y
from kneecore.knee.response import RestLength, prepare
from kneecore.model import Shape

__all__ = ["shapes"]

FloatArray = NDArray[np.float64]
_PLATEAU_ENDS_MM = (-30.0, 25.0)  # from its point, along the line


def shapes(x: ArrayLike, baseline: ArrayLike, rest_length: RestLength) -> tuple[Shape, ...]:
    """Return one knee's parts, shape (28,) or (32,), SI, in the femur frame, mm."""
    knee = check_physical(x, "x")
    if knee.ndim != 1:
        raise ParameterError(f"`x` has shape {knee.shape}; one knee, (28,) or (32,), is allowed")
    row = prepare(knee, baseline, rest_length, "x")[0]
    value = dict(zip(NAMES, 1e3 * knee[:N_PARAMETERS], strict=True))
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1) * value["condyle_radius"]
    cos, sin = np.cos(-THETA_0), np.sin(-THETA_0)
    turned = np.array([[cos, -sin], [sin, cos]])
    origin = 1e3 * row[[ORIGIN_X, ORIGIN_Y]]
    slope = knee[NAMES.index("plateau_slope")]
    along = np.array([np.cos(slope), np.sin(slope)])
    point = np.array([value["plateau_x"], value["plateau_y"]])
    ends = np.array([point + s * along for s in _PLATEAU_ENDS_MM])
    links = []
    for name in LIGAMENTS:
        femur = np.array([value[f"{name}_femur_{axis}"] for axis in "xy"])
        tibia = np.array([value[f"{name}_tibia_{axis}"] for axis in "xy"])
        both = np.array([femur, turned @ tibia + origin])
        links.append(Shape(name=name, points=both, kind="link", label=name.upper()))
    centre = np.array([value["condyle_x"], value["condyle_y"]])
    return (
        Shape(name="condyle", points=centre + circle, kind="closed"),
        Shape(name="plateau", points=ends @ turned.T + origin),
        *links,
    )
