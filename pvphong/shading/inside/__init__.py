"""What colours do between vertices."""
