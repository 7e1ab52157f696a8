"""The tab that runs a cycle: scan, find, plan, approve, send."""
