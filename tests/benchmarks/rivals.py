"""The rivals that the benchmarks run beside: plain, fair, and written the way one would."""

from collections.abc import Callable

import numba
import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import RBFInterpolator

from kneecore.knee.physics import dynamics, forces, lanes
from kneecore.knee.physics.pose import START_X, START_Y
from kneecore.numerics.surrogate import Surrogate

Objective = Callable[[np.ndarray], np.ndarray]


def interpolated(interpolator: RBFInterpolator, n_dimensions: int) -> Objective:
    """The pair objective on SciPy's interpolator."""

    def value(x: np.ndarray) -> np.ndarray:
        y = interpolator(x.reshape(-1, n_dimensions)).reshape(len(x), 2, -1)
        return np.abs(y[:, 0] - y[:, 1]).sum(axis=1)

    return value


def matrix_product(surrogate: Surrogate, n_values: int) -> Objective:
    """The pair objective in NumPy at its best: distances by one matrix product.

    Only the difference of both models is contracted; arrays are worked on in place. Run it on one
    BLAS thread: with two it is slower.
    """
    d = surrogate.n_dimensions
    centres, weights = surrogate.centres[:, :d], surrogate.weights[:n_values].T
    tail, twice = surrogate.tail[:n_values, :d].T, -2.0 * surrogate.centres[:, :d].T
    squares = (centres**2).sum(axis=1)

    def value(x: np.ndarray) -> np.ndarray:
        points = x.reshape(-1, d)
        q = points @ twice
        q += np.einsum("ij,ij->i", points, points)[:, None]
        q += squares
        np.maximum(q, 1e-300, out=q)
        phi = np.log(q)
        phi *= q
        y = (phi[0::2] - phi[1::2]) @ weights
        y += (points[0::2] - points[1::2]) @ tail
        return np.abs(y, out=y).sum(axis=1)

    return value


def numpy_search(
    value: Objective, n_dimensions: int, pop_size: int, n_generations: int, seed: int
) -> tuple[float, np.ndarray]:
    """The paper's genetic algorithm in NumPy: no compiled code of ours."""
    rng = np.random.default_rng(seed)
    d = 2 * n_dimensions
    n_elite, n_mutation = pop_size // 10, pop_size // 5
    n_crossover = pop_size - n_elite - n_mutation
    chances = 2.0 * (1.0 - np.arange(pop_size) / (pop_size - 1)) / pop_size
    chances /= chances.sum()
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
def _acceleration(row, moment, x, y, psi, vx, vy, omega):
    """Return the accelerations of the tibia: the equations of motion, for one model."""
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
    return (fx + gx) / forces.MASS, (fy + gy) / forces.MASS, (m + g) / forces.INERTIA


@numba.njit(error_model="numpy", fastmath={"contract"})
def _scalar_run(row: np.ndarray, sign: float, turns: np.ndarray) -> None:
    """One run, one model at a time: the arithmetic of the lanes without the lanes."""
    x, y, psi = row[START_X], row[START_Y], 0.0
    vx = vy = omega = 0.0
    dt = lanes.TIME_STEP
    for plateau in range(6):
        moment = sign * dynamics.MOMENTS[plateau]
        for _ in range(dynamics.PLATEAU_STEPS[plateau]):
            ax, ay, alpha = _acceleration(row, moment, x, y, psi, vx, vy, omega)
            vx, vy, omega = vx + dt * ax, vy + dt * ay, omega + dt * alpha
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
    return forces.THETA_0 - turns


@numba.njit(error_model="numpy")
def _rate(_time, state, row, moment):
    """The right-hand side as `solve_ivp` wants it; compiled, which is more than most would do."""
    x, y, psi, vx, vy, omega = state
    ax, ay, alpha = _acceleration(row, moment, x, y, psi, vx, vy, omega)
    return np.array([vx, vy, omega, ax, ay, alpha])


def solve_ivp_flexion(rows: np.ndarray, method: str = "LSODA") -> np.ndarray:
    """Flexion angles (rad) by SciPy's `solve_ivp`, shape (n, 36) -> (n, 12).

    The moment is constant on each plateau, and so each is integrated by itself. Tolerances of 1e-7
    and 1e-9 keep its own error below that of the 4 ms steps, which it is compared with.
    """
    turns = np.empty((len(rows), 12))
    for model, row in enumerate(rows):
        for direction, sign in enumerate((1.0, -1.0)):
            state = np.array([row[START_X], row[START_Y], 0.0, 0.0, 0.0, 0.0])
            for plateau in range(6):
                seconds = lanes.TIME_STEP * dynamics.PLATEAU_STEPS[plateau]
                moment = sign * dynamics.MOMENTS[plateau]
                run = solve_ivp(_rate, (0.0, seconds), state, method, [seconds], args=(row, moment),
                                rtol=1e-7, atol=1e-9)  # fmt: skip
                state = run.y[:, -1]
                turns[model, 6 * direction + plateau] = state[2]
    return forces.THETA_0 - turns
