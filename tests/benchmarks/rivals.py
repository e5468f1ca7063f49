"""The rivals that the benchmarks run beside: plain, fair, and written the way one would."""

import math

import numba
import numpy as np
from scipy.interpolate import RBFInterpolator

from kneecore.model import dynamics, forces
from kneecore.model.pose import START_X, START_Y


def numpy_search(
    interpolator: RBFInterpolator, n_dimensions: int, pop_size: int, n_generations: int, seed: int
) -> tuple[float, np.ndarray]:
    """The paper's genetic algorithm in NumPy on SciPy's interpolator: no compiled code of ours."""
    rng = np.random.default_rng(seed)
    d = 2 * n_dimensions
    n_elite, n_mutation = pop_size // 10, pop_size // 5
    n_crossover = pop_size - n_elite - n_mutation
    chances = 2.0 * (1.0 - np.arange(pop_size) / (pop_size - 1)) / pop_size
    chances /= chances.sum()

    def value(x: np.ndarray) -> np.ndarray:
        y = interpolator(x.reshape(-1, n_dimensions)).reshape(len(x), 2, -1)
        return np.abs(y[:, 0] - y[:, 1]).sum(axis=1)

    population = rng.random((pop_size, d))
    values = value(population)
    for generation in range(n_generations):
        order = np.argsort(-values)
        population, values = population[order], values[order]
        mothers = population[rng.choice(pop_size, n_crossover, p=chances)]
        fathers = population[rng.choice(pop_size, n_crossover, p=chances)]
        low, width = np.minimum(mothers, fathers), np.abs(mothers - fathers)
        crossed = low - 0.5 * width + rng.random((n_crossover, d)) * 2.0 * width
        mutated = population[rng.choice(pop_size, n_mutation, p=chances)].copy()
        bound = (rng.random(mutated.shape) < 0.5).astype(float)
        shrink = 1.0 - rng.random(mutated.shape) ** ((1.0 - generation / n_generations) ** 5)
        chosen = rng.random(mutated.shape) < 0.05
        mutated = np.where(chosen, mutated + shrink * (bound - mutated), mutated)
        children = np.clip(np.vstack([crossed, mutated]), 0.0, 1.0)
        population = np.vstack([population[:n_elite], children])
        values = np.concatenate([values[:n_elite], value(children)])
    best = int(np.argmax(values))
    return float(values[best]), population[best]


@numba.njit(error_model="numpy", fastmath={"contract"})
def _scalar_run(row: np.ndarray, sign: float, turns: np.ndarray) -> None:
    """One run, one model at a time: the arithmetic of the lanes without the lanes."""
    x, y, psi = row[START_X], row[START_Y], 0.0
    vx = vy = omega = 0.0
    dt = dynamics.TIME_STEP
    for plateau in range(6):
        moment = sign * dynamics.MOMENTS[plateau]
        for _ in range(dynamics.PLATEAU_STEPS[plateau]):
            s, c = forces.sin_cos(psi)
            fx, fy = -forces.LINEAR_DAMPING * vx, -forces.LINEAR_DAMPING * vy
            m = moment - forces.ANGULAR_DAMPING * omega
            for i in range(4):
                a = 6 * i
                gx, gy, g = forces.ligament_pull(
                    row[a], row[a + 1], row[a + 2], row[a + 3], row[a + 4], row[a + 5], x, y, s, c
                )
                fx, fy, m = fx + gx, fy + gy, m + g
            gx, gy, g, _force, _delta = forces.contact_push(
                row[24], row[25], row[26], row[28], row[29], row[27], row[30], x, y, s, c
            )
            vx += dt / forces.MASS * (fx + gx)
            vy += dt / forces.MASS * (fy + gy)
            omega += dt / forces.INERTIA * (m + g)
            x, y, psi = x + dt * vx, y + dt * vy, psi + dt * omega
        turns[plateau] = psi


@numba.njit(error_model="numpy")
def _scalar_loop(rows: np.ndarray, turns: np.ndarray) -> None:
    for model in range(len(rows)):
        _scalar_run(rows[model], 1.0, turns[model, :6])
        _scalar_run(rows[model], -1.0, turns[model, 6:])


def scalar_flexion(rows: np.ndarray) -> np.ndarray:
    """Flexion angles (rad) by the scalar loop, shape (n, 36) -> (n, 12)."""
    turns = np.empty((len(rows), 12))
    _scalar_loop(rows, turns)
    return math.radians(54.79) - turns
