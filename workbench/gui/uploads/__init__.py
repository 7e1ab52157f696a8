"""CAD files that people send from their machine: chosen, and told before they are taken."""
