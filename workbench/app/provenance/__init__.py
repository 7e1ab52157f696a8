"""What ran: software, machine, cell and people as they were at a start, and what differs since.

May import model and formats.
"""
