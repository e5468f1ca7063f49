"""Measure everything in `cases` and `quality` and write it as tables::

    python -m pip install ".[bench]"            # the libraries that are compared with
    python tests/benchmarks/table.py            # print
    python tests/benchmarks/table.py README.md  # and put it between the README's speed marks

Takes some minutes, and says on stderr how far it is. Times are the best of a few (medians in
`quality`), ours and the rival's in turn in one run. Machines differ and are noisy: the ratio is
what counts.
"""

import os
import platform
import sys
import time
from importlib.metadata import version
from pathlib import Path

import cases
import peers
import quality

BEGIN, END = "<!-- speed: begin -->", "<!-- speed: end -->"
LIBRARIES = ("numpy", "scipy", "numba", "pymoo", "deap", "SALib")


def seconds(call):
    start = time.perf_counter()
    result = call()
    return time.perf_counter() - start, result


def processor():
    for line in Path("/proc/cpuinfo").read_text().splitlines() if os.name == "posix" else ():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def shown(value):
    if value < 0.1:
        return f"{1e3 * value:.1f} ms"
    return f"{value:.2f} s" if value < 10.0 else f"{value:,.0f} s"


def measured(case):
    """Return the best times of ours and the rival's, taken in turn, and how far they agree."""
    if case.repeats > 1:  # kernels are compiled, or loaded, outside of the measurement
        case.ours()
    rival_repeats = case.repeats if case.rival_repeats is None else case.rival_repeats
    if case.rival is not None and rival_repeats > 1:
        case.rival()
    ours, theirs, agreement = [], [], ""
    for turn in range(case.repeats):
        ours.append(seconds(case.ours))
        if case.rival is not None and turn < rival_repeats:
            theirs.append(seconds(case.rival))
    if case.agreement is not None:
        agreement = case.agreement(ours[-1][1], theirs[-1][1])
    best = min(t for t, _ in theirs) / case.rival_share if theirs else None
    return min(t for t, _ in ours), best, agreement


def speed_row(case):
    ours, theirs, agreement = measured(case)
    time_ = shown(ours)
    if case.items:
        time_ += f" ({1e6 * ours / case.items:.1f} us each)"
    rival = f"{shown(theirs)}: {case.rival_name}" if theirs else ""
    if agreement:
        rival += f"; {agreement}"
    ratio = f"{theirs / ours:,.{0 if theirs > 100.0 * ours else 1}f}" if theirs else ""
    return f"| {case.name} | {time_} | {rival} | {ratio} | {case.elsewhere} |"


def speed_table():
    lines = ["| what | time | rival in the same run | times faster | reported elsewhere |"]
    lines.append("|---|---|---|---|---|")
    for number, case in enumerate(cases.CASES, start=1):
        lines.append(speed_row(case))
        print(f"{number}/{len(cases.CASES)} {lines[-1]}", file=sys.stderr, flush=True)
    return lines


def machine():
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return f"{processor()}, {os.cpu_count()} cores, Python {platform.python_version()}, {libraries}"


def write(path, text):
    """Put `text` between the marks of the file at `path`; all of it or nothing."""
    old = path.read_text(encoding="utf-8")
    before, after = old.split(BEGIN)[0], old.split(END)[1]
    new = path.with_name(path.name + ".new")
    new.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")
    new.replace(path)


def check(arguments):
    """Return the file to write to, if any; raise before minutes are spent."""
    for name in ("pymoo", "deap", "SALib"):
        peers.imported(name)
    if not arguments:
        return None
    path = Path(arguments[0])
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    if len(arguments) > 1 or text.count(BEGIN) != 1 or text.count(END) != 1:
        raise ValueError(f"one file with one {BEGIN} and one {END} is allowed, not {arguments}")
    return path


def report():
    about = (
        f"On {machine()}; written by `python tests/benchmarks/table.py README.md`, after "
        '`python -m pip install ".[bench]"`. The best of a few runs; machines are noisy, so the '
        "ratio is what counts."
    )
    searches = (
        f"Search quality and cost: all in the same surrogate with the same {len(quality.SEEDS)} "
        f"seeds and at most {quality.BUDGET:,} pairs (a library may finish its last generation). "
        "SciPy, DEAP and pymoo get our compiled objective on whole generations; "
        "`tests/benchmarks/peers.py` has their settings. f is computed again in double precision; "
        "times are medians."
    )
    options = "A loss is in per cent of the best f that any of them found."
    return "\n".join(
        [about, "", *speed_table(), "", searches, "", *quality.search_table(shown), "", options, "",
         *quality.options_table()]
    )  # fmt: skip


def main():
    try:
        path = check(sys.argv[1:])
    except (peers.PeerMissingError, ValueError) as error:
        sys.exit(f"table.py: {error}")
    text = report()
    print(text)
    if path is not None:
        write(path, text)


if __name__ == "__main__":
    main()
