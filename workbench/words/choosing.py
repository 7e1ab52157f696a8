"""Which language somebody reads."""

from workbench.words.catalogs import LANGUAGES
from workbench.words.words import ENGLISH

LONGEST_HEADER = 1000


def first_guess(accepted: str) -> str:
    """The language that a browser likes best of those that there are.

    Args:
        accepted: its header Accept-Language (RFC 9110, section 12.5.4).
    """
    liked: list[tuple[float, str]] = []
    for entry in accepted[:LONGEST_HEADER].split(","):
        name, _, weight = entry.strip().partition(";")
        language = name.strip().lower().partition("-")[0]
        try:
            liked.append((float(weight.strip().removeprefix("q=") or 1), language))
        except ValueError:
            continue
    # The first of those that are liked as much.
    for weight, language in sorted(liked, key=lambda choice: -choice[0]):
        if language in LANGUAGES and weight > 0:
            return language
    return ENGLISH


def find_language(language: str) -> str:
    """A language by its code, or an empty text for one that there is not."""
    return language if language in LANGUAGES else ""
