"""An append-only record that knows no command: SQLite rows and content-addressed files."""
