"""The tab that tells what the session has brought."""
