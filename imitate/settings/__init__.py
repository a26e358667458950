"""Every constant of the method, typed, with unit and source; TOML in and out.

Two complete sets exist: ``robust`` (the default, for users) and ``faithful`` (as the paper states it, for the
tables). ``cst`` is ``robust`` but for the segmentation, which is the baseline that the paper compares with. A
settings file holds ``mode`` and whatever is to differ from that mode's values.

Sections: `Perception`, `Segmentation`, `PolicySettings`, `Learning`, `World`; together: `Settings`. In and
out: `load_settings`, `parse_settings`, `settings_from_toml`, `to_toml`; `dotted`, any TOML by dotted names.
"""

from imitate.settings.files import dotted, load_settings, parse_settings, settings_from_toml, to_toml
from imitate.settings.learning import Learning
from imitate.settings.modes import Settings
from imitate.settings.perception import Perception
from imitate.settings.policy import PolicySettings
from imitate.settings.segmentation import Mode, Segmentation
from imitate.settings.world import World

__all__ = [
    "Learning",
    "Mode",
    "Perception",
    "PolicySettings",
    "Segmentation",
    "Settings",
    "World",
    "dotted",
    "load_settings",
    "parse_settings",
    "settings_from_toml",
    "to_toml",
]
