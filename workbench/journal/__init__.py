"""An append-only record of what happened: bytes in, bytes out; it knows no command."""
