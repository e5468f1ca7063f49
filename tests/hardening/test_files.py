"""The rows of files, in short."""

from hardening.rows import SHORT
from hardening.rows_files import mutated_files


def test_changed_files_are_refused_in_a_line_or_read_as_what_they_say():
    outcome = mutated_files(SHORT)
    assert outcome.sound, outcome.happened
