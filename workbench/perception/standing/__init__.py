"""Parts that stand in an assembly, found again in a scan near their believed poses."""
