"""The cycle by subject: scanning, parts, planning, approval, sending, outcomes."""
