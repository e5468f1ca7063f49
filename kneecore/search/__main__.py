"""``python -m kneecore.search``: the two most different models within bounds."""

from kneecore._command import run_command

if __name__ == "__main__":
    raise SystemExit(run_command("search"))
