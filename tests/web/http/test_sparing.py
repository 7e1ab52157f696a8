"""Lines of the log that come too often are left out, and counted."""

import logging

from workbench.web.http.sparing import AT_ONCE, MOST_KINDS, SECONDS, Sparing, sparing


def line(form, *args):
    return logging.LogRecord("name", logging.WARNING, "path", 1, form, args, None)


def spare(now):
    return Sparing(AT_ONCE, lambda: now[0])


def test_a_flood_is_cut_to_what_may_come_at_once_and_told_later():
    now = [0.0]
    spares = spare(now)
    assert [spares.filter(line("refused %d", n)) for n in range(AT_ONCE + 3)] == (
        [True] * AT_ONCE + [False] * 3
    )
    now[0] = SECONDS
    late = line("refused %d", 9)
    assert spares.filter(late)
    assert late.getMessage() == "refused 9 (3 lines like this were left out before)"
    assert not spares.filter(line("refused %d", 9))


def test_one_kind_does_not_silence_another():
    spares = spare([0.0])
    while spares.filter(line("refused a: %s", "x")):
        pass
    assert spares.filter(line("refused b: %s", "x"))


def test_lines_that_are_never_the_same_are_cut_too():
    spares = spare([0.0])
    passed = [spares.filter(line(f"at {number}")) for number in range(1000)]
    assert sum(passed) == MOST_KINDS + AT_ONCE


def test_loggers_are_sparing_for_a_while_only():
    logger = logging.getLogger("workbench.web")
    with sparing(), sparing():
        assert len(logger.filters) == 2
    assert not logger.filters
