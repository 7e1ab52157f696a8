"""The cell as OPC UA for Robotics (OPC 40010-1) has it: types by a table, one system filled.

Imports nothing of the server; what it needs of asyncua comes with the extra `opcua`.
"""
