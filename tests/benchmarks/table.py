"""Measure everything in `cases` and write it as a table::

    python tests/benchmarks/table.py            # print
    python tests/benchmarks/table.py README.md  # and put it between the README's speed marks

Times are the best of a few, ours and the rival's in turn in one run. Machines differ and are noisy:
the ratio is what counts.
"""

import os
import platform
import sys
import time
from pathlib import Path

import cases
import numba
import numpy as np
import scipy

BEGIN, END = "<!-- speed: begin -->", "<!-- speed: end -->"


def seconds(call):
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def processor():
    for line in Path("/proc/cpuinfo").read_text().splitlines() if os.name == "posix" else ():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def shown(value):
    if value < 0.1:
        return f"{1e3 * value:.1f} ms"
    return f"{value:.2f} s"


def measured(case):
    """Return the best times of ours and the rival's, taken in turn."""
    if case.repeats > 1:  # kernels are compiled, or loaded, outside of the measurement
        case.ours()
    if case.rival is not None:
        case.rival()
    ours, theirs = [], []
    for _ in range(case.repeats):
        ours.append(seconds(case.ours))
        if case.rival is not None:
            theirs.append(seconds(case.rival))
    return min(ours), min(theirs) if theirs else None


def speed_table():
    lines = ["| what | time | rival in the same run | times faster | reported elsewhere |"]
    lines.append("|---|---|---|---|---|")
    for case in cases.CASES:
        ours, theirs = measured(case)
        rival = f"{shown(theirs)}: {case.rival_name}" if theirs else ""
        ratio = f"{theirs / ours:.1f}" if theirs else ""
        lines.append(f"| {case.name} | {shown(ours)} | {rival} | {ratio} | {case.elsewhere} |")
        print(lines[-1], file=sys.stderr, flush=True)
    return lines


def quality_table():
    seeds = range(20)
    big = {n: [cases.surrogate_search(options=o, seed=s).value for s in seeds] for n, o in
           cases.OPTIONS.items()}  # fmt: skip
    small = {n: [cases.surrogate_search(100, 100, options=o, seed=s).value for s in seeds] for n, o
             in cases.OPTIONS.items()}  # fmt: skip
    best = max(max(values) for values in big.values())
    lines = ["| genetic algorithm, 20 seeds | 200 x 800: mean loss | 100 x 100: mean loss |"]
    lines.append("|---|---|---|")
    for name in cases.OPTIONS:
        losses = [100.0 * (1.0 - np.mean(v[name]) / best) for v in (big, small)]
        lines.append(f"| {name} | {losses[0]:.2f} % | {losses[1]:.2f} % |")
    return lines


def main():
    about = (
        f"On {processor()}, {os.cpu_count()} cores, Python {platform.python_version()}, numpy "
        f"{np.__version__}, scipy {scipy.__version__}, numba {numba.__version__}; written by "
        "`python tests/benchmarks/table.py README.md`. The best of a few runs; machines are noisy, "
        "so the ratio is what counts. A loss is in per cent of the best f that any of them found."
    )
    text = "\n".join([about, "", *speed_table(), "", *quality_table()])
    print(text)
    if len(sys.argv) > 1:
        path = Path(sys.argv[1])
        old = path.read_text(encoding="utf-8")
        before, after = old.split(BEGIN)[0], old.split(END)[1]
        path.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
