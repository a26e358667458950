"""Which problem to learn, and when to change it (the paper, sections 5 and 6)."""
