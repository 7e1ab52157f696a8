"""Tab Cycle: scan, find, plan, approve, send."""
