"""One formulation learned: trials → update → convergence → P, as a generator of events.

Robust: after each batch of trials the successful ones compete on a few perturbed starts and the winner's
P(β = 1 | π) is estimated on many. The mean policy goes on being improved until a winner is all but sure, the
mean has converged, or the trials are used up; then the best winner is judged by α. Faithful: the mean policy
alone is judged, when its cost has converged.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imitate.events import Converged, Evaluated, Event, PolicyUpdated, Purpose, TrialFinished
from imitate.geometry import Array
from imitate.learning.option import Success
from imitate.learning.problem import Problem, cost_of, failure_of, immediate_costs
from imitate.learning.trials import Task, Trials, perturbed_starts
from imitate.policy.dmp import response
from imitate.policy.pi2 import constant_update, noise_factor, per_kernel_update
from imitate.record import Start
from imitate.settings import Settings
from imitate.skill import CostTerms, Policy
from imitate.world.trial import Outcome


@dataclass(frozen=True)
class Learned:
    """What became of a formulation.

    Attributes:
        policy: the best found, accepted or not.
        cost: of its trial from the shown start.
        success: over the perturbed starts.
        accepted: P ≥ α.
        why: what most starts failed of, in words; empty where none did.
    """

    policy: Policy
    cost: float
    success: Success
    accepted: bool
    why: str


@dataclass(frozen=True, eq=False)
class _Tried:
    policy: Policy
    event: TrialFinished

    @property
    def cost(self) -> float:
        return self.event.cost.total


class Improvement:
    """The learning of one formulation; `run` is its course."""

    def __init__(
        self,
        problem: Problem,
        prefix: tuple[Policy, ...],
        mean: Policy,
        trials: Trials,
        seed: np.random.SeedSequence,
    ) -> None:
        self.problem = problem
        self.prefix = prefix
        self.mean = mean
        self.trials = trials
        self.settings: Settings = trials.settings
        self.seed = seed
        self.count = 0
        self.update = 0
        self.tried: list[_Tried] = []
        self.competed: list[_Tried] = []
        self.best: Learned | None = None

    def run(self, shown: Start) -> Generator[Event, None, Learned]:
        """Learns; yields what happens and returns what came of it."""
        start = yield from self._prepare(shown)
        s = self.settings.learning
        means: list[float] = []
        if s.imitation_first:
            tried = yield from self._explore(start, [self.mean])
            means.append(tried[0].cost)
            learned = yield from self._compete()
            if learned is not None:
                return learned
        for self.update in range(s.updates):
            batch = self._batch()
            tried = yield from self._explore(start, batch)
            learned = yield from self._compete()
            if learned is not None:
                return learned
            if batch[0] is self.mean:
                means.append(tried[0].cost)
            if self._converged(means):
                yield Converged(*self._id, self.update, f"two costs in a row within {s.converged_below:g}")
                break
            yield self._improve()
        return (yield from self._last_word())

    @property
    def _succeeded(self) -> bool:
        return any(tried.event.success for tried in self.tried)

    def _value(self, tried: _Tried) -> float:
        # Holding still costs no switches: until a trial succeeds, they would teach it to do nothing.
        terminal_alone = self.settings.learning.terminal_first and not self._succeeded
        return tried.event.cost.terminal if terminal_alone else tried.cost

    @property
    def _id(self) -> tuple[int, int]:
        f = self.problem.formulation
        return f.segment, f.index

    def _seed(self, *key: int) -> np.random.SeedSequence:
        return np.random.SeedSequence(self.seed.entropy, spawn_key=(*self._id, *key))

    def _prepare(self, shown: Start) -> Generator[Event, None, Start]:
        # Exploration starts where the accepted options end from the shown start, at rest.
        if not self.prefix:
            return shown
        outcome = next(self.trials.run([Task(shown, self.prefix)]))
        yield self._event(outcome, "prepare", self.prefix)
        record = outcome.record
        return Start(record.joint_positions[-1], record.object_poses[-1], float(record.commands[-1, -1]))

    def _batch(self) -> list[Policy]:
        s = self.settings.learning
        rng = np.random.default_rng(self._seed(0, self.update))
        if not self.update:
            return [self._sample(rng) for _ in range(s.first_rollouts - len(self.tried))]
        return [self.mean, *(self._sample(rng) for _ in range(s.rollouts - 1))]

    def _sample(self, rng: np.random.Generator) -> Policy:
        s, mean = self.settings.learning, self.mean
        narrowing = self._succeeded or not s.terminal_first
        factor = noise_factor(self.update, s.updates, s.least_noise) if narrowing else 1.0
        spread = s.pose_noise * np.abs(mean.pose_weights).mean(axis=0)
        pose = factor * spread * rng.standard_normal(mean.pose_weights.shape)
        gripper = factor * s.gripper_noise * rng.standard_normal(mean.gripper_weights.shape)
        if s.exploration == "per-kernel":
            return replace(mean, pose_noise=pose, gripper_noise=gripper)
        return replace(
            mean,
            pose_weights=mean.pose_weights + pose,
            gripper_weights=mean.gripper_weights + gripper,
        )

    def _explore(self, start: Start, batch: Sequence[Policy]) -> Generator[Event, None, list[_Tried]]:
        found: list[_Tried] = []
        for policy, outcome in zip(batch, self.trials.run([Task(start, (p,)) for p in batch]), strict=True):
            event = self._event(outcome, "explore", (policy,))
            yield event
            found.append(_Tried(policy, event))
        self.tried.extend(found)
        return found

    def _event(self, outcome: Outcome, purpose: Purpose, policies: tuple[Policy, ...]) -> TrialFinished:
        s = self.settings.learning
        record, unreachable = outcome.record, outcome.unreachable
        if purpose == "prepare":
            cost, failure = CostTerms(0.0, 0.0, 0.0), unreachable
        else:
            cost = cost_of(self.problem, record, bool(unreachable), s)
            failure = failure_of(self.problem, record, unreachable, cost, s)
        trial, self.count = self.count, self.count + 1
        return TrialFinished(
            *self._id, trial, purpose, self.update, policies, cost, not failure, failure, record
        )

    def _compete(self) -> Generator[Event, None, Learned | None]:
        # The successful trials that have not competed yet do so on perturbed starts; the winner is judged.
        s = self.settings.learning
        new = [t for t in self.tried if t.event.success and t not in self.competed]
        new = sorted(new, key=lambda t: t.cost)[: s.candidates + 1] if s.candidates else []
        fits = []
        for tried in new:
            starts = perturbed_starts(self.trials.spec, s.candidate_starts, self._seed(1), self.settings)
            events = yield from self._evaluate(tried.policy, starts, "choose")
            failed = sum(not e.success for e in events)
            fits.append((failed, sum(e.cost.total for e in events)))
        self.competed += new
        if not fits or min(fits)[0]:
            return None
        winner = new[fits.index(min(fits))]
        success, why = yield from self._success_of(winner)
        sure = success.rate >= max(s.sure, s.alpha)
        if self.best is None or success.rate > self.best.success.rate:
            self.best = Learned(winner.policy, winner.cost, success, success.rate >= s.alpha, why)
        yield self._evaluated(success, sure, winner.cost)
        return self.best if sure else None

    def _success_of(self, tried: _Tried) -> Generator[Event, None, tuple[Success, str]]:
        # P over the perturbed starts, and what most failures were.
        s = self.settings.learning
        starts = perturbed_starts(self.trials.spec, s.evaluation_starts, self._seed(2), self.settings)
        events = yield from self._evaluate(tried.policy, starts, "evaluate")
        reasons = [event.failure for event in events if event.failure]
        why = max(reasons, key=reasons.count) if reasons else ""
        return Success(len(events) - len(reasons), len(events)), why

    def _evaluated(self, success: Success, accepted: bool, cost: float) -> Evaluated:
        return Evaluated(*self._id, success.successes, success.trials, *success.interval, accepted, cost)

    def _evaluate(
        self, policy: Policy, starts: list[Start], purpose: Purpose
    ) -> Generator[Event, None, list[TrialFinished]]:
        policies = (*self.prefix, policy)
        events = []
        for outcome in self.trials.run([Task(start, policies) for start in starts]):
            event = self._event(outcome, purpose, policies)
            yield event
            events.append(event)
        return events

    def _converged(self, means: list[float]) -> bool:
        # A grasp happens or does not: until one does, costs that stay equal say nothing of the gripper. And a
        # policy that succeeds, if not often enough, is worth going on with.
        s = self.settings.learning
        acceptable = self.best is not None and self.best.accepted
        promising = self._succeeded or len(self.mean.gripper_weights) > 0
        if s.candidates and promising and not acceptable:
            return False
        return len(means) > 1 and abs(means[-1] - means[-2]) < s.converged_below

    def _improve(self) -> PolicyUpdated:
        s = self.settings.learning
        size = s.rollouts if self.update else s.first_rollouts
        earlier = sorted(self.tried[:-size], key=self._value)[: s.reused]
        used = earlier + self.tried[-size:]
        pose = np.array([t.policy.pose_weights - self.mean.pose_weights for t in used])
        gripper = np.array([t.policy.gripper_weights - self.mean.gripper_weights for t in used])
        if s.exploration == "per-kernel":
            pose += [_or_zero(t.policy.pose_noise, pose[0]) for t in used]
            gripper += [_or_zero(t.policy.gripper_noise, gripper[0]) for t in used]
            to_go = np.stack([self._cost_to_go(t) for t in used], axis=1)
            change = self._per_kernel(pose, to_go, self.settings.policy.phase_decay)
            squeeze = self._per_kernel(gripper[..., None], to_go, self.settings.policy.gripper_decay)[:, 0]
        else:
            costs = np.array([self._value(t) for t in used])
            change = constant_update(pose, costs, s.eliteness)
            squeeze = constant_update(gripper, costs, s.eliteness)
        self.mean = replace(
            self.mean,
            pose_weights=self.mean.pose_weights + change,
            gripper_weights=self.mean.gripper_weights + squeeze,
        )
        best = min(t.cost for t in used)
        return PolicyUpdated(*self._id, self.update + 1, self.mean, best)

    def _per_kernel(self, noise: Array, to_go: Array, decay: float) -> Array:
        if not noise.shape[1]:
            return np.zeros(noise.shape[1:])
        shape = response(len(to_go), noise.shape[1], decay, self.settings.policy.stiffness)
        return per_kernel_update(noise, to_go, shape.activations, self.settings.learning.eliteness)

    def _cost_to_go(self, tried: _Tried) -> Array:
        # S_i = φ_N + Σ_{j≥i} q_j over the movement; a trial cut short cost nothing more after its end.
        event, s = tried.event, self.settings
        assert event.record is not None
        acceleration, switches = immediate_costs(event.record, s.learning)
        ticks = round(tried.policy.duration * s.world.control_rate)
        immediate = np.zeros(max(ticks, len(acceleration)))
        immediate[: len(acceleration)] = acceleration + switches
        to_go = event.cost.terminal + np.cumsum(immediate[::-1])[::-1]
        return np.asarray(to_go[:ticks])

    def _last_word(self) -> Generator[Event, None, Learned]:
        # The best winner so far; without one, the best trial (robust) or the mean policy (faithful).
        s = self.settings.learning
        if self.best is None:
            chosen = (
                min(self.tried, key=lambda t: (not t.event.success, self._value(t)))
                if s.candidates
                else _Tried(self.mean, self.tried[-1].event)
            )
            success, why = yield from self._success_of(chosen)
            accepted = success.rate >= s.alpha
            self.best = Learned(chosen.policy, chosen.cost, success, accepted, why)
        yield self._evaluated(self.best.success, self.best.accepted, self.best.cost)
        return self.best


def _or_zero(noise: Array, like: Array) -> Array:
    return noise if len(noise) else np.zeros_like(like)
