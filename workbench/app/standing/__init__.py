"""Parts that stand in an assembly: where a scan shows them, and which views can."""
