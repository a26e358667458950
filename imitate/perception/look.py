"""A single view looked at, with its complaints named after the file."""

from __future__ import annotations

from imitate.errors import ImitateError
from imitate.perception.complaints import no_table
from imitate.perception.first_view import FirstView, first_view
from imitate.perception.tabletop import open3d
from imitate.rgbd import PointCloud
from imitate.settings import Perception


def look(name: str, cloud: PointCloud, settings: Perception, seed: int) -> FirstView:
    """The first view of a cloud, or of a still picture's pixels as a cloud.

    Args:
        name: of the file, for messages.
        cloud: in the camera's frame, metres.
        settings: what the hand looks like, and the sensor's noise.
        seed: of every random draw.

    Raises:
        ImitateError: no table in it, or no open3d.
    """
    open3d()
    try:
        return first_view(cloud.points, cloud.colour, settings, seed, cloud.shape)
    except ImitateError as error:
        raise ImitateError(no_table(name, str(error), cloud.points)) from None
