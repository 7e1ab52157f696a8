"""What browsers and programs reach: logins, the relay to the page, the HTTP interface."""
