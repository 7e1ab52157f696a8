"""The message to a person whose browser has sent something that the page does not offer."""

REFUSED = "Refused"

FAILED = "Internal error"

FILE_REFUSED = (
    "The file was not taken: this button is not available now, or the file name contains "
    "characters that are not allowed."
)

SECONDS_TO_READ = 8.0
