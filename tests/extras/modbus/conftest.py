"""The site whose bench these tests ask."""

from api_site import heartbeat, people, results, site  # noqa: F401
