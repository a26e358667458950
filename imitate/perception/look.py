"""A single view looked at, with its complaints named after the file."""

from __future__ import annotations

from imitate.errors import ImitateError, UsageError
from imitate.perception.clusters import open3d
from imitate.perception.complaints import no_table
from imitate.perception.fingers import FingerColours
from imitate.perception.first_view import FirstView, first_view
from imitate.rgbd import PointCloud
from imitate.settings import Perception


def look(
    name: str, cloud: PointCloud, settings: Perception, seed: int, fingers: FingerColours | None = None
) -> FirstView:
    """The first view of a cloud, or of a still picture's pixels as a cloud.

    Args:
        name: of the file, for messages.
        cloud: in the camera's frame, metres.
        settings: what the hand looks like, and the sensor's noise.
        seed: of every random draw.
        fingers: their colours; None: as the settings say, looked up in this view.

    Raises:
        ImitateError: no table in it, or no open3d.
        UsageError: a finger's colour in the settings cannot be resolved.
    """
    open3d()
    try:
        return first_view(cloud.points, cloud.colour, settings, seed, cloud.shape, fingers)
    except UsageError:
        raise
    except ImitateError as error:
        raise ImitateError(no_table(name, str(error), cloud.points)) from None
