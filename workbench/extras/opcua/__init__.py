"""OPC UA server for PLCs."""
