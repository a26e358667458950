"""The physics: the only room that imports pybullet."""
