"""Constants of learning."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from imitate.settings.section import Section


class Learning(Section):
    """Trials, updates, evaluation, reformulation (the paper, sections 5 and 6; ALGORITHMS 4 and 5)."""

    alpha: float = Field(default=0.8, gt=0, le=1)
    """α: P(β=1|π) from which an option is accepted."""
    evaluation_starts: int = Field(default=20, ge=1)
    """perturbed starts over which P is estimated."""
    reproduction_starts: int = Field(default=10, ge=1)
    """perturbed starts from which the whole task is reproduced at the end of `learn`."""
    shift: float = Field(default=0.02, ge=0)
    """m by which each block is moved at a perturbed start, at most, along x and y."""
    turn: float = Field(default=15.0, ge=0)
    """degrees by which it is turned, at most."""

    imitation_first: bool = True
    """the first trial is the imitated policy itself; where it will do, nothing is explored."""
    first_rollouts: int = Field(default=10, ge=2)
    """trials before the first update (authors' code)."""
    rollouts: int = Field(default=5, ge=1)
    """new trials before each further update."""
    reused: int = Field(default=5, ge=0)
    """best earlier trials used again in an update."""
    updates: int = Field(default=5, ge=1)
    """U; with the schedule above 30 trials."""
    more_updates: int = Field(default=2, ge=0)
    """further ones where α lies within the interval of the best policy's P."""
    eliteness: float = Field(default=10.0, gt=0)
    """h in P ∝ exp(−h(S − min)/(max − min))."""
    exploration: Literal["constant", "per-kernel", "covariance", "power"] = "constant"
    """constant over a rollout and a scalar cost (PI^BB), per kernel with cost to go (PI²), constant with a
    covariance that is adapted (PI²-CMA), or constant with rewards of the best trials ever (PoWER)."""
    pose_noise: float = Field(default=0.02, ge=0)
    """standard deviation, as a share of the mean absolute pose weight."""
    gripper_noise: float = Field(default=30.0, ge=0)
    """N, standard deviation; 30 found a grip that holds from new starts sooner than 40, which more often
    pressed so hard that the block slipped out, and 40 sooner than 60."""
    gripper_smoothness: float = Field(default=2.0, ge=0)
    """kernels over which that noise stays alike, its correlation exp(−distance / this); 0: each its own, as
    in the paper. A grip has to last: with 2 a block was first placed in trial 5 on average, with 0 in 8."""
    gripper_from_opening: bool = True
    """the gripper's first weights close it while the hand was seen closed; otherwise they are 0. False in the
    faithful mode, where the force is to be discovered."""
    seen_force: float = Field(default=20.0, gt=0)
    """N by which it closes then; in scripted schedules 20 held, 10 slipped (ALGORITHMS 5)."""
    closed_share: float = Field(default=0.25, gt=0, lt=1)
    """the hand counts as closed up to this share of the way from the narrowest opening to the widest."""
    opening_range: float = Field(default=0.01, gt=0)
    """m that lie between these two at least; less may be one opening, seen with noise."""
    wait_to_close: bool = True
    """a carry that closes the gripper keeps still first, for as long as the robot's fingers take to close:
    what a person grasps in passing, a gripper does not."""
    hold_in_air: bool = True
    """where what is carried is shown to hang in the air at a skill's end, the gripper's force ends in a value
    that is learned instead of in 0."""
    least_noise: float = Field(default=0.1, ge=0, le=1)
    """the factor max(least_noise, (U − i − 1)/U) scales the noise at update i; with "covariance", no
    direction has less than this share of the first noise."""
    covariance_rate: float = Field(default=0.3, ge=0, le=1)
    """share of the covariance that an update takes from its trials (Stulp & Sigaud 2012 take 0.2 to 0.5)."""
    reward_cost: float = Field(default=20.0, gt=0)
    """PoWER's reward is exp(−cost / this); the paper's C."""
    goal_noise: float = Field(default=0.0, ge=0)
    """m, standard deviation of the goal's position, which is then learned; the authors' robot had 0.03."""
    goal_turn_noise: float = Field(default=0.0, ge=0)
    """of each component of the goal's quaternion, likewise; the authors' robot had 0.07."""
    grasp_noise: float = Field(default=0.0, ge=0)
    """m, standard deviation of where the hand takes hold, which a skill that closes the gripper then learns:
    the goal of the skill before it."""
    correct_goals: bool = True
    """one trial of each batch has the goal of the best one so far, moved by what its body ended off."""
    correct_within: float = Field(default=0.05, gt=0)
    """m that it may be off; farther off it was lost, which another goal does not mend."""
    correct_angle: float = Field(default=45.0, gt=0)
    """degrees, likewise."""
    improve_by: Literal["total", "terminal-first", "terminal"] = "terminal"
    """which cost improves the policy: the total; the terminal cost until a trial succeeds, then the total; or
    the terminal cost. But for "total", the noise narrows only once a trial has succeeded."""
    converged_below: float = Field(default=3.0, ge=0)
    """two consecutive costs of the mean policy closer than this: converged (authors' code)."""
    observe_trials: bool = False
    """objects' poses in trials come from the virtual camera and the tracker, not from the physics; the
    paper's come from a Kinect."""
    observe_rate: float = Field(default=2.0, gt=0, le=60)
    """frames a second that the camera takes of a trial, besides those where a skill starts and ends."""
    observe_settling: float = Field(default=0.4, ge=0)
    """s before the rest at a skill's end in which the camera looks more often: a block that was half hidden
    is seen turned by up to 15° in the first looks at it and by 1° some looks later."""
    observe_rate_settling: float = Field(default=10.0, gt=0, le=60)
    """frames a second that it takes then; a Kinect's are 30."""
    observe_width: int = Field(default=320, ge=160, le=1280)
    """pixels of the camera's picture across, three quarters of it down; a Kinect's are 640."""
    curtail: bool = True
    """judging a policy stops as soon as the trials that are left cannot change its outcome."""
    candidates: int = Field(default=2, ge=0)
    """best trials that compete with the mean policy after each update; 0: the mean alone."""
    candidate_starts: int = Field(default=5, ge=1)
    """perturbed starts on which the candidates compete."""
    margin: float = Field(default=0.75, gt=0, le=1)
    """share of `near` and `near_angle` within which a success is a firm one. Nor may what was carried have
    moved by more than `near` or `near_angle` after its release: what is dropped lies well by chance."""
    sure: float = Field(default=0.9, gt=0, le=1)
    """share of firm successes from which a policy is accepted at once; one with less, but P ≥ α, is accepted
    when improvement has ended."""
    safe: float = Field(default=0.95, gt=0, le=1)
    """share of successes, firm or not, that this takes too: of 18 in 20 a grip was too weak for 87 in 100.
    Trials in which an earlier skill left something off its place do not count for either."""

    judge: Literal["pose", "cost"] = "pose"
    """β: every relevant body near its shown pose and at rest, or terminal cost below `cost_threshold`."""
    near: float = Field(default=0.02, gt=0)
    """m from the shown pose in the reference's frame."""
    near_angle: float = Field(default=15.0, gt=0)
    """degrees, likewise."""
    free_hand: bool = True
    """where something is carried, its pose at the end counts and not the hand's: another gripper takes hold
    of it a little differently, and turns it by closing."""
    symmetric: tuple[str, ...] = ()
    """objects that count as unturned when they look the same: boxes, up to a tenth between their sides."""
    rest_time: float = Field(default=0.2, gt=0)
    """s over which a body at rest moves less than a share of `near` and `near_angle`, the next."""
    rest_share: float = Field(default=0.1, gt=0, le=1)
    """that share, where the physics says where bodies are."""
    rest_share_seen: float = Field(default=0.25, gt=0, le=1)
    """that share, where the camera does: of two looks each errs by up to 2.8 mm and 1.6° in 95 % of frames
    (tests/bench/test_seeing.py)."""
    cost_threshold: float = Field(default=20.0, gt=0)
    """C of the faithful β."""
    position_cost: float = Field(default=100.0, ge=0)
    """per m of Σ|Δxyz| (authors' code)."""
    turn_cost: float = Field(default=11.0, ge=0)
    """per unit of Σ|Δq| (authors' code)."""
    acceleration_cost: float = Field(default=1e-4, ge=0)
    """per (m/s²)² and control tick of the hand."""
    switch_cost: float = Field(default=5.0, ge=0)
    """for each opening or closing of the gripper (the paper, section 6)."""
    closed_end_cost: float = Field(default=10.0, ge=0)
    """terminal, for ending closed where the demonstration then has the hand leave; without it, holding on is
    cheaper by the opening saved."""
    unreachable_cost: float = Field(default=200.0, ge=0)
    """terminal cost of a trial that was stopped at a pose out of reach."""

    initiation_threshold: float = Field(default=0.5, gt=0, le=1)
    """p of success from which a start is in an option's initiation set: more likely than not."""
    initiation_doubt: float = Field(default=1.0, gt=0)
    """trials that would have to succeed at an untried place for p = 0.5 there."""

    model_threshold: float = Field(default=50.0, ge=0)
    """α_model: natural-log gap to the best abstraction within which others are tried."""
    keep_failed: bool = False
    """pose weights start from those of the formulation before even where it never succeeded, as in the paper;
    else from the imitation then: without the gripper, what costs least may be to push the object about."""
    keep_carried: bool = True
    """an abstraction that drops what is shown to be carried is tried after all others, likely or not."""
    reformulate: bool = True
    """false: each skill as it was first stated, pose alone; what Algorithm 1 adds is then missing."""
    formulations: int = Field(default=12, ge=1)
    """formulations tried in a session, over all segments, before it is given up."""
