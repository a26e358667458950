"""One formulation learned: trials → update → convergence → P, as a generator of events.

Robust: after each batch of trials the successful ones compete on a few perturbed starts, and the P(β = 1 | π)
of a winner that succeeds on α of them is estimated on many. The mean policy goes on being improved until a
winner succeeds firmly, the mean has converged, or the trials are used up; then the best winner is judged by
α, on new starts. Faithful: the mean policy alone is judged, when its cost has converged.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import replace

import numpy as np

from imitate.events import Converged, Event, PolicyUpdated, Skipped, TrialFinished
from imitate.learning.aim import better_aimed, corrected, shifted
from imitate.learning.exploration import adapted, first_spread, improved, sample
from imitate.learning.option import Success
from imitate.learning.problem import Problem
from imitate.learning.runs import Learned, Row, Runs
from imitate.learning.starts import perturbed_starts
from imitate.learning.trials import Trials
from imitate.policy.pi2 import noise_factor
from imitate.record import Start
from imitate.settings import Settings
from imitate.skill import Policy


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
        # Where the hand takes hold is the goal of the skill before.
        joint = trials.settings.learning.grasp_noise and "gripper" in problem.formulation.actions
        given = len(prefix) - 1 if joint and prefix else len(prefix)
        self.runs = Runs(problem, prefix[:given], trials, seed)
        self.mean: Row = (*prefix[given:], mean)
        self.spec = trials.spec
        self.spread = first_spread(mean, trials.settings)
        self.settings: Settings = trials.settings
        self.tried: list[TrialFinished] = []
        self.competed: set[int] = set()
        self.contested = Success(0, 0)  # the best that a trial's policy did in competing, and what was tried
        self.runner_up: Row | None = None
        self.best: Learned | None = None
        self.skipped = False

    def run(self, shown: Start) -> Generator[Event, None, Learned]:
        """Learns; yields what happens and returns what came of it."""
        start = yield from self.runs.prepare(shown)
        s = self.settings.learning
        means: list[float] = []
        if s.imitation_first:
            means.append((yield from self._explore(start, [self.mean])))
            learned = yield from self._compete()
            if learned is not None:
                return learned
        for self.runs.update in range(s.updates + s.more_updates):
            if self.runs.update >= s.updates and not self._near:
                break
            batch = self._batch()
            first_cost = yield from self._explore(start, batch)
            learned = yield from self._compete()
            if learned is not None:
                return learned
            if self.runs.skip():
                self.skipped = True
                yield Skipped(*self.runs.id, self.runs.count)
                break
            if batch[0] is self.mean:
                means.append(first_cost)
            if self._converged(means):
                yield Converged(
                    *self.runs.id, self.runs.update, f"two costs in a row within {s.converged_below:g}"
                )
                break
            yield self._improve()
        return (yield from self._last_word())

    @property
    def _succeeded(self) -> bool:
        return any(tried.success for tried in self.tried)

    @property
    def _near(self) -> bool:
        # The starts tried do not tell whether P reaches α.
        low, high = (self.best.success if self.best else self.contested).interval
        return self._succeeded and low <= self.settings.learning.alpha <= high

    def _value(self, tried: TrialFinished) -> float:
        # Holding still costs no switches: until a trial succeeds, they would teach it to do nothing.
        by = self.settings.learning.improve_by
        terminal_alone = by == "terminal" or (by == "terminal-first" and not self._succeeded)
        return tried.cost.terminal if terminal_alone else tried.cost.total

    def _batch(self) -> list[Row]:
        s = self.settings.learning
        narrowing = self._succeeded or s.improve_by == "total"
        factor = noise_factor(self.runs.update, s.updates, s.least_noise) if narrowing else 1.0
        rng = np.random.default_rng(self.runs.seed(0, self.runs.update))
        count = s.rollouts if self.runs.update else s.first_rollouts - len(self.tried)
        batch = [self.mean] * (self.runs.update > 0) + self._corrected()
        return [*batch, *(self._near_mean(rng, factor) for _ in range(count - len(batch)))]

    def _near_mean(self, rng: np.random.Generator, factor: float) -> Row:
        *before, mean = self.mean
        policy = sample(mean, rng, factor, self.settings, self.spread)
        return (*(shifted(p, rng, factor * self.settings.learning.grasp_noise) for p in before), policy)

    def _corrected(self) -> list[Row]:
        # Of the best trial so far, that of which the body came nearest.
        s = self.settings.learning
        if not (s.correct_goals and self.tried):
            return []
        best = min(self.tried, key=lambda t: (not t.success, t.cost.terminal))
        assert best.believed is not None
        policy = corrected(self.runs.problem, best.policies[-1], best.believed, s)
        return [(*best.policies[:-1], policy)] if policy else []

    def _explore(self, start: Start, batch: Sequence[Row]) -> Generator[Event, None, float]:
        # Returns the cost of the batch's first trial, which is the mean policy's from the second batch on.
        done = yield from self.runs.explore(start, batch)
        self.tried += done
        return done[0].cost.total

    def _compete(self) -> Generator[Event, None, Learned | None]:
        # The successful trials that have not competed yet do so on perturbed starts; the winner is judged.
        s = self.settings.learning
        new = [t for t in self.tried if t.success and t.trial not in self.competed]
        new = sorted(new, key=lambda t: t.cost.total)[: s.candidates + 1] if s.candidates else []
        if not new:
            return None
        starts = perturbed_starts(self.spec, s.candidate_starts, self.runs.seed(1), self.settings)
        fits = []
        for events in (yield from self.runs.choose([tried.policies for tried in new], starts)):
            failed = sum(not e.success for e in events)
            fits.append((failed, -self.runs.firm(events), sum(e.cost.total for e in events)))
        self.competed |= {tried.trial for tried in new}
        winner = new[fits.index(min(fits))].policies
        won = Success(s.candidate_starts - min(fits)[0], s.candidate_starts)
        if won.rate > self.contested.rate:
            self.contested, self.runner_up = won, winner
        if won.rate < s.alpha:
            return None
        judged = yield from self.runs.judge(winner)
        sure = judged.accepted and judged.firm >= s.sure and judged.fair >= s.safe
        yield self.runs.evaluated(replace(judged, accepted=sure))
        if self.best is None or _merit(judged) > _merit(self.best):
            self.best = judged
        return judged if sure else None

    def _converged(self, means: list[float]) -> bool:
        # A grasp happens or does not: costs that stay equal say nothing of the gripper before it does, and
        # little of how firm it is after. A policy that succeeds, if not often enough, is worth going on with.
        s = self.settings.learning
        grips = len(self.mean[-1].gripper_weights) > 0
        enough = s.safe if grips else s.alpha
        acceptable = self.best is not None and self.best.success.rate >= enough
        promising = self._succeeded or grips
        if s.candidates and promising and not acceptable:
            return False
        return len(means) > 1 and abs(means[-1] - means[-2]) < s.converged_below

    def _improve(self) -> PolicyUpdated:
        s = self.settings.learning
        size = s.rollouts if self.runs.update else s.first_rollouts
        earlier = sorted(self.tried[:-size], key=self._value)[: s.reused]
        used = earlier + self.tried[-size:]
        costs = [self._value(tried) for tried in used]
        *others, before = self.mean
        tried = zip(*(t.policies[:-1] for t in used), strict=True)
        h = self.settings.learning.eliteness
        others = [better_aimed(p, t, np.array(costs), h) for p, t in zip(others, tried, strict=True)]
        self.mean = (*others, improved(before, used, costs, self.settings))
        self.spread = adapted(self.spread, before, used, costs, self.settings)
        return PolicyUpdated(
            *self.runs.id, self.runs.update + 1, self.mean[-1], min(t.cost.total for t in used)
        )

    def _last_word(self) -> Generator[Event, None, Learned]:
        # The best winner so far, judged once more, on starts by which it was not chosen; without one, who
        # came nearest, else the best trial (robust), or the mean policy (faithful).
        if self.best is not None:
            if not self.skipped:
                self.best = yield from self.runs.judge(self.best.row, afresh=True, last=True)
        else:
            best = min(self.tried, key=lambda t: (not t.success, self._value(t)))
            robust = self.settings.learning.candidates > 0
            row = (self.runner_up or best.policies) if robust else self.mean
            self.best = yield from self.runs.judge(row, last=True)
        if self.skipped:
            self.best = replace(self.best, accepted=False)
        yield self.runs.evaluated(self.best)
        return self.best


def _merit(learned: Learned) -> tuple[bool, float, float]:
    return learned.accepted, learned.firm, learned.success.rate
