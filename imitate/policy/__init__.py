"""How a movement is written down and improved (the paper, section 5.2)."""
