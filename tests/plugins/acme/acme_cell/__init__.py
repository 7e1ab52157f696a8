"""Everything of Acme that Workbench can use."""
