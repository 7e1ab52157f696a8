"""The bin in a scan: where it is, its surfaces and size, how full it is."""
