"""A demonstration to segments (the paper, section 4)."""
