"""RGB-D frames to a demonstration (the paper, Appendix A)."""
