"""Teach a robot a manipulation task by showing it once.

The method is Zeng & Kuipers, "Object Manipulation Learning by Imitation" (2016), "the paper" below.

Symbols used throughout::

    h, o        pose of the hand, of an object: x y z qx qy qz qw, metres and unit quaternions
    t           time in seconds since the first frame of the demonstration
    q           an abstraction ⟨O_rel, o_ref⟩: relevant objects and the reference object
    ⟨S, A, c⟩   a formulation: state, actions and cost of a reinforcement-learning problem
    ⟨I, π, β⟩   an option: initiation set, policy and termination
    w, λ        policy weights; the gripper's holding force in newtons
"""

__version__ = "0.1.0"
