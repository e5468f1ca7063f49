"""Commands called in the test's own process, which has the kernels loaded."""


def called(capsys, main, *arguments):
    """Call a command's `main`; return its exit code, stdout and stderr."""
    try:
        code = main(list(arguments))
    except SystemExit as stop:
        code = stop.code
    printed = capsys.readouterr()
    return code, printed.out, printed.err
