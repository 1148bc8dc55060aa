"""The evidence of one set of regressors: Laplace's approximation around its best fit.

-2 log p(y | M) = chi2 + theta' S^-2 theta + log det(I + S J'J S), theta the linear sizes and the
nonlinear ones, S their prior spreads, readings whitened and counted by their effective number
(MacKay 2003, Information Theory, Inference and Learning Algorithms, chapter 28). Linear sizes are
solved for at each value of the nonlinear ones (variable projection, Golub and Pereyra 1973).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import ndtr

from deltactl.diagnosis.evidence.effective_size import TemperedNoise
from deltactl.diagnosis.evidence.explanation import Explanation, Point, side_by_side
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.evidence.scalar_products import Block, Products, Target, left_of
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Columns, Regressor, Size


class Laplace:
    """Evaluates sets of regressors of one plant under one noise; remembers what it evaluated."""

    def __init__(
        self,
        plant: RegressionPlant,
        noise: TemperedNoise,
        before: Laplace | None = None,
        alike: Laplace | None = None,
    ):
        """before: the same under an earlier noise, whose sizes are where the fits begin. alike: of
        another plant under the same noise, which may have some of the columns.
        """
        self.plant, self.noise, self._before = plant, noise, before
        self.by_key: dict[str, Regressor] = {r.key: r for r in plant.regressors}
        self._free = plant.free()
        self._tolerated = tolerated(plant)
        self._known: dict[frozenset[str], Explanation] = {}
        self._blocks: dict[str, tuple[Columns, Block]] = alike._blocks if alike else {}
        self._products: Products = alike._products if alike else Products()
        self._targets: dict[int, Target] = {}

    @property
    def evaluated(self) -> list[Explanation]:
        """Every set that was evaluated."""
        return list(self._known.values())

    def __call__(self, keys: Iterable[str], start_from: Sequence[Explanation] = ()) -> Explanation:
        """The best fit of a set; starts: from explanations of parts of it, and of more than it."""
        wanted = frozenset(keys)
        if wanted not in self._known:
            self._known[wanted] = self._best(wanted, start_from)
        elif (found := self._cheaper(wanted, start_from)) is not None:
            self._known[wanted] = found
        return self._known[wanted]

    def _cheaper(
        self, keys: frozenset[str], start_from: Sequence[Explanation]
    ) -> Explanation | None:
        """A fit of a known set that begins where a larger set ended; None where none is better.

        Else a set seems to need what only helped its fit to a better minimum.
        """
        known, moved = self._known[keys], self._moved(keys)
        points = [_less(part, keys) for part in start_from if part.keys > keys and moved]
        if not points or not np.isfinite(known.log_evidence):
            return None
        costs = [self._solve(keys, point)[0] for point in points]
        if min(costs) > known.penalised - EVIDENCE.fit_gain:
            return None
        _, point = self._descend(keys, points[int(np.argmin(costs))], moved)
        return self.at(keys, point)

    def _best(self, keys: frozenset[str], start_from: Sequence[Explanation]) -> Explanation:
        begins: list[Point] = []
        if self._before is not None and keys in self._before._known:
            begins.append(self._before(keys).sizes)
        else:
            parts: list[Explanation | None] = [part for part in start_from if part.keys <= keys]
            begins += [self._beginning(keys, part) for part in parts or [None]]
        begins += [_less(part, keys) for part in start_from if part.keys > keys]
        moved = self._moved(keys)
        if not moved:
            return self.at(keys, begins[0])
        apart = {tuple(sorted(point.items())) for point in begins}
        fits = [self._descend(keys, dict(point), moved) for point in sorted(apart)]
        return self.at(keys, min(fits, key=lambda fit: fit[0])[1])

    def _beginning(self, keys: frozenset[str], part: Explanation | None) -> Point:
        """The cheapest start of a set, part of which may be known.

        What is new joins one regressor after another, in the plant's order: after each, the
        cheapest few go on (a beam search). All combinations would be thousands.
        """
        points: list[Point] = [{} if part is None else dict(part.sizes)]
        new = [
            key
            for key in self.by_key
            if key in keys and self.by_key[key].sizes and (part is None or key not in part.keys)
        ]
        if not new:
            return points[0]
        nominal = self.plant.base(frozenset(), {})
        left = self.plant.observed - nominal if part is None else part.residual
        for number, key in enumerate(new):
            starts = self._with_none_of_it(key, self.plant.starts(key, left))
            points = [{**point, **start} for point in points for start in starts]
            if len(points) > 1:
                costs = [self._solve(keys - set(new[number + 1 :]), point)[0] for point in points]
                points = [points[i] for i in np.argsort(costs)[: EVIDENCE.starts_kept]]
        return points[0]

    def _moved(self, keys: frozenset[str]) -> list[tuple[str, Size]]:
        return [
            (f"{key}.{size.name}", size)
            for key in sorted(keys)
            for size in self.by_key[key].sizes
            if size.smooth
        ]

    def _with_none_of_it(self, key: str, starts: Sequence[Point]) -> list[Point]:
        """The starts of a regressor, and one at which it does nothing.

        A set that may begin where a part of it ended never fits worse than that part. A size that
        the starts leave out begins as it usually is.
        """
        halves = [size for size in self.by_key[key].sizes if size.smooth and size.prior == "half"]
        usual = {f"{key}.{size.name}": size.spread for size in halves}
        nothing = {f"{key}.{size.name}": size.low for size in halves}
        more = [{**starts[0], **nothing}] if halves and starts else []
        return [*({**usual, **start} for start in starts), *more]

    def _descend(
        self, keys: frozenset[str], point: Point, moved: list[tuple[str, Size]]
    ) -> tuple[float, Point]:
        """Damped Gauss-Newton in the nonlinear sizes, within their bounds."""
        cost, left = self._solve(keys, point)
        damping = 1e-2
        for _ in range(EVIDENCE.most_fit_steps):
            slopes = np.stack([self._slope(keys, point, left, m) for m in moved], axis=1)
            gradient, gram = slopes.T @ left, slopes.T @ slopes
            scale = np.diag(gram) + 1e-12
            able = _able(point, moved, gradient)
            for _ in range(5):
                step = np.zeros(len(moved))
                damped = (gram + damping * np.diag(scale))[np.ix_(able, able)]
                step[able] = -np.linalg.solve(damped, gradient[able])
                new = self._stepped(point, moved, step)
                new_cost, new_left = self._solve(keys, new)
                if new_cost < cost:
                    break
                damping *= 6.0
            else:
                return cost, point
            gained, cost, point, left = cost - new_cost, new_cost, new, new_left
            damping = max(damping / 10.0, 1e-6)
            if gained < EVIDENCE.fit_gain:
                break
        return cost, point

    @staticmethod
    def _stepped(point: Point, moved: list[tuple[str, Size]], step: FloatArray) -> Point:
        new = dict(point)
        for (name, size), change in zip(moved, step, strict=True):
            at = new[name] + float(np.clip(change, -0.5, 0.5)) * size.spread
            new[name] = float(np.clip(at, size.low, size.high))
        return new

    def _slope(
        self, keys: frozenset[str], point: Point, left: FloatArray, moved: tuple[str, Size]
    ) -> FloatArray:
        """Change of the projected residual per prior spread of one nonlinear size."""
        name, size = moved
        step = size.step if point[name] + size.step <= size.high else -size.step
        _, other = self._solve(keys, {**point, name: point[name] + step})
        return (other - left) * (size.spread / step)

    def _solve(self, keys: frozenset[str], point: Point) -> tuple[float, FloatArray]:
        """Penalised cost and the vector (m + p + q,) whose square it is."""
        target, blocks = self._whitened(keys, point)
        theta, _, _ = self._most_probable(target, blocks, self._taken(keys))
        white = left_of(target.white, [shape for _, shape in blocks], theta)
        left = np.concatenate([white, theta, self._penalties(keys, point)])
        return float(left @ left), left

    def _penalties(self, keys: frozenset[str], point: Point) -> FloatArray:
        """Half-normal sizes of a set, (q,), each in its prior spread."""
        sizes = [(point[name], size) for name, size in self._moved(keys)]
        return np.array([at / size.spread for at, size in sizes if size.prior == "half"])

    def _columns(self, keys: frozenset[str], base: FloatArray, point: Point) -> list[Columns]:
        return [self._free, *(self.plant.columns(key, base, point) for key in sorted(keys))]

    def _taken(self, keys: frozenset[str]) -> IntArray:
        """Columns of the tolerances that the regressors of a set take over."""
        taken = {self.by_key[key].takes_over for key in keys} - {""}
        return np.flatnonzero(np.array([name in taken for name in self._free.names], dtype=bool))

    def _whitened(self, keys: frozenset[str], point: Point) -> tuple[Target, list[Block]]:
        base = self.plant.base(keys, point)
        target = self._target(base)
        columns = zip(("", *sorted(keys)), self._columns(keys, base, point), strict=True)
        return target, [self._block(key, c) for key, c in columns if c.values.shape[1]]

    def _target(self, base: FloatArray) -> Target:
        """The model error by a base; most sets share one, or one of a few."""
        target = self._targets.get(id(base))
        if target is None:
            target = Target(base, self.noise.whiten(self.plant.observed - base))
            last = list(self._targets.items())[1 - EVIDENCE.targets_kept :]
            self._targets = {**dict(last), id(base): target}
        return target

    def _block(self, key: str, columns: Columns) -> Block:
        """Whitened columns times their spreads; kept, since most are the same at every point."""
        kept = self._blocks.get(key)
        if kept is None or kept[0] is not columns:
            kept = (columns, (key, self.noise.whiten(columns.values) * columns.spread))
            self._blocks[key] = kept
        return kept[1]

    def _most_probable(
        self, target: Target, blocks: list[Block], taken: IntArray
    ) -> tuple[FloatArray, float, FloatArray]:
        """Linear sizes (p,) in their prior spread, penalised cost, and inverse covariance."""
        share, gram = target.share(blocks), self._gram(blocks, taken)
        share[taken] = 0.0
        gram[np.diag_indices_from(gram)] += 1.0
        theta = self._within_tolerance(gram, share)
        return theta, target.power - float(theta @ (2.0 * share - gram @ theta)), gram

    def _gram(self, blocks: list[Block], taken: IntArray) -> FloatArray:
        """Scalar products (p, p) of all columns but those taken over."""
        gram = self._products.of(blocks)
        gram[taken] = gram[:, taken] = 0.0
        return gram

    def _within_tolerance(self, gram: FloatArray, share: FloatArray) -> FloatArray:
        """Sizes (p,) that minimise the cost while tolerances stay within what machines have."""
        theta: FloatArray = np.linalg.solve(gram, share)
        most = np.concatenate([self._tolerated, np.full(len(theta) - len(self._tolerated), np.inf)])
        beyond = np.abs(theta) > most
        if beyond.any():
            theta[beyond] = np.clip(theta[beyond], -most[beyond], most[beyond])
            rest = ~beyond
            known = share[rest] - gram[np.ix_(rest, beyond)] @ theta[beyond]
            theta[rest] = np.linalg.solve(gram[np.ix_(rest, rest)], known)
        return theta

    def at(self, keys: frozenset[str], point: Point) -> Explanation:
        """A set with its nonlinear sizes as they are known."""
        target, blocks = self._whitened(keys, point)
        base = target.base
        columns = dict(zip(("", *sorted(keys)), self._columns(keys, base, point), strict=True))
        taken = self._taken(keys)
        theta, cost, known = self._most_probable(target, blocks, taken)
        shapes = [shape for _, shape in blocks]
        if moved := self._moved(keys):
            _, whole = self._solve(keys, point)
            slopes = [self._slope(keys, point, whole, m)[: len(target.white)] for m in moved]
            shapes += [slope[:, None] for slope in slopes]
            tangent = side_by_side(len(target.white), shapes, taken)
            gram = tangent.T @ tangent
            known = np.eye(tangent.shape[1]) + gram
        spreads = np.concatenate([c.spread for c in columns.values()])
        ends = np.cumsum([len(c.spread) for c in columns.values()])[:-1]
        linear = dict(zip(columns, np.split(theta * spreads, ends), strict=True))
        names = [f"{key}.{name}" for key, c in columns.items() for name in c.sizes]
        names += [name for name, _ in moved]
        priors = float(np.sum(self._penalties(keys, point) ** 2))
        penalised = cost + priors
        occam = float(np.linalg.slogdet(known)[1])
        odds = self._odds(keys, point)
        if self.plant.impossible(keys, point, linear) or not np.isfinite(penalised + occam):
            odds, penalised, occam = -np.inf, 0.0, 0.0  # values no number can hold: no evidence
        volume = self._chosen(keys) - self._within(point, known, moved)
        charged = 0.0
        if self.plant.is_messy(keys):
            gains = self._gains(target, blocks, taken, known)
            charged = self._charged(keys, gains, penalised)
        return Explanation(
            keys=keys, found=self._found(keys, point, linear),
            sizes=point, linear=linear, base=base,
            parts=tuple((c.values, linear[key]) for key, c in columns.items() if len(c.spread)),
            observed=self.plant.observed, chi2=cost - float(theta @ theta), penalised=penalised,
            log_evidence=odds - 0.5 * (penalised + occam + volume + charged), charged=charged,
            shapes=tuple(shapes), taken=taken, names=tuple(names),
            spreads=np.concatenate([spreads, [size.spread for _, size in moved]]),
            target=target.white, theta=theta,
            products=lambda: gram if moved else self._gram(blocks, taken),
        )  # fmt: skip

    def _charged(self, keys: frozenset[str], gains: dict[str, float], penalised: float) -> float:
        """Chi-square that is no evidence for a set.

        gains: what each regressor adds by its sizes. penalised: cost of the set.
        """
        for key in sorted(keys & self.plant.sizeless):  # all of it is in the base
            gains[key] = max(self(keys - {key}).penalised - penalised, 0.0)
        return self.plant.charged(gains)

    def _gains(
        self, target: Target, blocks: list[Block], taken: IntArray, known: FloatArray
    ) -> dict[str, float]:
        """Chi-square that each regressor adds to those that do more.

        known: inverse covariance (p, p) of the sizes of the set.
        """
        share = target.share(blocks)
        share[taken] = 0.0
        ends = np.cumsum([0, *(shape.shape[1] for _, shape in blocks)])
        parts = {key: slice(a, b) for (key, _), a, b in zip(blocks, ends, ends[1:], strict=False)}
        gains: dict[str, float] = {}
        within = np.arange(len(share)) < self.plant.nuisances
        gram, along = known[np.ix_(within, within)], share[within]
        left = target.power - float(along @ np.linalg.solve(gram, along))
        for key in sorted(parts, key=self.plant.power, reverse=True):
            within[parts[key]] = True
            gram, along = known[np.ix_(within, within)], share[within]
            free = within[parts[""]].all()
            size = self._within_tolerance(gram, along) if free else np.linalg.solve(gram, along)
            rest = target.power - float(size @ (2.0 * along - gram @ size))
            # tolerances at their bounds may fit worse than none
            gains[key], left = max(left - rest, 0.0), rest
        return gains

    def at_most(self, keys: frozenset[str]) -> float:
        """What the log evidence of a set is at most: nothing charged, no tolerance at its bound.

        Infinite for a plant with nonlinear sizes; the columns of any other are the same everywhere.
        """
        if not self._linear:
            return math.inf
        (target, blocks), taken = self._whitened(keys, {}), self._taken(keys)
        known = self._gram(blocks, taken)
        known[np.diag_indices_from(known)] += 1.0
        share = target.share(blocks)
        share[taken] = 0.0
        root = np.linalg.cholesky(known)
        explained = solve_triangular(root, share, lower=True, check_finite=False)
        cost = target.power - float(explained @ explained)
        occam = 2.0 * float(np.sum(np.log(np.diag(root))))
        return self._odds(keys, {}) - 0.5 * (cost + occam)

    @cached_property
    def _linear(self) -> bool:
        return not any(one.sizes for one in self.by_key.values())

    def _odds(self, keys: frozenset[str], point: Point) -> float:
        """Log prior odds of a set; rows it calls silent are as improbable as rows with noise."""
        odds = sum(self.by_key[key].log_odds for key in sorted(keys))
        silent = self.plant.without_noise(keys, point)
        if silent is None:
            return odds
        noise = self.noise.scale * self.noise.sigma
        return odds - 0.5 * float(np.sum(noise[silent[self.noise.rows]] ** 2))

    def _chosen(self, keys: frozenset[str]) -> float:
        """2 log of how many values the sizes of a set could have that are chosen, not fitted."""
        sizes = (size for key in keys for size in self.by_key[key].sizes)
        return sum(2.0 * math.log(size.choices) for size in sizes if not size.smooth)

    def _found(
        self, keys: frozenset[str], point: Point, linear: dict[str, FloatArray]
    ) -> frozenset[str]:
        """Those of a set that are larger than on any machine as built."""
        found, built_so = set(), set()
        for key in keys:
            regressor = self.by_key[key]
            if not regressor.as_built and not regressor.built_so:
                found.add(key)
                continue
            sizes = [*linear[key], *(point[f"{key}.{size.name}"] for size in regressor.sizes)]
            size = float(np.linalg.norm(sizes) if regressor.unknown else np.abs(sizes).sum())
            if size > regressor.as_built:
                found.add(key)
            if size <= regressor.built_so:
                built_so.add(key)
        return frozenset(found - built_so or found)

    @staticmethod
    def _within(point: Point, known: FloatArray, moved: list[tuple[str, Size]]) -> float:
        """2 log of how much of each half-normal size's Gaussian lies above zero, doubled."""
        if not moved:
            return 0.0
        own = np.sqrt(np.diag(np.linalg.inv(known)))[-len(moved) :]
        total = 0.0
        for (name, size), spread in zip(moved, own, strict=True):
            if size.prior == "half":
                total += 2.0 * np.log(2.0 * ndtr(point[name] / (size.spread * spread)))
        return float(total)


def tolerated(plant: RegressionPlant) -> FloatArray:
    """Prior spreads (k,) within which each free column stays: beyond, the regressor that takes it
    over is a finding, whose place a stretched tolerance would take.
    """
    bounded = {r.takes_over for r in plant.regressors}
    free = plant.free()
    names = free.names or ("",) * len(free.spread)
    return np.array([EVIDENCE.tolerated if name and name in bounded else np.inf for name in names])


def _able(point: Point, moved: list[tuple[str, Size]], gradient: FloatArray) -> BoolArray:
    """Which sizes may move, (k,): one at its bound that would go beyond it stays there, and what
    others do for it has to be theirs.
    """
    at = np.array([point[name] for name, _ in moved])
    low, high = np.array([[size.low, size.high] for _, size in moved]).T
    stuck: BoolArray = ((at <= low) & (gradient > 0.0)) | ((at >= high) & (gradient < 0.0))
    return ~stuck


def _less(explanation: Explanation, keys: frozenset[str]) -> Point:
    """The nonlinear sizes that a smaller set has of an explanation."""
    sizes = explanation.sizes
    return {name: size for name, size in sizes.items() if name.rpartition(".")[0] in keys}
