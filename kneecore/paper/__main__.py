"""``python -m kneecore.paper``: the paper redone and judged claim by claim."""

from kneecore._command import run_command

if __name__ == "__main__":
    raise SystemExit(run_command("paper"))
