"""How long the very first start takes, with an empty cache of kernels, for a user and a visitor::

    python tests/benchmarks/first_start.py
    python tests/benchmarks/first_start.py --against ../another/checkout

Both cores of a two-core machine must be idle for the times; the CPU seconds (Linux) hold on a busy
one too, but for some tenths. With another checkout its times are taken in turn.
"""

import argparse
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY / "tests")]

from viz.websocket_client import WebSocketClient  # noqa: E402

FIRST, EXACT = "first search (surrogate)", "first exact search"
SEARCHES = {FIRST: [], EXACT: ["--method", "exact"], "help": ["--help"]}


def environment(checkout, cache):
    """Return the environment in which `checkout` is run with its kernels in `cache`."""
    return os.environ | {"NUMBA_CACHE_DIR": cache, "PYTHONPATH": str(checkout)}


def search_seconds(checkout, cache, options):
    """Return the wall time of a search, s."""
    command = [sys.executable, "-m", "kneecore.search", "--quiet", *options]
    start = time.perf_counter()
    subprocess.run(
        command, cwd=checkout, env=environment(checkout, cache), check=True, capture_output=True
    )
    return time.perf_counter() - start


def search_cpu_seconds(checkout, cache, options):
    """Return the CPU time of a search on one core, where no second process helps, s."""
    command = [sys.executable, "-m", "kneecore.search", "--quiet", *options]
    process = subprocess.Popen(
        command,
        cwd=checkout,
        env=environment(checkout, cache),
        stdout=subprocess.DEVNULL,
        preexec_fn=lambda: os.sched_setaffinity(0, {min(os.sched_getaffinity(0))}),
    )
    usage = os.wait4(process.pid, 0)[2]
    return usage.ru_utime + usage.ru_stime


def cpu_seconds(process):
    """Return the CPU time of a process that runs, s."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def children(process):
    """Return the processes that a process has started."""
    tasks = Path(f"/proc/{process}/task").iterdir()
    return [int(child) for task in tasks for child in (task / "children").read_text().split()]


def turned(client):
    """Tell whether the animated knee has turned for a few frames."""
    return client.counts.get("SetOrientationMessage", 0) >= 5


def fitted(client):
    """Tell whether the surrogate's training curves are drawn: a search can be started."""
    return any(len(p.get("data") or ()) > 40 for p in client.props.values())


def page_seconds(checkout, cache):
    """Return the times from the start to the moving knee and to the fitted surrogate, s."""
    start = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "kneeviz", "--no-browser", "--port", "0"],
        cwd=checkout,
        env=environment(checkout, cache) | {"PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        text=True,
    )
    times = {}
    try:
        line = next(line for line in process.stdout if "kneeviz: http" in line)
        times["page: address printed"] = time.perf_counter() - start
        with WebSocketClient(int(re.search(r":(\d+)", line)[1])) as client:
            for name, seen in {"page: knee moves": turned, "page: search ready": fitted}.items():
                client.wait(seen, 120)
                times[name] = time.perf_counter() - start
                times[f"{name}, CPU s here"] = cpu_seconds(process.pid)
                helpers = sum(map(cpu_seconds, children(process.pid)))
                times[f"{name}, CPU s in the second process"] = helpers
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(60)
        process.stdout.close()
    return times


def measured(checkout):
    """Return every time of one checkout, each from an empty cache, s."""
    times = {}
    for name, options in SEARCHES.items():
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as cache:
            times[name] = search_seconds(checkout, cache, options)
            if not options:
                times["second search"] = search_seconds(checkout, cache, options)
    for name in (FIRST, EXACT):
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as cache:
            times[f"{name}, CPU s on one core"] = search_cpu_seconds(
                checkout, cache, SEARCHES[name]
            )
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as cache:
        times |= page_seconds(checkout, cache)
    return times


def main():
    """Print a table of the best times of each checkout."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--against", type=Path, help="another checkout, measured in turn")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    checkouts = [REPOSITORY, *([options.against.resolve()] if options.against else [])]
    runs = {checkout: [] for checkout in checkouts}
    for _ in range(options.repeats):
        for checkout in checkouts:
            runs[checkout].append(measured(checkout))
    print(f"| best of {options.repeats}, s | " + " | ".join(c.name for c in checkouts) + " |")
    print("|---|" + "---|" * len(checkouts))
    for name in runs[REPOSITORY][0]:
        best = [min(run[name] for run in runs[checkout]) for checkout in checkouts]
        print(f"| {name} | " + " | ".join(f"{seconds:.2f}" for seconds in best) + " |")


if __name__ == "__main__":
    main()
