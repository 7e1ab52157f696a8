"""The site that all these tests ask."""

from api_site import heartbeat, people, results, site  # noqa: F401
