"""What all sections have in common."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Section(BaseModel):
    """Read only, and nothing in it that has no name here."""

    model_config = ConfigDict(frozen=True, extra="forbid")
