"""State, commands and rules: what happened, who did it, and what may happen next."""
